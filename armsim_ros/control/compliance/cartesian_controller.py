# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The Cartesian controllers of crisp_controllers: efforts that hold the tip like a spring."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, TypeVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    CartesianControllerParameters,
    YieldingSettings,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.compliance.tip_forces import (
    bounded,
    Gains,
    impedance_torques,
    JointBounds,
    pose_error,
    Targets,
)
from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import EFFORT, JointProperties
from armsim_ros.control.mailbox import Mailbox, RepeatedWarning
from armsim_ros.errors import ControllerError
from armsim_ros.model.transforms import (
    matrix_from_axis_angle,
    pose_from_parts,
    pose_from_quat_xyzw,
    rotation_vector,
)

ParametersT = TypeVar('ParametersT', CartesianControllerParameters,
                      CartesianAdmittanceControllerParameters)


class ComplianceController(Controller[ParametersT]):
    """What both controllers share: targets, activation, the law, smoothing."""

    #: Targets of the tip (4, 4), of the joints (n,) and of the wrench (6,), and smoothed ones.
    _target: Matrix
    _desired: Matrix
    _posture: Vector
    _posture_velocity: Vector
    _reference: Vector
    _wrench: Vector
    _received_ns: int
    #: The smoothed state (n,), and the last torques.
    _positions: Vector
    _velocities: Vector
    _torques: Vector
    _settled: Settings

    @property
    def joints(self) -> tuple[str, ...]:
        """The controlled joints."""
        return self.parameters.joints

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """The effort of each joint."""
        return tuple(f'{joint}/effort' for joint in self.joints)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Position and velocity of each joint."""
        return tuple(f'{joint}/{kind}' for kind in ('position', 'velocity')
                     for joint in self.joints)

    def on_init(self) -> None:
        """Have no targets."""
        self._warning = RepeatedWarning(self.events)
        self._requests: Mailbox[Callable[[], object]] = Mailbox(self.context.wake, capacity=100)
        self._stiffness: Vector | None = None

    def configure(self) -> None:
        """Check that joints and links are those of the robot, and that all is named."""
        parameters, model = self.parameters, self.context.model
        self._arm = ArmDynamics.of_controller(self.name, model, parameters)
        found = JointProperties.of(self.joints, model)
        self._bounds = JointBounds(found.lower, found.upper,
                                   np.isfinite(found.lower) & np.isfinite(found.upper))
        self._gains, self._settled = Gains.of(parameters), parameters

    def activate(self, time_ns: int) -> None:
        """Hold where the arm is: targets are its pose, the first torques those that hold it."""
        hardware = self.context.hardware
        self.time_ns = time_ns
        self._index = [hardware.index[name] for name in self.joints]
        self._output = CommandTargets([(joint, EFFORT) for joint in self.joints], hardware)
        self._output.take_over()
        self._requests.take_all()
        self._stiffness = None
        self._gains = Gains.of(self.parameters)
        self._hold()
        self._torques = (self._arm.gravity() if self.parameters.use_gravity_compensation
                         else np.zeros(len(self._index)))
        self._warn_of_gravity()

    def deactivate(self, time_ns: int) -> None:
        """Leave the joints to their drives, which hold them."""
        self._output.stop(effort=np.nan)

    def update(self, time_ns: int, period: float) -> None:
        """Take new targets, and command the torques of the law."""
        self.time_ns = time_ns
        hardware, parameters = self.context.hardware, self.parameters
        for request in self._requests.take_all():
            request()
        if parameters is not self._settled:
            self._settled, self._gains = parameters, Gains.of(parameters, self._stiffness)
        timeout = parameters.command_timeout
        if timeout and time_ns - self._received_ns > timeout * 1e9:
            self._hold()
        smooth = parameters.filter
        self._reference = _smoothed(self._reference, self._posture, smooth.q_ref)
        self._positions = _smoothed(
            self._positions, hardware.state.position[self._index], smooth.q)
        self._velocities = _smoothed(
            self._velocities, hardware.state.velocity[self._index], smooth.dq)
        self._arm.move(self._positions, self._velocities)
        self._desired = _between(self._target, self._desired, smooth.target_pose)
        targets = Targets(self.followed_pose(period), self._reference, self._posture_velocity,
                          self._wrench)
        torques = impedance_torques(parameters, self._gains, targets, self._arm, self._bounds,
                                    self._positions, self._velocities)
        if parameters.limit_torques:
            most = parameters.max_delta_tau
            torques = self._torques + np.clip(torques - self._torques, -most, most)
        self._torques = _smoothed(self._torques, torques, smooth.output_torque)
        if not parameters.stop_commands:
            self._output.write(self._torques)

    def followed_pose(self, period: float) -> Matrix:
        """Return the pose that the tip follows now, after the target was smoothed (4, 4)."""
        return self._desired

    def receive_pose(self, frame: str, xyz: Sequence[float], xyzw: Sequence[float]) -> str:
        """
        Take a target of the tip.

        :param frame: '' is the base frame; another link is taken where it is then.
        :param xyz: position [m].
        :returns: why it was dropped, '' where it was taken.
        """
        if not np.isfinite(xyz).all():
            return self._drop('target_pose', f'position {list(xyz)}')
        try:
            pose = pose_from_quat_xyzw(xyz, xyzw)
        except ValueError as error:
            return self._drop('target_pose', str(error))
        if frame not in ('', self.parameters.base_frame) and not self._arm.has(frame):
            expected = self.parameters.base_frame or "''"
            return self._drop('target_pose', f"frame '{frame}' is not known; expected {expected}")
        return self._post(lambda: self._take_pose(frame, pose))

    def receive_joints(
        self, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]
    ) -> str:
        """
        Take a posture, by the joints' names; without names all in the order of ``joints``.

        :param positions: [rad], as many as names, or none.
        :param velocities: [rad/s], as many as names, or none.
        :returns: why it was dropped, '' where it was taken.
        """
        names = list(names) or list(self.joints)
        for kind, values in (('positions', positions), ('velocities', velocities)):
            if len(values) not in (0, len(names)) or not np.isfinite(values).all():
                return self._drop('target_joint', f'{kind} {list(values)} of {", ".join(names)}')
        known = [name for name in names if name in self.joints]
        if not known:
            return self._drop('target_joint', f'none of {", ".join(names)} is controlled')
        return self._post(lambda: self._take_joints(
            dict(zip(names, positions, strict=False)), dict(zip(names, velocities, strict=False))))

    def receive_wrench(self, wrench: Sequence[float]) -> str:
        """
        Take force and torque that the tip shall give (6,) [N, N*m].

        :returns: why it was dropped, '' where it was taken.
        """
        if not np.isfinite(wrench).all():
            return self._drop('target_wrench', str(list(wrench)))
        values = np.array(wrench, dtype=np.float64)
        return self._post(lambda: setattr(self, '_wrench', values))

    def receive_stiffness(self, values: Sequence[float]) -> str:
        """
        Take the stiffness of the tip (6,) [N/m, N*m/rad]; too large values are bounded.

        :returns: why it was dropped, '' where it was taken.
        """
        if len(values) != 6 or not np.isfinite(values).all():
            return self._drop(self.parameters.variable_stiffness.topic,
                              f'{list(values)}; expected six finite numbers')
        given = np.array(values, dtype=np.float64)
        self.warn_of_bounds(self.parameters.variable_stiffness.topic, given,
                            bounded(given, self.parameters.most_stiffness))
        return self._post(lambda: self._take_stiffness(given))

    def ignore(self, topic: str, publishers: int) -> None:
        """Warn that a topic has several publishers, so that its messages are ignored."""
        self._warning.add(
            self.time_ns, f"'{topic}' has {publishers} publishers; its messages are ignored until "
            'there is one', topic)

    def warn_of_bounds(self, topic: str, given: Vector, taken: Vector) -> None:
        """Warn where stiffnesses were bounded."""
        if (given != taken).any():
            self._warning.add(self.time_ns, f"'{topic}': {given.tolist()} is bounded to "
                              f'{taken.tolist()}', f'bounds of {topic}')

    def _hold(self) -> None:
        """Make the present state the target."""
        state = self.context.hardware.state
        self._positions = state.position[self._index].copy()
        self._velocities = state.velocity[self._index].copy()
        self._arm.move(self._positions, self._velocities)
        self._target = self._desired = self._arm.pose
        self._posture = self._reference = self._positions.copy()
        self._posture_velocity = np.zeros_like(self._positions)
        self._wrench = np.zeros(6)
        self._received_ns = self.time_ns

    def _post(self, request: Callable[[], object]) -> str:
        if not self.active:
            return 'the controller is not active'
        if obstacle := self.obstacle:
            return obstacle
        self._requests.post(request)
        return ''

    def _take_pose(self, frame: str, pose: Matrix) -> None:
        if frame not in ('', self.parameters.base_frame):
            pose = self._arm.frame(frame) @ pose
        self._target, self._received_ns = pose, self.time_ns

    def _take_joints(
        self, positions: Mapping[str, float], velocities: Mapping[str, float]
    ) -> None:
        self._posture, self._posture_velocity = (
            np.array([new.get(name, old) for name, old in zip(
                self.joints, values.tolist(), strict=True)])
            for new, values in ((positions, self._posture), (velocities, self._posture_velocity)))
        self._received_ns = self.time_ns

    def _take_stiffness(self, values: Vector) -> None:
        self._stiffness = values
        self._gains = Gains.of(self.parameters, values)

    def _drop(self, topic: str, reason: str) -> str:
        self._warning.add(self.time_ns, f"message on '{topic}' dropped: {reason}", topic)
        return reason

    def _warn_of_gravity(self) -> None:
        """Warn where hardware and controller both compensate gravity, or neither does."""
        compensated = self.context.hardware.gravity_compensated
        by_hardware = all(name in compensated for name in self.joints)
        if by_hardware != self.parameters.use_gravity_compensation:
            return
        who, what = (('both', 'floats up') if by_hardware else ('neither', 'sinks'))
        self.events.warn(
            self.time_ns, f'{who} of hardware and controller compensate'
            f"{'' if by_hardware else 's'} gravity, so the arm {what}: set either "
            "'servo.gravity_compensation' of simulation.yaml or 'use_gravity_compensation' of "
            f"'{self.name}'")


class CartesianController(ComplianceController[CartesianControllerParameters]):
    """``crisp_controllers/CartesianController``."""

    parameters_class: ClassVar[type[Settings]] = CartesianControllerParameters


def _smoothed(last: Vector, new: Vector, share: float) -> Vector:
    """Return ``share`` of the last value and the rest of the new value."""
    found: Vector = (1.0 - share) * new + share * last
    return found


def _between(target: Matrix, last: Matrix, share: float) -> Matrix:
    """Return the pose that is ``share`` of the way from a target back to the last pose."""
    turn = rotation_vector(last[:3, :3] @ target[:3, :3].T)
    angle = float(np.linalg.norm(turn))
    rotation = target[:3, :3]
    if angle > 1e-12:
        rotation = matrix_from_axis_angle(turn / angle, share * angle) @ rotation
    return pose_from_parts(_smoothed(last[:3, 3], target[:3, 3], share), rotation)


_AXES = ('x', 'y', 'z', 'rx', 'ry', 'rz')


class CartesianAdmittanceController(ComplianceController[CartesianAdmittanceControllerParameters]):
    """
    ``crisp_controllers/CartesianAdmittanceController``.

    The tip follows a mass on a spring and damper at the target, in the axes of the base frame:
    ``M a = F - D v + K (target - x)``.
    """

    parameters_class: ClassVar[type[Settings]] = CartesianAdmittanceControllerParameters

    def configure(self) -> None:
        """Check the sensor's frame, too."""
        super().configure()
        frame = self.parameters.ft_sensor.frame
        if frame and not self._arm.has(frame):
            raise ControllerError(f"ft_sensor.frame: no link '{frame}'")

    def activate(self, time_ns: int) -> None:
        """Begin at rest, without a wrench."""
        super().activate(time_ns)
        self._inner = self._target.copy()
        self._motion, self._measured = np.zeros(6), np.zeros(6)
        self._yielding_stiffness: Vector | None = None

    def receive_measured(self, wrench: Sequence[float]) -> str:
        """
        Take what the sensor measures, in its own axes (6,) [N, N*m].

        :returns: why it was dropped, '' where it was taken.
        """
        if not np.isfinite(wrench).all():
            return self._drop(self.parameters.ft_sensor.topic, str(list(wrench)))
        values = np.array(wrench, dtype=np.float64)
        return self._post(lambda: setattr(self, '_measured', values))

    def receive_yielding_stiffness(self, values: Sequence[float]) -> str:
        """
        Take the stiffness of the admittance (6,) [N/m, N*m/rad]; too large values are bounded.

        :returns: why it was dropped, '' where it was taken.
        """
        topic = self.parameters.variable_admittance_stiffness.topic
        if len(values) != 6 or not np.isfinite(values).all():
            return self._drop(topic, f'{list(values)}; expected six finite numbers')
        given = np.array(values, dtype=np.float64)
        taken = bounded(given, self.parameters.variable_max_admittance_stiffness)
        self.warn_of_bounds(topic, given, taken)
        return self._post(lambda: setattr(self, '_yielding_stiffness', taken))

    def followed_pose(self, period: float) -> Matrix:
        """Return where the mass is after the period (4, 4)."""
        parameters, inner = self.parameters, self._inner
        sensor = self._arm.frame(parameters.ft_sensor.frame)[:3, :3]
        force = np.concatenate((sensor @ self._measured[:3], sensor @ self._measured[3:]))
        stiffness = self._yielding_stiffness
        if stiffness is None:
            stiffness = bounded(_of_axes(parameters.admittance, 'stiffness'),
                                parameters.variable_max_admittance_stiffness)
        force += stiffness * pose_error(self._desired, inner)
        force -= _of_axes(parameters.admittance, 'damping') * self._motion
        self._motion = self._motion + period * force / _of_axes(parameters.admittance, 'mass')
        inner[:3, 3] += period * self._motion[:3]
        speed = float(np.linalg.norm(self._motion[3:]))
        if speed > 1e-12:
            inner[:3, :3] = matrix_from_axis_angle(
                self._motion[3:] / speed, period * speed) @ inner[:3, :3]
        return inner


def _of_axes(settings: YieldingSettings, kind: str) -> Vector:
    return np.array([getattr(settings, f'{kind}_{axis}') for axis in _AXES])
