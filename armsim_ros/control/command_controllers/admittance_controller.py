# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The admittance controller: references pass, but for how far the arm yields to forces.

``receive`` and ``snapshot`` may be called from any thread; all else belongs to the control loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.command_controllers import (
    AdmittanceControllerParameters,
    AdmittanceSettings,
)
from armsim_ros.control.command_controllers.chainable_controller import ChainableController
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.controller import LifecycleState
from armsim_ros.control.hardware_interface import ACCELERATION, JointProperties, POSITION, VELOCITY
from armsim_ros.errors import ControllerError, nearest
from armsim_ros.model.robot_model import Joint, JointType, RobotModel
from armsim_ros.model.transforms import inverse_pose, rotation_vector
from armsim_ros.model.tree import joint_pose


class LinkMotion:
    """
    Some links of a robot.

    :param joints: (n,) those that move; all others are at 0.
    :param base: link before the joints, in whose frame everything is given.
    :param links: those that are asked for.
    :raises ControllerError: a link or joint that the robot lacks, or a base that moves.
    """

    def __init__(
        self, model: RobotModel, joints: Sequence[str], base: str, links: Iterable[str]
    ) -> None:
        for kind, names, known in (('link', (base, *links), tuple(model.links)),
                                   ('joint', joints, tuple(model.joints))):
            for name in names:
                if name not in known:
                    hint = nearest(name, known) or f'known: {", ".join(known)}'
                    raise ControllerError(
                        f"'{name}' is not a {kind} of robot '{model.name}'; {hint}")
        self._base = base
        self._columns = {name: column for column, name in enumerate(joints)}
        self._paths = {link: _path(model, link) for link in (base, *links)}
        for joint in self._paths[base]:
            if joint.name in self._columns:
                raise ControllerError(f"'{base}' moves with '{joint.name}' and cannot be the "
                                      f"base; choose '{joint.parent}' or a link before it")

    def poses(self, positions: Vector) -> dict[str, Matrix]:
        """Return the pose (4, 4) of each link for positions (n,) [rad or m]."""
        reached: dict[str, Matrix] = {}
        for link, path in self._paths.items():
            pose: Matrix = np.eye(4)
            for joint in path:
                if joint.child not in reached:
                    reached[joint.child] = pose @ joint_pose(joint, self._at(joint, positions))
                pose = reached[joint.child]
            reached[link] = pose
        root = inverse_pose(reached[self._base])
        return {link: root @ reached[link] for link in self._paths}

    def jacobian(self, link: str, positions: Vector) -> Matrix:
        """
        Return how a link's origin moves with the joints (6, n): linear above angular.

        :param positions: (n,) [rad or m].
        """
        found = np.zeros((6, len(self._columns)))
        base: Matrix = np.eye(4)
        for joint in self._paths[self._base]:
            base = base @ joint_pose(joint, self._at(joint, positions))
        frames, pose = [], inverse_pose(base)
        for joint in self._paths[link]:
            pose = pose @ joint_pose(joint, self._at(joint, positions))
            frames.append((joint, pose))
        for joint, frame in frames:
            column = self._columns.get(joint.name)
            if column is None:
                continue
            # A joint turns about its axis, or slides along it, in both its frames alike.
            axis = frame[:3, :3] @ joint.axis
            if joint.type is JointType.PRISMATIC:
                found[:3, column] = axis
            else:
                found[:3, column] = np.cross(axis, pose[:3, 3] - frame[:3, 3])
                found[3:, column] = axis
        return found

    def _at(self, joint: Joint, positions: Vector) -> float:
        column = self._columns.get(joint.name)
        return 0.0 if column is None else float(positions[column])


def _path(model: RobotModel, link: str) -> list[Joint]:
    """Return the joints from the root link to a link."""
    parents: Mapping[str, str] = model.parent_joint
    path: list[Joint] = []
    while (name := parents.get(link)) is not None:
        path.append(model.joints[name])
        link = model.joints[name].parent
    return path[::-1]


class AdmittanceRule:
    """
    What a wrench makes of references.

    In the axes of the control frame ``mass * a + damping * v + stiffness * x = force``, where x
    is how far the sensor's frame has left its place at the reference. The step is implicit in v
    and x, so no stiffness or damping makes it unstable; the joints follow by the damped inverse
    of the Jacobian. Without a wrench nothing yields, and references pass as they are.

    :param links: gives the frames that the parameters name; replaced with them.
    :param lower: (n,) bounds of the joints [rad or m]; ``upper`` likewise.
    """

    def __init__(self, links: LinkMotion, lower: Vector, upper: Vector) -> None:
        self.links, self._lower, self._upper = links, lower, upper
        count = len(lower)
        #: How far the joints have yielded (n,) [rad or m], and its derivatives.
        self.offset, self.velocity, self.acceleration = (np.zeros(count) for _ in range(3))
        #: Force and torque in the base frame, without gravity, filtered (6,) [N, N*m].
        self.wrench: Vector = np.zeros(6)
        #: How far the sensor's frame has yielded (6,) [m, rad], base frame; ``twist`` and
        #: ``twist_rate`` are its derivatives.
        self.yielded, self.twist, self.twist_rate = (np.zeros(6) for _ in range(3))
        self.control_rotation: Matrix = np.eye(3)
        self.sensor_at_reference: Matrix = np.eye(4)

    def step(
        self, parameters: AdmittanceControllerParameters, admittance: AdmittanceSettings,
        reference: Vector, wrench: Vector, period: float
    ) -> None:
        """
        Yield for a period.

        :param reference: (n,) positions [rad or m].
        :param wrench: (6,) measured, in the sensor's frame [N, N*m].
        :param period: [s].
        """
        sensor = parameters.ft_sensor.frame.id
        posture = reference + self.offset
        poses = self.links.poses(posture)
        self.sensor_at_reference = self.links.poses(reference)[sensor]
        self._filter(parameters, poses, wrench)
        turn = poses[parameters.control.frame.id][:3, :3]
        self.control_rotation = turn
        here, there = poses[sensor], self.sensor_at_reference
        self.yielded[:3] = here[:3, 3] - there[:3, 3]
        self.yielded[3:] = rotation_vector(here[:3, :3] @ there[:3, :3].T)
        jacobian = self.links.jacobian(sensor, posture)
        speed = jacobian @ self.velocity
        force = _turned(turn.T, self.wrench) * np.array(admittance.selected_axes)
        mass, stiffness = np.array(admittance.mass), np.array(admittance.stiffness)
        damping = damping_of(admittance)
        place, pace = _turned(turn.T, self.yielded), _turned(turn.T, speed)
        rate = (force - damping * pace - stiffness * (place + period * pace)) / (
            mass + period * damping + period * period * stiffness)
        gram = jacobian.T @ jacobian + parameters.kinematics.alpha * np.eye(len(reference))
        requested = np.linalg.solve(gram, jacobian.T @ _turned(turn, rate))
        before = self.velocity
        velocity = (before + period * requested) / (1.0 + period * admittance.joint_damping)
        posture = reference + self.offset + period * velocity
        bounded = np.clip(posture, self._lower, self._upper)
        self.velocity = np.where(bounded == posture, velocity, 0.0)
        self.offset = bounded - reference
        self.acceleration = (self.velocity - before) / period if period > 0.0 else np.zeros_like(
            before)
        self.twist = jacobian @ self.velocity
        self.twist_rate = jacobian @ self.acceleration

    def _filter(
        self, parameters: AdmittanceControllerParameters, poses: dict[str, Matrix], wrench: Vector
    ) -> None:
        """Bring what is measured into the base frame, without gravity, and smooth it."""
        gravity = parameters.gravity_compensation
        down = -poses[parameters.fixed_world_frame.frame.id][:3, 2]
        weight = gravity.CoG.force * down
        lever = poses[gravity.frame.id][:3, :3] @ np.array(gravity.CoG.pos)
        measured = _turned(poses[parameters.ft_sensor.frame.id][:3, :3], wrench)
        measured[:3] -= weight
        measured[3:] -= np.cross(lever, weight)
        share = parameters.ft_sensor.filter_coefficient
        self.wrench = share * measured + (1.0 - share) * self.wrench


def damping_of(admittance: AdmittanceSettings) -> Vector:
    """Return the damping of each axis (6,) [N*s/m, N*m*s/rad]."""
    mass, stiffness = np.array(admittance.mass), np.array(admittance.stiffness)
    return np.asarray(2.0 * np.array(admittance.damping_ratio) * np.sqrt(mass * stiffness))


def _turned(rotation: Matrix, pair: Vector) -> Vector:
    """Return two vectors (6,) in other axes."""
    return np.concatenate([rotation @ pair[:3], rotation @ pair[3:]])


@dataclass(frozen=True, slots=True, eq=False)
class AdmittanceSnapshot:
    """
    What the controller did in an update [ns]; arrays as in :class:`AdmittanceRule`.

    :param damping: (6,) of the control frame's axes [N*s/m, N*m*s/rad].
    """

    time_ns: int
    parameters: AdmittanceControllerParameters
    admittance: AdmittanceSettings
    damping: Vector
    control_rotation: Matrix
    sensor_at_reference: Matrix
    wrench: Vector
    yielded: Vector
    twist: Vector
    twist_rate: Vector
    offset: Vector
    velocity: Vector
    acceleration: Vector


class AdmittanceController(ChainableController[AdmittanceControllerParameters]):
    """``admittance_controller/AdmittanceController``."""

    parameters_class: ClassVar[type[Settings]] = AdmittanceControllerParameters

    _rule: AdmittanceRule | None = None
    _snapshot: AdmittanceSnapshot | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The controlled joints."""
        return self.parameters.joints

    @property
    def references(self) -> tuple[tuple[str, str], ...]:
        """Each exported interface of each joint, interface by interface."""
        kinds = self.parameters.chainable_command_interfaces
        return tuple((joint, kind) for kind in kinds for joint in self.joints)

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Every command interface of every joint, interface by interface."""
        return tuple('/'.join(target) for target in self._targets)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """States of the joints, and what the sensor measures."""
        kinds = self.parameters.state_interfaces
        of_joints = tuple(f'{joint}/{kind}' for kind in kinds for joint in self.joints)
        return (*of_joints, *self._measured)

    def configure(self) -> None:
        """Check that everything is named that is needed, and that the robot has it."""
        self._motion(self.parameters)
        self._limits = JointProperties.of(self.joints, self.context.model)

    def check_parameters(self, parameters: AdmittanceControllerParameters) -> None:
        """Refuse, once configured, parameters with which it could not be configured."""
        if self.state is not LifecycleState.UNCONFIGURED:
            self._motion(parameters)

    def begin(self, time_ns: int) -> Vector:
        """Take the joints over where they are commanded, else where they are."""
        context, count = self.context, len(self.joints)
        hardware = context.hardware
        self._settled = self.parameters
        self._output = CommandTargets(self._targets, hardware)
        self._output.take_over()
        index = [hardware.index[name] for name in self.joints]
        standing, measured = hardware.command.position[index], hardware.state.position[index]
        self._held: Vector = np.where(np.isfinite(standing), standing, measured)
        self._snapshot = None
        self._added_wrench: Vector = np.zeros(6)
        self._rule = AdmittanceRule(
            self._motion(self._settled), self._limits.lower, self._limits.upper)
        kinds = self.parameters.chainable_command_interfaces
        rows = [self._held if kind == POSITION else np.zeros(count) for kind in kinds]
        return np.concatenate([np.empty(0), *rows])

    def deactivate(self, time_ns: int) -> None:
        """Stop velocities; positions stay."""
        self._output.stop()
        self._rule = None

    def receive(self, positions: Sequence[float], velocities: Sequence[float]) -> str:
        """
        Take references from the topic; those of interfaces that are not exported are ignored.

        :param positions: a value per joint, NaN where it stays, or empty [rad or m].
        :param velocities: likewise [rad/s or m/s].
        :returns: why they were dropped, '' where they were taken.
        """
        count, kinds = len(self.joints), self.parameters.chainable_command_interfaces
        found = np.full((len(kinds), count), np.nan)
        for kind, values in ((POSITION, positions), (VELOCITY, velocities)):
            if len(values) == 0 or kind not in kinds:
                continue
            if len(values) != count or np.isinf(values).any():
                return self.drop(f'{kind} {list(values)}; expected one finite value or NaN for '
                                 f'each of {", ".join(self.joints)}')
            found[kinds.index(kind)] = values
        if np.isnan(found).all():
            return self.drop(f'no value for {" or ".join(kinds)}')
        return self.offer(np.asarray(found.ravel()))

    def receive_wrench(self, frame: str, wrench: Sequence[float]) -> str:
        """
        Add a wrench to what the sensor measures, until the next wrench or deactivation.

        :param frame: that of the sensor, or ''.
        :param wrench: (6,) force and torque [N, N*m].
        :returns: why it was dropped, '' where it was taken.
        """
        sensor = self.parameters.ft_sensor.frame.id
        if frame not in ('', sensor):
            return self.drop(f"wrench in frame '{frame}'; expected '{sensor}'")
        if not np.isfinite(wrench).all():
            return self.drop(f'wrench {list(wrench)}; expected finite numbers')
        if self.active:
            self._added_wrench = np.array(wrench, dtype=np.float64)
        return ''

    def follow(self, references: Vector, time_ns: int, period: float) -> None:
        """Yield to what is measured, and command the references with it."""
        rule = self._rule
        if rule is None:
            raise ControllerError(f"'{self.name}' was not activated")
        parameters = self.parameters
        if (parameters.enable_parameter_update_without_reactivation
                and parameters is not self._settled):
            self._settled, rule.links = parameters, self._motion(parameters)
        admittance = self._settled.admittance
        assert admittance is not None  # configure has refused it
        kinds: tuple[str, ...] = parameters.chainable_command_interfaces
        rows = dict(zip(kinds, references.reshape(-1, len(self.joints)), strict=True))
        position = rows.get(POSITION, self._held)
        states = self.context.hardware.other_states
        measured = np.array([states[name] for name in self._measured])
        if np.isnan(measured).any():  # the filter would never forget it
            measured = np.zeros_like(measured)
        rule.step(self._settled, admittance, position, measured + self._added_wrench, period)
        requested = {
            POSITION: position + rule.offset,
            VELOCITY: rows.get(VELOCITY, np.zeros_like(position)) + rule.velocity,
            ACCELERATION: rule.acceleration,
        }
        command = np.concatenate([requested[kind] for kind in parameters.command_interfaces])
        self._output.write(command)
        self._snapshot = AdmittanceSnapshot(
            time_ns, self._settled, admittance, damping_of(admittance), rule.control_rotation,
            rule.sensor_at_reference, rule.wrench, rule.yielded.copy(), rule.twist,
            rule.twist_rate, rule.offset, rule.velocity, rule.acceleration)

    def snapshot(self) -> AdmittanceSnapshot | None:
        """Return what the last update did, None before the first."""
        return self._snapshot

    def _motion(self, parameters: AdmittanceControllerParameters) -> LinkMotion:
        """
        Return the frames that parameters name.

        :raises ControllerError: a parameter is missing, or the robot lacks what it names.
        """
        model = self.context.model
        if parameters.missing:
            raise ControllerError(f"parameter '{parameters.missing}' of '{self.name}' is missing")
        if model is None:
            raise ControllerError(f"'{self.name}' needs the robot's description")
        return LinkMotion(model, parameters.joints, parameters.kinematics.base, (
            parameters.ft_sensor.frame.id, parameters.control.frame.id,
            parameters.fixed_world_frame.frame.id, parameters.gravity_compensation.frame.id))

    @property
    def _targets(self) -> list[tuple[str, str]]:
        joints = self.parameters.command_joints or self.joints
        return [(joint, kind) for kind in self.parameters.command_interfaces for joint in joints]

    @property
    def _measured(self) -> tuple[str, ...]:
        name = self.parameters.ft_sensor.name
        return tuple(f'{name}/{kind}.{axis}' for kind in ('force', 'torque') for axis in 'xyz')
