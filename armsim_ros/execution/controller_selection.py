# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers run a trajectory; trajectories of joints with several degrees of freedom."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.model.robot_model import JointType, RobotModel
from armsim_ros.trajectory import JointTrajectory

_SOURCE = 'trajectory execution'


def actuated_joints(joint_names: Iterable[str], robot: RobotModel) -> tuple[str, ...]:
    """
    Return the joints that a controller has to move: not fixed, no mimic, not passive.

    :param joint_names: multi-DOF joints and their variables too; unknown names are left out.
    """
    moved = {*robot.active_joints, *_multi_dof_names(robot)} - set(robot.semantic.passive_joints)
    return tuple(name for name in joint_names if name in moved)


def controlled_joints(joint_names: Iterable[str], robot: RobotModel) -> tuple[str, ...]:
    """
    Return the joints of a trajectory that a controller has to move.

    :param joint_names: as of :func:`actuated_joints`.
    :raises PlanningError: CONTROL_FAILED for a joint that the robot lacks, or where none is
        left.
    """
    names = tuple(joint_names)
    several = _multi_dof_names(robot)
    for name in names:
        if name not in robot.joints and name not in several:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"the trajectory names joint '{name}', which robot '{robot.name}' lacks; "
                f'{nearest(name, robot.active_joints) or ", ".join(robot.active_joints)}',
                _SOURCE)
    found = actuated_joints(names, robot)
    if not found:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the trajectory names no joint that a controller could move: [ {" ".join(names)} ]',
            _SOURCE)
    return found


def actuated(trajectory: JointTrajectory, robot: RobotModel) -> JointTrajectory:
    """
    Return the trajectory of the joints that controllers have to move.

    :param trajectory: without a fault.
    :raises PlanningError: as :func:`controlled_joints`.
    """
    if not len(trajectory):
        return trajectory
    return trajectory.of_joints(controlled_joints(trajectory.joint_names, robot))


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
    order = {each.name: place for place, each in enumerate(usable)}

    def rank(chosen: Sequence[MoveItControllerSettings]) -> tuple[object, ...]:
        return (
            not (manages or _all_active(chosen, active)), len(chosen),
            -sum(each.default for each in chosen), sum(len(each.joints) for each in chosen),
            -sum(active is None or each.name in active for each in chosen),
            sorted(order[each.name] for each in chosen))

    best = min(_covers(usable, requested), key=rank, default=())
    if best:
        return best
    missing = sorted(requested - {joint for each in usable for joint in each.joints})
    remedy = (
        f'no controller has {", ".join(missing)}: add them to the joints of a controller in '
        'moveit_controllers.yaml or controllers_gazebo.yaml'
        if missing else
        'the controllers that have them share joints: give each joint to one controller only')
    raise PlanningError(
        MoveItErrorCode.CONTROL_FAILED,
        'Unable to identify any set of controllers that can actuate the specified joints: '
        f'[ {" ".join(sorted(requested))} ]\nKnown controllers and their joints:\n'
        f'{_listing(usable)}\n{remedy}',
        _SOURCE)


def _named(
    controllers: Sequence[MoveItControllerSettings], names: Sequence[str]
) -> list[MoveItControllerSettings]:
    known = {each.name: each for each in controllers}
    for name in names:
        if name not in known:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{name}' is not known; {nearest(name, list(known))} known: "
                f'{", ".join(known) or "none"}', _SOURCE)
    return [known[name] for name in dict.fromkeys(names or sorted(known))]


def _covers(
    candidates: Sequence[MoveItControllerSettings], joints: frozenset[str],
    chosen: tuple[MoveItControllerSettings, ...] = ()
) -> Iterator[tuple[MoveItControllerSettings, ...]]:
    """Yield all combinations that share no joint and that move these joints, none idle."""
    if not joints:
        yield chosen
        return
    rarest = min(sorted(joints), key=lambda name: sum(name in each.joints for each in candidates))
    for candidate in candidates:
        if rarest in candidate.joints:
            apart = [each for each in candidates if not set(each.joints) & set(candidate.joints)]
            yield from _covers(apart, joints - set(candidate.joints), (*chosen, candidate))


def _all_active(
    chosen: Sequence[MoveItControllerSettings], active: Collection[str] | None
) -> bool:
    return active is None or all(each.name in active for each in chosen)


def _listing(controllers: Sequence[MoveItControllerSettings]) -> str:
    lines = [
        f"controller '{each.name}' controls joints: {', '.join(each.joints)}"
        for each in controllers]
    return '\n'.join(lines) or 'none'


def split_trajectory(
    trajectory: JointTrajectory, selected: Sequence[MoveItControllerSettings],
    velocity: float = 1.0
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


def controller_parts(
    trajectory: JointTrajectory, robot: RobotModel, controllers: Sequence[MoveItControllerSettings]
) -> list[tuple[MoveItControllerSettings, JointTrajectory]]:
    """
    Return the controllers that move a trajectory, each with its part of it.

    :param trajectory: without a fault; joints that no controller has to move are left out.
    :raises PlanningError: as :func:`controlled_joints` and :func:`select_controllers`.
    """
    moved = actuated(trajectory, robot)
    return split_trajectory(moved, select_controllers(moved.joint_names, controllers))


def coverage_report(
    robot: RobotModel, controllers: Sequence[MoveItControllerSettings]
) -> list[str]:
    """
    Return a sentence for each planning group that the controllers cannot move as a whole.

    :returns: each names the joints that are missing and the YAML that adds them.
    """
    report = []
    for name in robot.semantic.groups:
        joints = robot.controlled_joints(name)
        if not joints:
            continue
        try:
            select_controllers(joints, controllers)
        except PlanningError:
            covered = {joint for each in controllers for joint in each.joints}
            missing = [joint for joint in joints if joint not in covered]
            if missing:
                report.append(
                    f"planning group '{name}' can be planned for but not moved: no controller "
                    f'has {", ".join(missing)}; add to the controllers\' file:\n'
                    f'  - name: {name}_controller\n    action_ns: follow_joint_trajectory\n'
                    '    type: FollowJointTrajectory\n    default: true\n'
                    f'    joints: [{", ".join(missing)}]')
            else:
                report.append(
                    f"planning group '{name}' can be planned for but not moved: its controllers "
                    'share joints; give each joint to one controller only')
    return report


#: Type of a joint -> its variables, in the order of a state.
VARIABLES = {
    JointType.PLANAR.value: ('x', 'y', 'theta'),
    JointType.FLOATING.value: (
        'trans_x', 'trans_y', 'trans_z', 'rot_x', 'rot_y', 'rot_z', 'rot_w'),
}


@dataclass(frozen=True, slots=True, eq=False)
class MultiDofTrajectory:
    """
    k waypoints of n joints that have several degrees of freedom each.

    :param joint_names: (n,).
    :param times: (k,) from the trajectory's start [s].
    :param transforms: (k, n, 7) position [m] and quaternion xyzw of each joint.
    :param velocities: (k, n, 6) linear [m/s] and angular [rad/s], None where not all are given.
    :param stamp_ns: [ns] when the trajectory starts; 0 is "as soon as it arrives".
    """

    joint_names: tuple[str, ...]
    times: Vector
    transforms: Matrix
    velocities: Matrix | None = None
    stamp_ns: int = 0

    def __len__(self) -> int:
        """Return the number of waypoints."""
        return len(self.times)

    @property
    def duration(self) -> float:
        """Time of the last waypoint [s], 0 for a trajectory without any."""
        return float(self.times[-1]) if len(self) else 0.0

    def of_joints(self, joint_names: Sequence[str], velocity: float = 1.0) -> MultiDofTrajectory:
        """Return the part of some of its joints, velocities multiplied by a factor."""
        columns = [self.joint_names.index(name) for name in joint_names]
        return replace(
            self, joint_names=tuple(joint_names), transforms=self.transforms[:, columns],
            velocities=None if self.velocities is None
            else self.velocities[:, columns] * velocity)


def multi_dof_joints(robot: RobotModel) -> dict[str, tuple[str, ...]]:
    """Return planar and floating joint -> names of its variables, the virtual joint among them."""
    virtual = robot.semantic.virtual_joint
    types = {name: joint.type.value for name, joint in robot.joints.items()}
    if virtual is not None:
        types[virtual.name] = virtual.type
    return {
        name: tuple(f'{name}/{variable}' for variable in VARIABLES[kind])
        for name, kind in types.items() if kind in VARIABLES}


def _multi_dof_names(robot: RobotModel) -> frozenset[str]:
    """Return the names of multi-DOF joints and of their variables."""
    several = multi_dof_joints(robot)
    return frozenset(several).union(*several.values())


def as_joint_trajectory(
    trajectory: JointTrajectory, multi_dof: MultiDofTrajectory, robot: RobotModel
) -> JointTrajectory:
    """
    Return a trajectory of joints and of the variables of multi-DOF joints; it starts at once.

    :param trajectory: of the same number of points, or without any.
    :raises PlanningError: CONTROL_FAILED where the two do not fit, or a joint is not known.
    """
    known = multi_dof_joints(robot)
    unknown = [name for name in multi_dof.joint_names if name not in known]
    if unknown or len(trajectory) not in (0, len(multi_dof)):
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f'the multi-DOF trajectory cannot be executed: it has {len(multi_dof)} points beside '
            f'{len(trajectory)} of the joints, and the joints '
            f'{", ".join(multi_dof.joint_names) or "none"}; multi-DOF joints of the robot: '
            f'{", ".join(known) or "none"}', 'trajectory execution')
    names = list(trajectory.joint_names) if len(trajectory) else []
    blocks = [trajectory.positions] if names else []
    for column, name in enumerate(multi_dof.joint_names):
        names += known[name]
        blocks.append(_variables(multi_dof.transforms[:, column], len(known[name])))
    return JointTrajectory(tuple(names), multi_dof.times, np.concatenate(blocks, axis=1))


def _variables(poses: Matrix, count: int) -> Matrix:
    """Return the variables (k, count) of a joint at poses (k, 7)."""
    if count == len(VARIABLES[JointType.FLOATING.value]):
        return poses
    x, y, z, w = poses[:, 3:].T
    theta = [math.atan2(2 * (d * c + a * b), 1 - 2 * (b * b + c * c))
             for a, b, c, d in zip(x, y, z, w, strict=True)]
    planar: Matrix = np.column_stack([poses[:, 0], poses[:, 1], theta])
    return planar


_EXECUTION = 'trajectory execution'


@dataclass(frozen=True, slots=True)
class GripperTarget:
    """
    Where a gripper is to go.

    :param joint: the command joint; with ``parallel`` the first of the two.
    :param position: [rad or m]; with ``parallel`` the sum of both joints.
    :param effort: of the last point [N*m or N], None where that has none.
    :param assumed: whether the first joint of the part replaces the command joint.
    """

    joint: str
    position: float
    effort: float | None = None
    assumed: bool = False


def gripper_target(part: JointTrajectory, controller: MoveItControllerSettings) -> GripperTarget:
    """
    Return the target of a GripperCommand: the last point of the command joint.

    :param part: of a trajectory, with joints of this controller only.
    :raises PlanningError: CONTROL_FAILED where the last point has no positions.
    """
    jaws = controller.joints if controller.parallel else (
        controller.command_joint or controller.joints[0],)
    found = [k for k, name in enumerate(part.joint_names) if name in jaws]
    columns = found or [0]
    effort = part.effort[-1, columns[-1]] if part.effort is not None else np.nan
    return GripperTarget(
        part.joint_names[columns[0]], sum(_last(part, column) for column in columns),
        None if np.isnan(effort) else float(effort), assumed=not found)


def parallel_gripper_target(
    part: JointTrajectory, controller: MoveItControllerSettings
) -> GripperTarget:
    """
    Return the target of a ParallelGripperCommand: the last point of the first joint.

    :param part: of a trajectory, with joints of this controller only.
    :raises PlanningError: CONTROL_FAILED where the part lacks that joint, or its position.
    """
    joint = controller.joints[0]
    if joint not in part.joint_names:
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f"the trajectory has no joint '{joint}', which controller '{controller.name}' "
            f'commands; it has {", ".join(part.joint_names)}', _EXECUTION)
    return GripperTarget(joint, _last(part, part.joint_names.index(joint)))


def _last(part: JointTrajectory, column: int) -> float:
    """Return the last position of a joint [rad or m]."""
    value = float(part.positions[-1, column])
    if np.isnan(value):
        raise PlanningError(
            MoveItErrorCode.CONTROL_FAILED,
            f"the last point has no position of joint '{part.joint_names[column]}', which a "
            'gripper needs', _EXECUTION)
    return value
