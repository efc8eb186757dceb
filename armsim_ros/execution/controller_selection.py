# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers run a trajectory, and which part of it each of them gets."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import combinations

from armsim_ros.config.move_group.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.execution.multi_dof import multi_dof_joints
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'
_MOST_CONTROLLERS = 6


def controlled_joints(joint_names: Iterable[str], robot: RobotModel) -> tuple[str, ...]:
    """
    Return the joints that a controller has to move: not fixed, no mimic, not passive.

    :param joint_names: multi-DOF joints and their variables too.
    :raises PlanningError: CONTROL_FAILED for a joint that the robot lacks, or where none is
        left.
    """
    names = tuple(joint_names)
    several = multi_dof_joints(robot)
    variables = {*several, *(variable for each in several.values() for variable in each)}
    for name in names:
        if name not in robot.joints and name not in variables:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"the trajectory names joint '{name}', which robot '{robot.name}' lacks; "
                f'{nearest(name, robot.active_joints) or ", ".join(robot.active_joints)}',
                _SOURCE,
            )
    passive = robot.semantic.passive_joints
    found = tuple(
        name for name in names
        if name not in passive and (name in variables or robot.joints[name].active)
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
    names: Sequence[str] = (), active: Collection[str] | None = None, manages: bool = False,
) -> tuple[MoveItControllerSettings, ...]:
    """
    Return the controllers that together move all joints.

    The fewest that share no joint; among these the combination with more default controllers, then
    fewer joints, then more that are active already, then by name. Where inactive ones cannot be
    activated, active ones go before fewer.

    :param joints: as :func:`controlled_joints` returns them.
    :param names: controllers that may be used; empty for all.
    :param active: names of the controllers that run; None where all do.
    :param manages: whether inactive controllers can be activated.
    :raises PlanningError: CONTROL_FAILED with the joints and the known controllers.
    """
    requested = frozenset(joints)
    usable = _named(controllers, names)
    candidates = [each for each in usable if requested & set(each.joints)]
    fewest: tuple[MoveItControllerSettings, ...] = ()
    for count in range(1, min(len(candidates), _MOST_CONTROLLERS) + 1):
        chosen = _best(candidates, count, requested, active, manages)
        if chosen and (manages or _all_active(chosen, active)):
            return chosen
        fewest = fewest or chosen
    if fewest:
        return fewest
    missing = sorted(requested - {joint for each in usable for joint in each.joints})
    remedy = (
        f'no controller has {", ".join(missing)}: add them to the joints of a controller in '
        'moveit_controllers.yaml or controllers_gazebo.yaml'
        if missing else
        'the controllers that have them share joints: give each joint to one controller only'
    )
    raise PlanningError(
        MoveItErrorCode.CONTROL_FAILED,
        'Unable to identify any set of controllers that can actuate the specified joints: '
        f'[ {" ".join(sorted(requested))} ]\nKnown controllers and their joints:\n'
        f'{_listing(usable)}\n{remedy}',
        _SOURCE,
    )


def _best(
    candidates: Sequence[MoveItControllerSettings], count: int, requested: frozenset[str],
    active: Collection[str] | None, manages: bool,
) -> tuple[MoveItControllerSettings, ...]:
    """Return the best combination of so many controllers, empty where none moves all joints."""
    fitting = sorted(
        (chosen for chosen in combinations(candidates, count) if _covers(chosen, requested)),
        key=lambda chosen: _demerit(chosen, active))
    running = [] if manages else [combination for combination in fitting
                                  if _all_active(combination, active)]
    return next(iter((*running, *fitting)), ())


def _named(
    controllers: Sequence[MoveItControllerSettings], names: Sequence[str]
) -> list[MoveItControllerSettings]:
    known = {each.name: each for each in controllers}
    for name in names:
        if name not in known:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{name}' is not known; {nearest(name, list(known))} known: "
                f'{", ".join(known) or "none"}', _SOURCE,
            )
    return [known[name] for name in dict.fromkeys(names or sorted(known))]


def _covers(chosen: Sequence[MoveItControllerSettings], requested: frozenset[str]) -> bool:
    joints = [joint for each in chosen for joint in each.joints]
    return len(joints) == len(set(joints)) and requested <= set(joints)


def _demerit(
    chosen: Sequence[MoveItControllerSettings], active: Collection[str] | None
) -> tuple[int, int, int]:
    return (
        -sum(each.default for each in chosen), sum(len(each.joints) for each in chosen),
        -sum(active is None or each.name in active for each in chosen))


def _all_active(
    chosen: Sequence[MoveItControllerSettings], active: Collection[str] | None
) -> bool:
    return active is None or all(each.name in active for each in chosen)


def _listing(controllers: Sequence[MoveItControllerSettings]) -> str:
    lines = [
        f"controller '{each.name}' controls joints: {', '.join(each.joints)}"
        for each in controllers
    ]
    return '\n'.join(lines) or 'none'


def split_trajectory(
    trajectory: JointTrajectory, selected: Sequence[MoveItControllerSettings],
    velocity: float = 1.0,
) -> list[tuple[MoveItControllerSettings, JointTrajectory]]:
    """
    Return for each controller the part of a trajectory with its joints, at the same times.

    The joints of a part are in the order of the alphabet.

    :param trajectory: without a fault.
    :param velocity: factor of the velocities; the times stay as they are.
    """
    if trajectory.velocities is not None and velocity != 1.0:
        trajectory = replace(trajectory, velocities=trajectory.velocities * velocity)
    parts = []
    for controller in selected:
        names = sorted(name for name in trajectory.joint_names if name in controller.joints)
        parts.append((controller, trajectory.of_joints(names) if names else JointTrajectory(())))
    return parts


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
