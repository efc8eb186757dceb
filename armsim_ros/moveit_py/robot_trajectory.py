# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.core.robot_trajectory``: timed waypoints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math
from operator import index
from typing import Any

from moveit_msgs.msg import RobotTrajectory as RobotTrajectoryMessage
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.errors import PlanningError
from armsim_ros.execution.rules import unwound
from armsim_ros.moveit_py.robot_model import RobotModel
from armsim_ros.moveit_py.robot_state import RobotState
from armsim_ros.moveit_py.utils import logger, warn_once
from armsim_ros.nodes.conversions.motion_plan_request import robot_trajectory_message
from armsim_ros.nodes.conversions.trajectory import trajectory_from_message
from armsim_ros.planning.timing.limits import MotionLimits, scaling_factor
from armsim_ros.planning.timing.time_parameterization import BlendedPath, time_path
from armsim_ros.quintic_motion import QuinticMotion
from armsim_ros.trajectory import JointTrajectory

#: Jerk limit of a joint that has none [rad/s^3 or m/s^3], as of MoveIt's smoothing.
DEFAULT_JERK = 1000.0

#: Quantity of a trajectory -> that of a state.
_RATES = {'velocities': 'velocities', 'accelerations': 'accelerations', 'effort': 'efforts'}


class Waypoint(RobotState):
    """
    A waypoint of an iteration: a state that can be unpacked as (state, duration).

    :param duration: since the waypoint before [s].
    """

    def __init__(self, robot_model: RobotModel, duration: float) -> None:
        super().__init__(robot_model)
        self._duration = duration

    def __iter__(self) -> Iterator[RobotState | float]:
        """Yield the state and the time since the waypoint before [s]."""
        yield self
        yield self._duration


class RobotTrajectory:
    """
    Waypoints and the times between them; empty at first.

    A waypoint has all joints of the robot. Those of the planning group are timed, unwound,
    executed and in messages; without a group, all active joints are.

    :param robot_model: the robot.
    """

    def __init__(self, robot_model: RobotModel) -> None:
        self._model, self._group = robot_model, ''
        self._take(RobotState(robot_model), JointTrajectory(()))

    @classmethod
    def _of(cls, base: RobotState, points: JointTrajectory, group: str) -> RobotTrajectory:
        """Return a trajectory; ``base`` is where the joints are that it does not move."""
        made = cls(base.robot_model)
        made._take(base, points)
        made._group = group
        return made

    def _take(self, base: RobotState, points: JointTrajectory) -> None:
        """Take the waypoints of some joints; the others are where ``base`` has them."""
        kinematics = self._model._kinematics
        columns = [kinematics.index(name) for name in points.joint_names]
        active = [kinematics.index(name) for name in kinematics.robot.active_joints]

        def completed(values: Matrix, others: Vector) -> Matrix:
            table = np.tile(others, (len(values), 1))
            table[:, columns] = values
            table[np.isnan(values).any(axis=1)] = np.nan
            return table[:, active]

        rates: dict[str, Any] = {
            what: completed(getattr(points, what), base._rates[kind])
            for what, kind in _RATES.items() if getattr(points, what) is not None}
        self._base = base.__copy__()
        #: Of all active joints, in the order of the model.
        self._points = JointTrajectory(
            kinematics.robot.active_joints, points.times, completed(points.positions, base._q),
            **rates)

    @property
    def _joints(self) -> tuple[str, ...]:
        """The active joints of the group, in the order of the model; of the robot without one."""
        robot = self._model._kinematics.robot
        return (robot.semantic.groups[self._group].active_joints if self._group
                else robot.active_joints)

    def _selected(self) -> JointTrajectory:
        """Return the waypoints of the group's joints."""
        return self._points.of_joints(self._joints)

    # ---------------------------------------------------------------- waypoints

    def __len__(self) -> int:
        """Return the number of waypoints."""
        return len(self._points)

    def __getitem__(self, idx: int) -> RobotState:
        """Return the state of a waypoint; -1 is the last."""
        place = index(idx)
        if not -len(self) <= place < len(self):
            raise IndexError(f'waypoint {place} of a trajectory with {len(self)} waypoints')
        return self._waypoint(place % len(self))

    def __iter__(self) -> Iterator[Waypoint]:
        """Yield the states; each can be unpacked as (state, duration since the one before)."""
        for place in range(len(self)):
            yield self._waypoint(place)

    def _waypoint(self, place: int) -> Waypoint:
        points, kinematics = self._points, self._model._kinematics
        made = Waypoint(self._model, self.get_waypoint_durations()[place])
        made._take(self._base)
        columns = [kinematics.index(name) for name in points.joint_names]
        made._q[columns] = points.positions[place]
        made._set_q(kinematics.apply_mimic(made._q))
        for what, kind in _RATES.items():
            table = getattr(points, what)
            if table is not None and np.isfinite(table[place]).all():
                made._rates[kind][columns] = table[place]
        return made

    @property
    def robot_model(self) -> RobotModel:
        """The robot."""
        return self._model

    @property
    def joint_model_group_name(self) -> str:
        """The planning group; '' for none."""
        return self._group

    @joint_model_group_name.setter
    def joint_model_group_name(self, name: str) -> None:
        self._group = self._model.get_joint_model_group(name).name if name else ''

    @property
    def duration(self) -> float:
        """Time of the last waypoint [s]."""
        return self._points.duration

    @property
    def average_segment_duration(self) -> float:
        """Mean time between waypoints [s]; that before the first counts unless it is 0."""
        segments = np.count_nonzero(self._points.times[:1]) + max(len(self) - 1, 0)
        return self.duration / segments if segments else 0.0

    def get_waypoint_durations(self) -> list[float]:
        """Return the time of each waypoint since the waypoint before [s]."""
        return list(np.diff(self._points.times, prepend=0.0).tolist())

    # ---------------------------------------------------------------- changes

    def unwind(self) -> RobotTrajectory:
        """
        Remove jumps by full turns of the group's continuous joints; return the trajectory itself.

        Each of them begins within half a turn of 0.
        """
        columns = [self._points.joint_names.index(name) for name in self._joints]
        positions = np.array(self._points.positions)
        positions[:, columns] = self._unwound().positions
        self._points = replace(self._points, positions=positions)
        return self

    def _unwound(self) -> JointTrajectory:
        """Return the waypoints of the group's joints as :meth:`unwind` makes them."""
        points = self._selected()
        start = {name: math.remainder(value, 2.0 * math.pi) for row in points.positions[:1]
                 for name, value in zip(points.joint_names, row.tolist(), strict=True)}
        return unwound(points, start, self._model._kinematics.robot)

    def __reverse__(self) -> RobotTrajectory:
        """
        Reverse the waypoints and their velocities; return the trajectory itself.

        The time before the first waypoint stays.
        """
        points = self._points
        self._points = replace(
            points, times=points.times[:1] + points.duration - points.times[::-1],
            positions=points.positions[::-1],
            velocities=None if points.velocities is None else -points.velocities[::-1],
            accelerations=None if points.accelerations is None else points.accelerations[::-1],
            effort=None if points.effort is None else points.effort[::-1])
        return self

    def get_robot_trajectory_msg(self, joint_filter: Sequence[str] = ()) -> RobotTrajectoryMessage:
        """
        Return the message; without waypoints or joints it is empty.

        :param joint_filter: the joints of the group to be in it; all where it is empty.
        """
        names = [name for name in self._joints if not joint_filter or name in joint_filter]
        if not len(self) or not names:
            return RobotTrajectoryMessage()
        return robot_trajectory_message(self._points.of_joints(names), self._model.model_frame)

    def set_robot_trajectory_msg(
        self, robot_state: RobotState, msg: RobotTrajectoryMessage
    ) -> RobotTrajectory:
        """
        Take the waypoints of a message; return the trajectory itself.

        The stamp of the message is not used.

        :param robot_state: where the joints are that the message does not name.
        :raises PlanningError: the robot has no joint of a name in it.
        :raises ValueError: a point has more or fewer values than there are joints.
        """
        points = trajectory_from_message(msg.joint_trajectory)
        without = np.flatnonzero(np.isnan(points.positions).any(axis=1))
        if points.fault or len(without):
            raise ValueError(points.fault or f'point {without[0]} has no positions')
        if msg.multi_dof_joint_trajectory.points:
            warn_once('set_robot_trajectory_msg: multi-DOF joints are not used')
        self._take(robot_state, points)
        return self

    # ---------------------------------------------------------------- timing

    def apply_totg_time_parameterization(
        self, velocity_scaling_factor: float, acceleration_scaling_factor: float, *,
        path_tolerance: float = 0.1, resample_dt: float = 0.1, min_angle_change: float = 0.001,
    ) -> bool:
        """
        Time the path anew, time-optimally from rest to rest.

        :param velocity_scaling_factor: in (0, 1].
        :param acceleration_scaling_factor: in (0, 1].
        :param path_tolerance: by which corners may be rounded [rad or m].
        :param resample_dt: time between two waypoints of the result [s].
        :param min_angle_change: waypoints nearer to the one before are left out [rad or m].
        :returns: False where no timing keeps the limits; the trajectory is as it was.
        """
        limits = self._limits('apply_totg_time_parameterization')
        return limits is not None and self._time(
            limits, velocity_scaling_factor, acceleration_scaling_factor, path_tolerance,
            resample_dt, min_angle_change)

    def apply_ruckig_smoothing(
        self, velocity_scaling_factor: float, acceleration_scaling_factor: float, *,
        mitigate_overshoot: bool = False, overshoot_threshold: float = 0.01
    ) -> bool:
        """
        Time the path anew so that jerk limits are kept, too.

        A joint without a jerk limit gets 1000 rad/s^3. The motion stays within the threshold of
        the path whatever ``mitigate_overshoot`` is.

        :param velocity_scaling_factor: in (0, 1].
        :param acceleration_scaling_factor: in (0, 1].
        :param mitigate_overshoot: is not used, which is logged once.
        :param overshoot_threshold: by which corners may be rounded [rad or m].
        :returns: False where no timing keeps the limits; the trajectory is as it was.
        """
        limits = self._limits('apply_ruckig_smoothing')
        if limits is None:
            return False
        if mitigate_overshoot:
            warn_once('apply_ruckig_smoothing: mitigate_overshoot is not used; the motion stays '
                      'within overshoot_threshold of the path without it')
        limits = replace(limits, jerk=np.where(
            np.isfinite(limits.jerk), limits.jerk, DEFAULT_JERK))
        step = self.average_segment_duration or 0.1
        return self._time(limits, velocity_scaling_factor, acceleration_scaling_factor,
                          overshoot_threshold, step, 1e-6)

    def _limits(self, what: str) -> MotionLimits | None:
        if not self._group:
            logger().error(f'{what}: the trajectory has no planning group; set '
                           'joint_model_group_name')
            return None
        with self._model._lock:
            return self._model._context.limits.limits(self._joints)

    def _time(
        self, limits: MotionLimits, velocity: float, acceleration: float, tolerance: float,
        step: float, least: float
    ) -> bool:
        points = self._unwound()
        if not len(points):
            return True
        rows = [0]
        for place in range(1, len(points)):
            moved = np.abs(points.positions[place] - points.positions[rows[-1]]).max(initial=0.0)
            if moved > least:
                rows.append(place)
        path = np.array(points.positions[rows])
        if len(path) > 1:
            path[-1] = points.positions[-1]  # the goal stays where it is
        if len(path) < 2:
            self._take(self._waypoint(0),
                       QuinticMotion.at_rest(path[0]).trajectory(points.joint_names))
            return True
        scaled = limits.scaled(
            scaling_factor(velocity, 'velocity_scaling_factor', logger()),
            scaling_factor(acceleration, 'acceleration_scaling_factor', logger()))
        try:
            motion = time_path(BlendedPath(path, tolerance), scaled)
        except (PlanningError, ValueError) as error:
            logger().error(f'the trajectory cannot be timed: {error}')
            return False
        times = np.append(
            np.arange(math.ceil(motion.duration / step - 1e-9)) * step, motion.duration)
        self._take(self._waypoint(0),
                   JointTrajectory(points.joint_names, times, *motion.states(times)))
        return True
