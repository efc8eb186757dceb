# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a command to the joint velocities that it asks for."""

from __future__ import annotations

from dataclasses import dataclass, field
import math

import numpy as np
import pinocchio as pin

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.servo import ServoParameters
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.servo.commands import (
    Command,
    Finding,
    InvalidCommandError,
    JointJog,
    NOTHING,
    PoseTarget,
    Twist,
)
from armsim_ros.servo.speed_limits import singularity_factor, SingularityThresholds

ROTATION_WEIGHT = 0.1
"""What an error of the rotation counts beside that of the translation, with less than 6 joints."""
_DAMPING = 1e-8
_LOST = 1e-4
"""A singular value below this share of the greatest is a motion that is lost."""
_LONGEST = 0.05
"""No half cycle is taken to move a joint farther: the joints are slower than that [rad or m]."""
APPROACH = (0.4, 1.5)
"""Deceleration towards a pose [m/s^2, rad/s^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """
    What a command asks for in a cycle.

    :param velocity: (m,) of the group's joints [rad/s or m/s].
    :param cartesian: whether the tip was commanded, not joints.
    :param findings: findings to report.
    """

    velocity: Vector
    cartesian: bool
    findings: tuple[Finding, ...] = field(default=())


class TargetVelocity:
    """
    Joint velocities of a planning group for commands.

    :param kinematics: the robot.
    :param scene: knows the frames.
    :param group: planning group whose joints are commanded; the order of all vectors.
    :param subgroup: part of it that moves, or the group itself.
    :raises PlanningError: INVALID_GROUP_NAME, or the subgroup is not part of the group.
    """

    def __init__(
        self, kinematics: KinematicModel, scene: PlanningScene, group: str, subgroup: str = ''
    ) -> None:
        """Look the joints up."""
        self._kinematics, self._scene = kinematics, scene
        self._moving = subgroup or group
        self.indices = kinematics.group_indices(group)
        moving = kinematics.group_indices(self._moving)
        if not set(moving) <= set(self.indices):
            known = kinematics.robot.semantic.groups
            parts = [name for name in known
                     if set(kinematics.group_indices(name)) < set(self.indices)]
            raise PlanningError(
                MoveItErrorCode.INVALID_GROUP_NAME,
                f"planning group '{subgroup}' is not part of '{group}'; allowed: "
                f'{", ".join(parts) or "none"}',
                'servo')
        self.names = tuple(kinematics.names[i] for i in self.indices)
        self._columns = np.array([list(self.indices).index(i) for i in moving], dtype=np.intp)
        self._moving_indices = moving
        self.moving_names = tuple(kinematics.names[i] for i in moving)
        self.tip, self.base = ends(kinematics, self._moving)
        self._scales = np.ones(6)
        self._scales[:3] /= min(1.0, _reach(kinematics, self.base, self.tip) or 1.0)
        self._weights = self._scales.copy()
        if len(moving) < 6:
            self._weights[3:] *= ROTATION_WEIGHT
        self._damping = _DAMPING * np.eye(min(6, len(moving)))

    def wanted(self, command: Command, q: Vector, parameters: ServoParameters) -> Wanted:
        """
        Return what a command asks for.

        :param q: (n,) robot state.
        :raises InvalidCommandError: nothing can be done with it; the text names the field.
        """
        with np.errstate(over='ignore', invalid='ignore'):  # what is not finite is refused
            return self._wanted(command, q, parameters)

    def _wanted(self, command: Command, q: Vector, parameters: ServoParameters) -> Wanted:
        if isinstance(command, JointJog):
            return self._jog(command, parameters)
        if isinstance(command, Twist):
            twist = self._twist(command, q, parameters)
            findings: tuple[Finding, ...] = ()
        else:
            twist, findings = self._towards(command, q, parameters)
        if not twist.any():
            return Wanted(np.zeros(len(self.indices)), True, findings)
        thresholds = SingularityThresholds(
            parameters.lower_singularity_threshold, parameters.hard_stop_singularity_threshold,
            parameters.leaving_singularity_threshold_multiplier, parameters.singularity_step_scale)
        jacobian = self._jacobian(q)
        factor, finding = singularity_factor(
            q[self._moving_indices], self._scales * twist, self._scales[:, None] * jacobian,
            lambda values: self._scales[:, None] * self._jacobian(self._with(q, values)),
            thresholds)
        if finding is not None:
            findings = (*findings, finding)
        velocity = np.zeros(len(self.indices))
        if factor > 0.0:
            velocity[self._columns] = self._joints(
                q, jacobian, factor * twist, parameters.publish_period)
        return Wanted(velocity, True, findings)

    def progress(
        self, command: Twist, q: Vector, velocity: Vector, parameters: ServoParameters
    ) -> tuple[float, float]:
        """
        Return how much of a twist joint velocities (m,) make.

        :param q: (n,) robot state.
        :returns: the share, 1 where they make all of it, and the speed of the tip [m/s] along it.
        :raises InvalidCommandError: as :meth:`wanted`.
        """
        requested = self._twist(command, q, parameters)
        size = float(np.abs(requested).max())
        if size == 0.0:
            return 1.0, 0.0
        requested = requested / size  # whose square is a number, however fast the twist is
        made = self._jacobian(q) @ velocity[self._columns]
        weights = self._scales**2
        length = float(np.linalg.norm(requested[:3]))
        return (float(weights * made @ requested) / float(weights * requested @ requested) / size,
                float(made[:3] @ requested[:3]) / length if length > 0.0 else 0.0)

    def singularity(self, q: Vector) -> tuple[int, float]:
        """
        Return how singular a robot state (n,) is; the less, the better.

        :returns: how many independent motions of the tip are lost, and the condition number of
            the others, with lengths in units of the reach.
        """
        values = np.linalg.svd(self._scales[:, None] * self._jacobian(q), compute_uv=False)
        left = values[values > _LOST * values[0]]
        return len(values) - len(left), float(values[0] / left[-1]) if len(left) else math.inf

    def complete(self, q: Vector) -> Vector:
        """Return a copy of a robot state (n,) in which mimic joints follow."""
        return self._kinematics.apply_mimic(q)

    # ---------------------------------------------------------------- commands

    def _jog(self, command: JointJog, parameters: ServoParameters) -> Wanted:
        velocity = np.zeros(len(self.indices))
        if len(command.names) != len(command.velocities):
            raise InvalidCommandError(
                f'joint_names has {len(command.names)} entries, velocities has '
                f'{len(command.velocities)}; both need one per joint')
        for name, value in zip(command.names, command.velocities, strict=True):
            if name not in self.moving_names:
                known = self.moving_names
                raise InvalidCommandError(
                    f"joint_names: '{name}' is not a joint of '{self._moving}' "
                    f'({", ".join(known)}) {nearest(name, known)}'.rstrip())
            velocity[self.names.index(name)] = value
        if parameters.command_in_type == 'unitless':
            velocity *= parameters.scale.joint
        return Wanted(_finite(velocity), False)

    def _twist(self, command: Twist, q: Vector, parameters: ServoParameters) -> Vector:
        """Return the velocity (6,) of the tip in the axes of the model frame."""
        scale = parameters.scale
        if parameters.command_in_type == 'unitless':
            linear = command.linear * scale.linear
            angular = command.angular * scale.rotational
        else:
            linear = _capped(command.linear, scale.linear)
            angular = _capped(command.angular, scale.rotational)
        frame = self._pose(command.frame, q)
        linear, angular = frame[:3, :3] @ linear, frame[:3, :3] @ angular
        if not parameters.apply_twist_commands_about_ee_frame and command.frame != self.base:
            lever = self._kinematics.link_pose(q, self.tip)[:3, 3] - frame[:3, 3]
            linear = linear + np.cross(angular, lever)
        return np.concatenate((linear, angular))

    def _towards(
        self, command: PoseTarget, q: Vector, parameters: ServoParameters
    ) -> tuple[Vector, tuple[Finding, ...]]:
        """Return the velocity (6,) that leads to a pose and comes to rest there."""
        target = self._pose(command.frame, q) @ command.pose
        tip = self._kinematics.link_pose(q, self.tip)
        way = target[:3, 3] - tip[:3, 3]
        turn: Vector = tip[:3, :3] @ pin.log3(tip[:3, :3].T @ target[:3, :3])
        tracking, scale = parameters.pose_tracking, parameters.scale
        distance, angle = float(np.linalg.norm(way)), float(np.linalg.norm(turn))
        if distance < tracking.linear_tolerance and angle < tracking.angular_tolerance:
            return np.zeros(6), (Finding(NOTHING.code, 'pose reached'),)
        period = parameters.publish_period
        return np.concatenate((
            way * _approach(distance, scale.linear, APPROACH[0], period),
            turn * _approach(angle, scale.rotational, APPROACH[1], period),
        )), ()

    # ---------------------------------------------------------------- kinematics

    def _pose(self, frame: str, q: Vector) -> Matrix:
        if not frame:
            raise InvalidCommandError('header.frame_id is empty')
        if self._kinematics.has_link(frame):
            return self._kinematics.link_pose(q, frame)
        try:
            return self._scene.frame_pose(frame, q)
        except PlanningError as error:
            raise InvalidCommandError(f'header.frame_id: {error}') from None

    def _joints(self, q: Vector, jacobian: Matrix, twist: Vector, period: float) -> Vector:
        """Return velocities (m,) that move the tip so on average over a cycle."""
        step = 0.5 * period * self._solve(jacobian, twist)
        length = float(np.abs(step).max())
        if length > _LONGEST:
            step *= _LONGEST / length
        middle = self._with(q, q[self._moving_indices] + step)
        return self._solve(self._jacobian(middle), twist)

    def _solve(self, jacobian: Matrix, twist: Vector) -> Vector:
        jacobian = self._weights[:, None] * jacobian
        requested = self._weights * twist
        if jacobian.shape[1] >= 6:
            solution = jacobian.T @ np.linalg.solve(
                jacobian @ jacobian.T + self._damping, requested)
        else:
            solution = np.linalg.solve(
                jacobian.T @ jacobian + self._damping, jacobian.T @ requested)
        return _finite(np.asarray(solution, dtype=np.float64))

    def _jacobian(self, q: Vector) -> Matrix:
        return self._kinematics.jacobian(q, self.tip, self._moving)

    def _with(self, q: Vector, values: Vector) -> Vector:
        return self._kinematics.insert(q, self._moving, values)


def ends(kinematics: KinematicModel, group: str) -> tuple[str, str]:
    """Return tip and base link of a group: those of its chain, else its last link and the root."""
    entry = kinematics.robot.semantic.groups[group]
    if entry.chain is not None:
        base, tip = entry.chain
        return tip, base
    tip = entry.tips[-1] if entry.tips else entry.links[-1]
    return tip, kinematics.robot.root_link


def _reach(kinematics: KinematicModel, base: str, tip: str) -> float:
    """Return the sum of the lengths of the links between the first moving joint and a tip [m]."""
    above = {joint.child: joint for joint in kinematics.robot.joints.values()}
    lengths, reach, link = 0.0, 0.0, tip
    while link != base and link in above:
        joint = above[link]
        if joint.name in kinematics.names:
            reach = lengths
        lengths += float(np.linalg.norm(joint.origin[:3, 3]))
        link = joint.parent
    return reach


def _finite(velocity: Vector) -> Vector:
    """Return joint velocities (m,); InvalidCommandError for numbers that are too large."""
    if not np.isfinite(velocity).all():
        raise InvalidCommandError('the joint velocities that the command asks for are not finite')
    return velocity


def _capped(vector: Vector, bound: float) -> Vector:
    """Return a vector (3,) no longer than its bound; 0 is none."""
    largest = float(np.abs(vector).max())
    if bound <= 0.0 or largest == 0.0:
        return vector
    direction = vector / largest  # whose length is a number, however fast the twist is
    length = float(np.linalg.norm(direction))
    return direction * (bound / length) if bound < largest * length else vector


def _approach(distance: float, fastest: float, deceleration: float, period: float) -> float:
    """Return the speed by which to multiply a way so that it ends at rest [1/s]."""
    if distance < 1e-12:
        return 0.0
    speed = min(math.sqrt(2.0 * deceleration * distance), distance / (10.0 * period))
    return (min(speed, fastest) if fastest > 0.0 else speed) / distance

