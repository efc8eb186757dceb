# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers run a trajectory, and which part of it each of them gets."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import combinations

from armsim_ros.config.move_group.moveit_controllers import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'
_MOST_CONTROLLERS = 6


def controlled_joints(joint_names: Iterable[str], robot: RobotModel) -> tuple[str, ...]:
    """
    Return the joints that a controller has to move: not fixed, no mimic, not passive.

    :raises PlanningError: CONTROL_FAILED for a joint that the robot lacks, or where none is
        left.
    """
    names = tuple(joint_names)
    for name in names:
        if name not in robot.joints:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"the trajectory names joint '{name}', which robot '{robot.name}' lacks; "
                f'{nearest(name, robot.active_joints) or ", ".join(robot.active_joints)}',
                _SOURCE,
            )
    passive = robot.semantic.passive_joints
    found = tuple(
        name for name in names if robot.joints[name].active and name not in passive
    )
    if not found:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the trajectory names no joint that a controller could move: [ {" ".join(names)} ]',
            _SOURCE,
        )
    return found


def select_controllers(
    joints: Collection[str], controllers: Sequence[MoveItControllerSettings], *,
    names: Collection[str] = (), active: Collection[str] | None = None,
) -> tuple[MoveItControllerSettings, ...]:
    """
    Return the controllers that together move all joints.

    The fewest that share no joint; among these the one with more default controllers, then
    fewer surplus joints, then more that are active already.

    :param joints: as :func:`controlled_joints` returns them.
    :param names: controllers that may be used; empty for all.
    :param active: names of the controllers that run; None where all do.
    :raises PlanningError: CONTROL_FAILED with the joints and the known controllers.
    """
    wanted = frozenset(joints)
    usable = _named(controllers, names)
    candidates = [each for each in usable if wanted & set(each.joints)]
    for count in range(1, min(len(candidates), _MOST_CONTROLLERS) + 1):
        fitting = [
            chosen for chosen in combinations(candidates, count) if _covers(chosen, wanted)
        ]
        if fitting:
            return max(fitting, key=lambda chosen: _merit(chosen, wanted, active))
    missing = sorted(wanted - {joint for each in usable for joint in each.joints})
    remedy = (
        f'no controller has {", ".join(missing)}: add them to the joints of a controller in '
        'moveit_controllers.yaml or controllers_gazebo.yaml'
        if missing else 'the controllers that have them share joints: give each joint to one'
    )
    raise PlanningError(
        MoveItErrorCode.CONTROL_FAILED,
        'Unable to identify any set of controllers that can actuate the specified joints: '
        f'[ {" ".join(sorted(wanted))} ]\nKnown controllers and their joints:\n'
        f'{_listing(usable)}\n{remedy}',
        _SOURCE,
    )


def _named(
    controllers: Sequence[MoveItControllerSettings], names: Collection[str]
) -> list[MoveItControllerSettings]:
    known = [each.name for each in controllers]
    for name in names:
        if name not in known:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{name}' is not known; {nearest(name, known)} known: "
                f'{", ".join(known) or "none"}', _SOURCE,
            )
    return [each for each in controllers if not names or each.name in names]


def _covers(chosen: Sequence[MoveItControllerSettings], wanted: frozenset[str]) -> bool:
    joints = [joint for each in chosen for joint in each.joints]
    return len(joints) == len(set(joints)) and wanted <= set(joints)


def _merit(
    chosen: Sequence[MoveItControllerSettings], wanted: frozenset[str],
    active: Collection[str] | None,
) -> tuple[int, int, int]:
    surplus = sum(len(set(each.joints) - wanted) for each in chosen)
    running = sum(active is None or each.name in active for each in chosen)
    return sum(each.default for each in chosen), -surplus, running


def _listing(controllers: Sequence[MoveItControllerSettings]) -> str:
    lines = [
        f"controller '{each.name}' controls joints: {', '.join(each.joints)}"
        for each in controllers
    ]
    return '\n'.join(lines) or 'none'


def split_trajectory(
    trajectory: JointTrajectory, selected: Sequence[MoveItControllerSettings]
) -> list[tuple[MoveItControllerSettings, JointTrajectory]]:
    """
    Return for each controller the part of a trajectory with its joints, at the same times.

    :param trajectory: without a fault.
    """
    return [
        (controller, trajectory.of_joints(
            [name for name in trajectory.joint_names if name in controller.joints]))
        for controller in selected
    ]


def coverage_report(
    robot: RobotModel, controllers: Sequence[MoveItControllerSettings]
) -> list[str]:
    """
    Return a sentence for each planning group that the controllers cannot move as a whole.

    :returns: each names the joints that are missing and the YAML that adds them.
    """
    report = []
    for name, group in robot.semantic.groups.items():
        if not group.active_joints:
            continue
        try:
            select_controllers(group.active_joints, controllers)
        except PlanningError:
            covered = {joint for each in controllers for joint in each.joints}
            missing = [joint for joint in group.active_joints if joint not in covered]
            if missing:
                report.append(
                    f"planning group '{name}' can be planned for but not moved: no controller "
                    f'has {", ".join(missing)}; add to the controllers\' file:\n'
                    f'  - name: {name}_controller\n    action_ns: follow_joint_trajectory\n'
                    '    type: FollowJointTrajectory\n    default: true\n'
                    f'    joints: [{", ".join(missing)}]'
                )
            else:
                report.append(
                    f"planning group '{name}' can be planned for but not moved: its controllers "
                    'share joints; give each joint to one controller only'
                )
    return report
