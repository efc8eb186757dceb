# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers as the user wrote them, and the ROS 2 types that they mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
import re
from typing import Any

from armsim_ros.config.base import (
    FreedriveModeControllerParameters,
    keys_at,
    known_keys,
    parameter,
    read_settings,
    Settings,
    StandInParameters,
)
from armsim_ros.config.controllers.broadcasters import (
    ForceTorqueSensorBroadcasterParameters,
    IMUSensorBroadcasterParameters,
    JointStateBroadcasterParameters,
    PoseBroadcasterParameters,
    SpeedScalingStateBroadcasterParameters,
    StateInterfacesBroadcasterParameters,
)
from armsim_ros.config.controllers.command_controllers import (
    AdmittanceControllerParameters,
    ForwardCommandControllerParameters,
    GpioCommandControllerParameters,
    JointEffortControllerParameters,
    JointGroupEffortControllerParameters,
    JointGroupPositionControllerParameters,
    JointGroupVelocityControllerParameters,
    JointPositionControllerParameters,
    JointVelocityControllerParameters,
    MultiInterfaceForwardCommandControllerParameters,
)
from armsim_ros.config.controllers.compliance import (
    CartesianAdmittanceControllerParameters,
    CartesianComplianceControllerParameters,
    CartesianControllerParameters,
    CartesianForceControllerParameters,
    CartesianMotionControllerParameters,
    CrispPoseBroadcasterParameters,
    CrispTwistBroadcasterParameters,
)
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperActionControllerParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
    PassthroughTrajectoryControllerParameters,
    ScaledJointTrajectoryControllerParameters,
)
from armsim_ros.config.controllers.pid_controller import PidControllerParameters
from armsim_ros.config.yaml_node import node_of, split_keys, YamlNode
from armsim_ros.errors import ignored, nearest, Problem, Severity

TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
SCALED_TRAJECTORY = 'ur_controllers/ScaledJointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'

#: ROS 2 type -> its parameters.
PARAMETERS: Mapping[str, type[Settings]] = {
    TRAJECTORY: JointTrajectoryControllerParameters,
    SCALED_TRAJECTORY: ScaledJointTrajectoryControllerParameters,
    'ur_controllers/PassthroughTrajectoryController': PassthroughTrajectoryControllerParameters,
    'ur_controllers/FreedriveModeController': FreedriveModeControllerParameters,
    'ur_controllers/SpeedScalingStateBroadcaster': SpeedScalingStateBroadcasterParameters,
    'force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster':
        ForceTorqueSensorBroadcasterParameters,
    'imu_sensor_broadcaster/IMUSensorBroadcaster': IMUSensorBroadcasterParameters,
    'pose_broadcaster/PoseBroadcaster': PoseBroadcasterParameters,
    'state_interfaces_broadcaster/StateInterfacesBroadcaster':
        StateInterfacesBroadcasterParameters,
    'gpio_controllers/GpioCommandController': GpioCommandControllerParameters,
    'pid_controller/PidController': PidControllerParameters,
    'admittance_controller/AdmittanceController': AdmittanceControllerParameters,
    BROADCASTER: JointStateBroadcasterParameters,
    'position_controllers/GripperActionController': GripperActionControllerParameters,
    'effort_controllers/GripperActionController': GripperActionControllerParameters,
    'parallel_gripper_action_controller/GripperActionController':
        ParallelGripperActionControllerParameters,
    'forward_command_controller/ForwardCommandController': ForwardCommandControllerParameters,
    'forward_command_controller/MultiInterfaceForwardCommandController':
        MultiInterfaceForwardCommandControllerParameters,
    'position_controllers/JointGroupPositionController': JointGroupPositionControllerParameters,
    'velocity_controllers/JointGroupVelocityController': JointGroupVelocityControllerParameters,
    'effort_controllers/JointGroupEffortController': JointGroupEffortControllerParameters,
    'position_controllers/JointPositionController': JointPositionControllerParameters,
    'velocity_controllers/JointVelocityController': JointVelocityControllerParameters,
    'effort_controllers/JointEffortController': JointEffortControllerParameters,
    'crisp_controllers/CartesianController': CartesianControllerParameters,
    'crisp_controllers/CartesianAdmittanceController': CartesianAdmittanceControllerParameters,
    'crisp_controllers/PoseBroadcaster': CrispPoseBroadcasterParameters,
    'crisp_controllers/TwistBroadcaster': CrispTwistBroadcasterParameters,
    'cartesian_motion_controller/CartesianMotionController': CartesianMotionControllerParameters,
    'cartesian_force_controller/CartesianForceController': CartesianForceControllerParameters,
    'cartesian_compliance_controller/CartesianComplianceController':
        CartesianComplianceControllerParameters,
}


@dataclass(frozen=True, slots=True)
class Ros1Type:
    """What a ROS 1 type is called in ROS 2, and the parameters that its name implied."""

    type: str
    implied: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def _trajectory(*command_interfaces: str) -> Ros1Type:
    return Ros1Type(TRAJECTORY, {'command_interfaces': command_interfaces,
                                 'state_interfaces': ('position', 'velocity')})


#: Types of ROS 1's ros_controllers that have an equal in ROS 2.
ROS1_TYPES: Mapping[str, Ros1Type] = {
    'position_controllers/JointTrajectoryController': _trajectory('position'),
    'velocity_controllers/JointTrajectoryController': _trajectory('velocity'),
    'effort_controllers/JointTrajectoryController': _trajectory('effort'),
    'pos_vel_controllers/JointTrajectoryController': _trajectory('position', 'velocity'),
    'pos_vel_acc_controllers/JointTrajectoryController':
        _trajectory('position', 'velocity', 'acceleration'),
    'joint_state_controller/JointStateController': Ros1Type(BROADCASTER),
    # Which loop closed in the controller does not matter where the drives follow by themselves.
    'effort_controllers/JointPositionController':
        Ros1Type('position_controllers/JointPositionController'),
    'velocity_controllers/JointPositionController':
        Ros1Type('position_controllers/JointPositionController'),
    'effort_controllers/JointVelocityController':
        Ros1Type('velocity_controllers/JointVelocityController'),
    'effort_controllers/JointGroupPositionController':
        Ros1Type('position_controllers/JointGroupPositionController'),
}

#: Parameters that hold an entry for each joint of the controller.
_ENTRIES_PER_JOINT = ('constraints', 'gains', 'velocity_ff')

#: Parameters that every ROS 2 controller has, and some of ROS 1 -> why they have no effect here.
UNUSED_CONTROLLER_KEYS: Mapping[str, str] = {
    'use_sim_time': 'it is set once for all nodes of a program',
    'async_parameters': 'all controllers run in the same control loop',
    'lock_memory': '',
    'node_options_args': '',
    'qos_overrides': '',
    'params_file': '',
    'fallback_controllers': 'name them in the block of controller_manager',
    'robot_description': 'the URDF file is read',
    'start_with_holding': 'holding always starts at once',
    'angle_wraparound': 'a continuous joint of the URDF turns without bounds',
    'allow_trajectory_replacement': 'a new trajectory always replaces the running trajectory',
    'positions_upsampling': '',
    'publish_state': '',
    'hardware_interface_type': '',
}


class ControllerSettings(Settings):
    """
    A controller.

    :param type: the ROS 2 type.
    :param source_type: the type as the user wrote it.
    :param parameters: an instance of the class that belongs to the type.
    """

    name: str
    type: str
    source_type: str
    parameters: Any = parameter(..., 'checked parameters of its type')

    @property
    def compat(self) -> str:
        """Whose behaviour it has where they differ: 'jazzy' or 'ros1'."""
        return str(getattr(self.parameters, 'compat', 'jazzy'))

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints that it claims; none for a broadcaster."""
        if self.type == BROADCASTER:
            return ()
        joint = getattr(self.parameters, 'joint', None)
        return (joint,) if joint else tuple(getattr(self.parameters, 'joints', ()))


@dataclass(frozen=True, slots=True)
class StandIn:
    """
    What runs in place of a controller that only its vendor has.

    :param pattern: of the type.
    :param type: the type that runs; '' keeps the vendor's name.
    :param message: the line that a user gets.
    """

    pattern: re.Pattern[str]
    parameters: type[Settings]
    message: str
    type: str = ''


#: The only place that knows of vendors' types: by the last part of their name.
STAND_INS: tuple[StandIn, ...] = (
    StandIn(re.compile(r'.*/ScaledJointTrajectoryController'),
            JointTrajectoryControllerParameters,
            f"type '{{type}}' runs as '{TRAJECTORY}' at full speed", TRAJECTORY),
    StandIn(re.compile(r'.*/\w+JointTrajectoryController'), JointTrajectoryControllerParameters,
            f"type '{{type}}' runs as '{TRAJECTORY}'", TRAJECTORY),
    StandIn(re.compile(r'.*/SpeedScalingStateBroadcaster'), StandInParameters,
            "type '{type}' is replaced: it publishes 100.0, the full speed"),
    StandIn(re.compile(r'joint_state_controller/.*'), JointStateBroadcasterParameters,
            f"type '{{type}}' runs as '{BROADCASTER}'", BROADCASTER),
    StandIn(re.compile(r'.*Broadcaster|.*/GPIOController|ur_controllers/\w+|picknik_\w+/\w+'),
            StandInParameters,
            "type '{type}' is replaced: it can be activated, claims nothing and publishes "
            'nothing, but for what the arm has without it'))


def stand_in_for(kind: str) -> StandIn | None:
    """Return what runs in place of a type that is not ours, None where nothing does."""
    return next((stand_in for stand_in in STAND_INS if stand_in.pattern.fullmatch(kind)), None)


def allowed_types() -> tuple[str, ...]:
    """Return every type that a user may write."""
    return (*PARAMETERS, *ROS1_TYPES)


def read_controller(name: str, node: YamlNode, problems: list[Problem], *,
                    published: bool = False) -> ControllerSettings | None:
    """
    Return a controller, None where its block has errors.

    :param node: its parameters, ``type`` among them.
    :param problems: errors and remarks are added here.
    :param published: whether the file is published, so that its reader will not change.
    """
    title = f"controller '{name}'"
    kind = node.get('type')
    if kind is None or not isinstance(kind.value, str):
        problems.append(Problem(f'{title} has no type', (kind or node).place,
                                ', '.join(allowed_types()), f"add 'type:' to '{name}'"))
        return None
    source_type = kind.value
    ros1 = ROS1_TYPES.get(source_type)
    canonical = ros1.type if ros1 else source_type
    parameters = PARAMETERS.get(canonical)
    stand_in = stand_in_for(source_type) if parameters is None else None
    if stand_in is not None:
        canonical, parameters = stand_in.type or source_type, stand_in.parameters
        problems.append(Problem(f'{title}: {stand_in.message.format(type=source_type)}',
                                kind.where, severity=Severity.CHANGED))
    if parameters is None:
        allowed = ', '.join(allowed_types())
        remedy = nearest(source_type, allowed_types())
        if published:
            allowed, remedy = '', 'it cannot be loaded here'
        problems.append(ignored(Problem(
            f"{title}: type '{source_type}' is not known", kind.where, allowed, remedy)))
        return None
    block = node.without('type')
    if ros1:
        block = _with_implied(block, ros1, kind)
        problems.append(Problem(
            f"{title}: type '{source_type}' is read as '{canonical}'", kind.where,
            severity=Severity.CHANGED))
    if 'gains' in block.entries and canonical == TRAJECTORY and _commands_position(block):
        problems.append(Problem(
            f'{title}: the gains go to the simulated drives, where they take effect; '
            'upstream reads none of a position controller', block.entries['gains'].place,
            severity=Severity.CHANGED))
    block = _without_strays(title, block, parameters, problems, published=published)
    unused = {key: why for key, why in UNUSED_CONTROLLER_KEYS.items()
              if key not in known_keys(parameters)}
    checked = read_settings(parameters, block, problems, title=title, unused=unused)
    if checked is None:
        return None
    return ControllerSettings(
        name=name, type=canonical, source_type=source_type, parameters=checked)


def _without_strays(
    title: str, block: YamlNode, parameters: type[Settings], problems: list[Problem], *,
    published: bool
) -> YamlNode:
    """
    Return the block without what upstream does not read of the entries for each joint.

    That is a key of no meaning, and in a published file what belongs to foreign joints.
    """
    joints = _own_joints(block)
    for key in _ENTRIES_PER_JOINT:
        inner = block.get(key)
        if inner is None or not joints or key not in known_keys(parameters):
            continue
        known = keys_at(parameters, (key,))
        strays = []
        for name, entry in inner.entries.items():
            if name in joints or name in known:
                continue
            if known and not entry.is_mapping:
                problem = Problem(f"{title}: key '{key}.{name}' is not known", entry.place,
                                  ', '.join(known), nearest(name, known))
            elif published:
                problem = Problem(
                    f"{title}: {key}: '{name}' is not among the controller's joints and has no "
                    'effect', entry.place, ', '.join(joints), nearest(name, joints))
            else:
                continue
            strays.append(name)
            problems.append(ignored(problem))
        if strays:
            block = block.with_value({**block.entries, key: inner.without(*strays)})
    return block


def _own_joints(block: YamlNode) -> list[str]:
    """Return the joints that a controller's block names as its own."""
    listed = [node for key in ('joints', 'dof_names', 'joint') if (node := block.get(key))]
    return [str(item.value) for node in listed for item in node.items or (node,)]


def _commands_position(block: YamlNode) -> bool:
    """Whether position is among the command interfaces, as it is where none are given."""
    given = block.get('command_interfaces')
    return given is None or 'position' in [item.value for item in given.items]


def _with_implied(block: YamlNode, ros1: Ros1Type, kind: YamlNode) -> YamlNode:
    """Return the block with the defaults of its ROS 1 type; what is written wins."""
    implied = {key: node_of(value, kind.where) for key, value in ros1.implied.items()}
    return split_keys(block.with_value({**implied, **block.entries}), '/')
