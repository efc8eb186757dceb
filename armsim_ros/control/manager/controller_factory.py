# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the type in a user's file to a controller."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Protocol

from pydantic import ValidationError

from armsim_ros.config.base import FreedriveModeControllerParameters, Settings, StandInParameters
from armsim_ros.config.controllers.controller_settings import stand_in_for
from armsim_ros.control.broadcaster import (
    CrispPoseBroadcaster,
    CrispTwistBroadcaster,
    ForceTorqueSensorBroadcaster,
    IMUSensorBroadcaster,
    PoseBroadcaster,
    SpeedScalingStateBroadcaster,
    StateInterfacesBroadcaster,
)
from armsim_ros.control.command_controllers.admittance_controller import AdmittanceController
from armsim_ros.control.command_controllers.forward_command_controller import (
    ForwardCommandController,
    JointEffortController,
    JointGroupEffortController,
    JointGroupPositionController,
    JointGroupVelocityController,
    JointPositionController,
    JointVelocityController,
    MultiInterfaceForwardCommandController,
)
from armsim_ros.control.command_controllers.gpio_command_controller import GpioCommandController
from armsim_ros.control.command_controllers.gripper_controller import (
    GripperController,
    ParallelGripperController,
)
from armsim_ros.control.command_controllers.pid_controller import PidController
from armsim_ros.control.compliance.cartesian_controller import (
    CartesianAdmittanceController,
    CartesianController,
)
from armsim_ros.control.compliance.net_force_controllers import (
    CartesianComplianceController,
    CartesianForceController,
    CartesianMotionController,
)
from armsim_ros.control.controller import Controller, ControllerContext
from armsim_ros.control.joint_state_broadcaster import JointStateBroadcaster
from armsim_ros.control.parameter_changes import describe
from armsim_ros.control.trajectory.joint_trajectory_controller import (
    JointTrajectoryController,
    PassthroughTrajectoryController,
    ScaledJointTrajectoryController,
)
from armsim_ros.errors import ControllerError, nearest


class StandInController(Controller[StandInParameters]):
    """Claims nothing and commands nothing; its life cycle is that of any controller."""

    parameters_class: ClassVar[type[Settings]] = StandInParameters

    def configure(self) -> None:
        """Do nothing."""

    def activate(self, time_ns: int) -> None:
        """Do nothing."""

    def deactivate(self, time_ns: int) -> None:
        """Do nothing."""

    def update(self, time_ns: int, period: float) -> None:
        """Do nothing."""


class FreedriveModeController(StandInController):
    """``ur_controllers/FreedriveModeController``: has the whole arm, and commands nothing."""

    parameters_class: ClassVar[type[Settings]] = FreedriveModeControllerParameters
    frees_arm: ClassVar[bool] = True


class LoadableController(Protocol):
    """What the manager has to know of a controller to load it."""

    @property
    def name(self) -> str:
        """Name of the controller."""

    @property
    def type(self) -> str:
        """ROS 2 type of the controller."""

    @property
    def parameters(self) -> Settings | Mapping[str, Any]:
        """Checked parameters, or a mapping to check."""


CONTROLLER_TYPES: Mapping[str, type[Controller[Any]]] = {
    'joint_trajectory_controller/JointTrajectoryController': JointTrajectoryController,
    'ur_controllers/ScaledJointTrajectoryController': ScaledJointTrajectoryController,
    'ur_controllers/PassthroughTrajectoryController': PassthroughTrajectoryController,
    'ur_controllers/FreedriveModeController': FreedriveModeController,
    'ur_controllers/SpeedScalingStateBroadcaster': SpeedScalingStateBroadcaster,
    'force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster': ForceTorqueSensorBroadcaster,
    'imu_sensor_broadcaster/IMUSensorBroadcaster': IMUSensorBroadcaster,
    'pose_broadcaster/PoseBroadcaster': PoseBroadcaster,
    'state_interfaces_broadcaster/StateInterfacesBroadcaster': StateInterfacesBroadcaster,
    'gpio_controllers/GpioCommandController': GpioCommandController,
    'pid_controller/PidController': PidController,
    'admittance_controller/AdmittanceController': AdmittanceController,
    'joint_state_broadcaster/JointStateBroadcaster': JointStateBroadcaster,
    'position_controllers/GripperActionController': GripperController,
    'effort_controllers/GripperActionController': GripperController,
    'parallel_gripper_action_controller/GripperActionController': ParallelGripperController,
    'forward_command_controller/ForwardCommandController': ForwardCommandController,
    'forward_command_controller/MultiInterfaceForwardCommandController':
        MultiInterfaceForwardCommandController,
    'position_controllers/JointGroupPositionController': JointGroupPositionController,
    'velocity_controllers/JointGroupVelocityController': JointGroupVelocityController,
    'effort_controllers/JointGroupEffortController': JointGroupEffortController,
    'position_controllers/JointPositionController': JointPositionController,
    'velocity_controllers/JointVelocityController': JointVelocityController,
    'effort_controllers/JointEffortController': JointEffortController,
    'crisp_controllers/CartesianController': CartesianController,
    'crisp_controllers/CartesianAdmittanceController': CartesianAdmittanceController,
    'crisp_controllers/PoseBroadcaster': CrispPoseBroadcaster,
    'crisp_controllers/TwistBroadcaster': CrispTwistBroadcaster,
    'cartesian_motion_controller/CartesianMotionController': CartesianMotionController,
    'cartesian_force_controller/CartesianForceController': CartesianForceController,
    'cartesian_compliance_controller/CartesianComplianceController':
        CartesianComplianceController,
}


def controller_class(type: str) -> type[Controller[Any]]:  # noqa: A002
    """Return the class of a type; ControllerError names the known types."""
    try:
        return CONTROLLER_TYPES[type]
    except KeyError:
        stand_in = stand_in_for(type)
        if stand_in is not None:
            return CONTROLLER_TYPES.get(stand_in.type, StandInController)
        known = tuple(CONTROLLER_TYPES)
        hint = nearest(type, known)
        raise ControllerError(
            f"unknown controller type '{type}'; allowed: {', '.join(known)}"
            f'{"; " if hint else ""}{hint}'
        ) from None


def parameters_class(type: str) -> type[Settings]:  # noqa: A002
    """Return the class of a type's parameters; ControllerError names the known types."""
    return controller_class(type).parameters_class


def create_controller(
    name: str,
    type: str,  # noqa: A002
    parameters: Settings | Mapping[str, Any],
    context: ControllerContext,
) -> Controller[Any]:
    """
    Return an unconfigured controller.

    :param parameters: checked, or as a mapping that is checked here.
    :raises ControllerError: unknown type, or parameters that are wrong, all of them named.
    """
    cls = controller_class(type)
    if not isinstance(parameters, Settings):
        try:
            parameters = cls.parameters_class.model_validate(dict(parameters))
        except ValidationError as error:
            raise ControllerError('; '.join(map(describe, error.errors()))) from None
    if not isinstance(parameters, cls.parameters_class):
        raise ControllerError(
            f"controller '{name}' of type {type} needs {cls.parameters_class.__name__}, "
            f'not {parameters.__class__.__name__}')
    if 'update_rate' not in parameters.model_fields_set:
        parameters = parameters.model_copy(update={'update_rate': context.update_rate})
    return cls(name, type, parameters, context)
