# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The controllers of FZI's cartesian_controllers: a net force moves the joints until it vanishes.

``receive_...`` and ``feedback`` may be called from any thread; all else belongs to the control
loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, TypeVar

import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.compliance import (
    CartesianComplianceControllerParameters,
    CartesianForceControllerParameters,
    CartesianMotionControllerParameters,
    NetForceParameters,
)
from armsim_ros.control.arm_dynamics import ArmDynamics
from armsim_ros.control.command_writer import CommandTargets
from armsim_ros.control.compliance.tip_forces import InternalModel, JointBounds, pose_error, STEP_S
from armsim_ros.control.controller import Controller
from armsim_ros.control.hardware_interface import JointProperties, POSITION
from armsim_ros.control.mailbox import RepeatedWarning
from armsim_ros.errors import ControllerError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.transforms import pose_from_quat_xyzw

ParametersT = TypeVar('ParametersT', bound=NetForceParameters)
#: Largest error of position [m] and of rotation [rad] that counts.
_LARGEST_ERROR = 1.0
_AXES = ('trans_x', 'trans_y', 'trans_z', 'rot_x', 'rot_y', 'rot_z')


class NetForceController(Controller[ParametersT]):
    """What all three share: internal model, gains, commands."""

    #: Whether it has ``target_frame``, and whether ``target_wrench`` and ``ft_sensor_wrench``.
    takes_poses: ClassVar[bool] = False
    takes_wrenches: ClassVar[bool] = False

    _feedback: tuple[int, Matrix, Vector] | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """The controlled joints."""
        return self.parameters.joints

    @property
    def update_rate(self) -> int:
        """Every update of the manager; those between its own interpolate the positions [Hz]."""
        return self.context.update_rate

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Every command interface of every joint, interface by interface."""
        return tuple('/'.join(target) for target in self._targets)

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """The positions of the joints."""
        return tuple(f'{joint}/position' for joint in self.joints)

    def on_init(self) -> None:
        """Have no targets."""
        self._warning = RepeatedWarning(self.events)

    def configure(self) -> None:
        """Check that all is named, and that links are in the chain."""
        parameters, model = self.parameters, self.context.model
        missing = [name for name, value in parameters.needed.items() if not value]
        if missing:
            raise ControllerError(f"parameter '{missing[0]}' of '{self.name}' is empty")
        if model is None:
            raise ControllerError(f"'{self.name}' needs the robot's description")
        chain = _chain(model, parameters.robot_base_link, parameters.end_effector_link)
        for key, link in parameters.links.items():
            if link not in chain:
                raise ControllerError(
                    f"{key}: link '{link}' is not between '{parameters.robot_base_link}' and "
                    f"'{parameters.end_effector_link}'; allowed: {', '.join(chain)}")
        arm = ArmDynamics(model, self.joints, parameters.end_effector_link,
                          parameters.robot_base_link)
        limits = JointProperties.of(self.joints, model)
        self._model = InternalModel(
            arm,
            # The end effector's own mass and inertia are 1.
            [link for link in chain[1:-1] if model.parent_joint.get(link) in self.joints],
            JointBounds(limits.lower, limits.upper,
                        np.isfinite(limits.lower) & np.isfinite(limits.upper)))

    def activate(self, time_ns: int) -> None:
        """
        Begin where the arm is, at rest.

        A sensor of the robot at ``ft_sensor_ref_link`` is read as long as no message of the
        topic has come.
        """
        hardware = self.context.hardware
        self.time_ns = time_ns
        self._index = [hardware.index[name] for name in self.joints]
        self._output = CommandTargets(self._targets, hardware)
        self._output.take_over()
        self._model.velocities = np.zeros(len(self._index))
        self._model.place(hardware.state.position[self._index].copy())
        self._target = self._model.arm.pose
        self._wrench, self._measured = np.zeros(6), np.zeros(6)
        self._sensor_link = self.parameters.links.get('ft_sensor_ref_link', '')
        self._sensor = next((name for name, link in hardware.sensor_links.items()
                             if link == self._sensor_link), '')
        self._last_error: Vector | None = None
        self._stride = self.context.update_rate // self.own_rate
        self._start, self._updates = self._model.positions, 0
        self._write(1.0)

    def deactivate(self, time_ns: int) -> None:
        """Stop velocities; positions stay."""
        self._output.stop()

    def update(self, time_ns: int, period: float) -> None:
        """Move the internal model from where the joints are, and command where it is then."""
        self.time_ns = time_ns
        self._updates %= self._stride
        if self._updates:
            self._updates += 1
            self._write(self._updates / self._stride)
            return
        model, parameters = self._model, self.parameters
        self._start = self._commanded
        model.place(self.context.hardware.state.position[self._index].copy())
        # The force controller makes a single step, as upstream's.
        count = parameters.solver.iterations if self.takes_poses else 1
        if self._sensor:
            self._measured = self._load(self._sensor)
        for _ in range(count):
            error = self.net_force()
            last = error if self._last_error is None else self._last_error
            gains = [getattr(parameters.pd_gains, axis) for axis in _AXES]
            force = np.array([gain.p for gain in gains]) * error + np.array(
                [gain.d for gain in gains]) * (error - last) / STEP_S
            self._last_error = error
            model.step(parameters.solver.error_scale * force, parameters)
        if not np.isfinite(model.positions).all() or not np.isfinite(model.velocities).all():
            self._warning.add(time_ns, 'the internal model has no finite joints; the last command '
                              'stays, and the model begins anew at rest')
            model.velocities = np.zeros(len(self._index))
            model.positions = self._commanded
            return
        self._updates = 1
        self._write(1.0 / self._stride)
        if parameters.solver.publish_state_feedback:
            pose, jacobian = model.arm.pose, model.arm.jacobian()
            self._feedback = time_ns, pose, jacobian @ model.velocities

    def net_force(self) -> Vector:
        """Return what shall vanish (6,), in base axes."""
        raise NotImplementedError

    def feedback(self) -> tuple[int, Matrix, Vector] | None:
        """Return time [ns], pose (4, 4) and twist (6,) of the internal model in the base link."""
        return self._feedback

    def receive_pose(self, frame: str, xyz: Sequence[float], xyzw: Sequence[float]) -> str:
        """
        Take a target of the end effector in the base link; an inactive controller takes none.

        :returns: why it was dropped, '' where it was taken.
        """
        base = self.parameters.robot_base_link
        if frame != base:
            return self._drop('target_frame', f"frame '{frame}'; expected '{base}'")
        try:
            if not np.isfinite(xyz).all():
                raise ValueError(f'position {list(xyz)}')
            pose = pose_from_quat_xyzw(xyz, xyzw)
        except ValueError as error:
            return self._drop('target_frame', str(error))
        if self._refused:
            return self._refused
        self._target = pose
        return ''

    def receive_wrench(self, wrench: Sequence[float]) -> str:
        """Take force and torque that the end effector shall give (6,) [N, N*m]; as above."""
        if not np.isfinite(wrench).all():
            return self._drop('target_wrench', str(list(wrench)))
        if self._refused:
            return self._refused
        self._wrench = np.array(wrench, dtype=np.float64)
        return ''

    def receive_measured(self, wrench: Sequence[float]) -> str:
        """Take what the sensor measures in its own axes (6,) [N, N*m]; as above."""
        if not np.isfinite(wrench).all():
            return self._drop('ft_sensor_wrench', str(list(wrench)))
        if self._refused:
            return self._refused
        self._sensor = ''
        self._measured = np.array(wrench, dtype=np.float64)
        return ''

    def _load(self, sensor: str) -> Vector:
        """Return what a sensor of the hardware measures (6,), but for the weight beyond it."""
        measured = self.context.hardware.read_states(
            f'{sensor}/{kind}.{axis}' for kind in ('force', 'torque') for axis in 'xyz')
        load: Vector = measured - self._model.arm.weight(self._sensor_link)
        return load

    def motion_error(self) -> Vector:
        """Return way and rotation vector to the target (6,), in base axes, each at most 1."""
        error = pose_error(self._target, self._model.arm.pose)
        for part in (error[:3], error[3:]):
            length = float(np.linalg.norm(part))
            if length > _LARGEST_ERROR:
                part *= _LARGEST_ERROR / length
        return error

    def wrench_error(self, sensor: str, reference: str, *, hand: bool) -> Vector:
        """
        Return measured and target wrench together (6,), in base axes.

        :param sensor: link of the sensor.
        :param reference: link about whose origin torques are taken.
        :param hand: whether the target is in the axes of the end effector.
        """
        arm = self._model.arm
        at_sensor, at_reference = arm.frame(sensor), arm.frame(reference)
        force = at_sensor[:3, :3] @ self._measured[:3]
        lever = at_sensor[:3, 3] - at_reference[:3, 3]
        torque = at_sensor[:3, :3] @ self._measured[3:] + np.cross(lever, force)
        turn = arm.pose[:3, :3] if hand else np.eye(3)
        target = np.concatenate((turn @ self._wrench[:3], turn @ self._wrench[3:]))
        return np.asarray(np.concatenate((force, torque)) + target)

    @property
    def _refused(self) -> str:
        return '' if self.active and not self.obstacle else (
            self.obstacle or 'the controller is not active')

    @property
    def _targets(self) -> list[tuple[str, str]]:
        return [(joint, kind) for kind in self.parameters.command_interfaces
                for joint in self.joints]

    def _write(self, share: float) -> None:
        """Command a share of the way to where the internal model is, and its velocities."""
        kinds, end = self.parameters.command_interfaces, self._model.positions
        self._commanded = self._start + share * (end - self._start)
        self._output.write(np.concatenate(
            [self._commanded if kind == POSITION else self._model.velocities for kind in kinds]))

    def _drop(self, topic: str, reason: str) -> str:
        if self.active:
            self._warning.add(self.time_ns, f"message on '{topic}' dropped: {reason}", topic)
        return reason


class CartesianMotionController(NetForceController[CartesianMotionControllerParameters]):
    """``cartesian_motion_controller/CartesianMotionController``."""

    parameters_class: ClassVar[type[Settings]] = CartesianMotionControllerParameters
    takes_poses: ClassVar[bool] = True

    def net_force(self) -> Vector:
        """Return the way to the target."""
        return self.motion_error()


class CartesianForceController(NetForceController[CartesianForceControllerParameters]):
    """``cartesian_force_controller/CartesianForceController``."""

    parameters_class: ClassVar[type[Settings]] = CartesianForceControllerParameters
    takes_wrenches: ClassVar[bool] = True

    def net_force(self) -> Vector:
        """Return measured and target wrench."""
        parameters = self.parameters
        return self.wrench_error(parameters.ft_sensor_ref_link, parameters.end_effector_link,
                                 hand=parameters.hand_frame_control)


class CartesianComplianceController(NetForceController[CartesianComplianceControllerParameters]):
    """``cartesian_compliance_controller/CartesianComplianceController``."""

    parameters_class: ClassVar[type[Settings]] = CartesianComplianceControllerParameters
    takes_poses: ClassVar[bool] = True
    takes_wrenches: ClassVar[bool] = True

    def net_force(self) -> Vector:
        """Return the springs' force, and measured and target wrench."""
        parameters: Any = self.parameters
        turn = self._model.arm.frame(parameters.compliance_ref_link)[:3, :3]
        stiffness = np.array([getattr(parameters.stiffness, axis) for axis in _AXES])
        error = self.motion_error()
        spring = np.concatenate((turn @ (stiffness[:3] * (turn.T @ error[:3])),
                                 turn @ (stiffness[3:] * (turn.T @ error[3:]))))
        return np.asarray(spring + self.wrench_error(
            parameters.ft_sensor_ref_link, parameters.compliance_ref_link,
            hand=parameters.hand_frame_control))


def _chain(model: RobotModel, base: str, tip: str) -> tuple[str, ...]:
    """
    Return the links from a link to a link behind it, both included.

    :raises ControllerError: there is no such chain.
    """
    for key, link in (('robot_base_link', base), ('end_effector_link', tip)):
        if link not in model.links:
            raise ControllerError(f"{key}: no link '{link}'; known: {', '.join(model.links)}")
    chain = [tip]
    while chain[-1] != base:
        joint = model.parent_joint.get(chain[-1])
        if joint is None:
            raise ControllerError(f"there is no chain from robot_base_link '{base}' to "
                                  f"end_effector_link '{tip}'")
        chain.append(model.joints[joint].parent)
    return tuple(reversed(chain))
