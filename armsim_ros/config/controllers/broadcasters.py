# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of broadcasters, as their packages declare them."""

from __future__ import annotations

import math
from typing import Any

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import configured, ControllerParameters, fixed, parameter, Settings


class ExtraJoint(Settings):
    """A joint that no hardware has; it is published with fixed values."""

    name: str = fixed(..., 'name of the joint', min_length=1)
    position: float = fixed(0.0, 'published position [rad or m]')
    velocity: float = fixed(0.0, 'published velocity [rad/s or m/s]')
    effort: float = fixed(0.0, 'published effort [N*m or N]')


class InterfaceMap(Settings):
    """Which state interface fills which array of the message."""

    position: str = fixed('position', 'state interface to publish as position')
    velocity: str = fixed('velocity', 'state interface to publish as velocity')
    effort: str = fixed('effort', 'state interface to publish as effort')


class JointStateBroadcasterParameters(ControllerParameters):
    """
    Parameters of ``joint_state_broadcaster/JointStateBroadcaster``.

    ``publish_rate`` is ROS 1's; without it the rate is the controller's update rate.
    """

    use_local_topics: bool = fixed(False, "publish under the controller's name")
    joints: tuple[str, ...] = fixed(
        (), 'joints to publish; restricts only together with interfaces')
    interfaces: tuple[str, ...] = fixed(
        (), 'state interfaces to publish; restricts only together with joints')
    extra_joints: tuple[ExtraJoint, ...] = fixed(
        (), 'joints without hardware: names, or blocks of name and values')
    map_interface_to_joint_state: InterfaceMap = fixed(InterfaceMap(), 'custom interface names')
    use_urdf_to_filter: bool = fixed(True, 'publish only joints that the URDF has')
    frame_id: str = fixed('base_link', 'frame in the header')
    publish_dynamic_joint_states: bool = fixed(True, 'publish dynamic_joint_states too')
    publish_rate: float = fixed(
        math.inf, 'messages a second of simulated time; inf is each update, 0 is none [Hz]')

    @field_validator('extra_joints', mode='before')
    @classmethod
    def _names_are_enough(cls, value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return [{'name': item} if isinstance(item, str) else item for item in value]
        return value

    @field_validator('publish_rate')
    @classmethod
    def _a_rate(cls, value: float) -> float:
        if math.isnan(value):
            raise ValueError('publish_rate must be a number [Hz]')
        return value


_AXES = ('x', 'y', 'z')
_TURN = (*_AXES, 'w')


class BroadcasterParameters(ControllerParameters):
    """
    What all of them share; upstream publishes at every update.

    A name that is needed and empty is reported when the controller is configured.
    """

    publish_rate: float = fixed(
        100.0, 'messages a second, 0 is each update [Hz]', ge=0.0, allow_inf_nan=False)

    @property
    def states(self) -> tuple[str, ...]:
        """State interface of each value of a message, '' for those that have none."""
        raise NotImplementedError

    @property
    def missing(self) -> str:
        """The parameter that has to be given and is empty, '' where there is none."""
        return ''


class AxisNames(Settings):
    """State interfaces of three axes; '' for an axis that is not measured."""

    x: str = parameter('', 'state interface')
    y: str = parameter('', 'state interface')
    z: str = parameter('', 'state interface')

    @property
    def all(self) -> tuple[str, str, str]:
        """Those of x, y, z."""
        return self.x, self.y, self.z


class WrenchNames(Settings):
    """State interfaces of a wrench."""

    force: AxisNames = parameter(AxisNames(), 'of the force')
    torque: AxisNames = parameter(AxisNames(), 'of the torque')


class Offsets(Settings):
    """What is added to each axis."""

    x: float = parameter(0.0, 'offset [N or N*m]', allow_inf_nan=False)
    y: float = parameter(0.0, 'offset [N or N*m]', allow_inf_nan=False)
    z: float = parameter(0.0, 'offset [N or N*m]', allow_inf_nan=False)


class Multipliers(Settings):
    """By what each axis is multiplied, after its offset."""

    x: float = parameter(1.0, 'factor', allow_inf_nan=False)
    y: float = parameter(1.0, 'factor', allow_inf_nan=False)
    z: float = parameter(1.0, 'factor', allow_inf_nan=False)


class WrenchOffsets(Settings):
    """What is added to a wrench."""

    force: Offsets = parameter(Offsets(), 'of the force')
    torque: Offsets = parameter(Offsets(), 'of the torque')


class WrenchMultipliers(Settings):
    """By what a wrench is multiplied."""

    force: Multipliers = parameter(Multipliers(), 'of the force')
    torque: Multipliers = parameter(Multipliers(), 'of the torque')


class ForceTorqueSensorBroadcasterParameters(BroadcasterParameters):
    """Parameters of ``force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster``."""

    sensor_name: str = configured('', 'sensor with all six interfaces')
    interface_names: WrenchNames = configured(
        WrenchNames(), 'state interfaces, in place of sensor_name')
    frame_id: str = configured('', 'frame in the header')
    offset: WrenchOffsets = parameter(WrenchOffsets(), 'added to what is measured')
    multiplier: WrenchMultipliers = parameter(WrenchMultipliers(), 'factors after the offsets')
    sensor_filter_chain: dict[str, Any] = fixed({}, 'has no effect: wrench_filtered is wrench')

    @property
    def states(self) -> tuple[str, ...]:
        """Those of force x, y, z and torque x, y, z."""
        if self.sensor_name:
            return _of(self.sensor_name, ('force', _AXES), ('torque', _AXES))
        return (*self.interface_names.force.all, *self.interface_names.torque.all)

    @property
    def missing(self) -> str:
        """Name what is empty."""
        if not any(self.states):
            return 'sensor_name'
        return '' if self.frame_id else 'frame_id'

    @model_validator(mode='after')
    def _one_of_both(self) -> Self:
        names = (*self.interface_names.force.all, *self.interface_names.torque.all)
        if self.sensor_name and any(names):
            raise ValueError('sensor_name and interface_names exclude each other')
        return self


class IMUSensorBroadcasterParameters(BroadcasterParameters):
    """Parameters of ``imu_sensor_broadcaster/IMUSensorBroadcaster``."""

    sensor_name: str = configured('', 'sensor')
    frame_id: str = configured('', 'frame in the header')
    static_covariance_orientation: tuple[float, ...] = configured(
        (0.0,) * 9, 'covariance (9,) [rad^2]', min_length=9, max_length=9)
    static_covariance_angular_velocity: tuple[float, ...] = configured(
        (0.0,) * 9, 'covariance (9,) [rad^2/s^2]', min_length=9, max_length=9)
    static_covariance_linear_acceleration: tuple[float, ...] = configured(
        (0.0,) * 9, 'covariance (9,) [m^2/s^4]', min_length=9, max_length=9)

    @property
    def states(self) -> tuple[str, ...]:
        """Those of orientation, angular velocity, linear acceleration."""
        return _of(self.sensor_name, ('orientation', _TURN), ('angular_velocity', _AXES),
                   ('linear_acceleration', _AXES))

    @property
    def missing(self) -> str:
        """Name what is empty."""
        return next((key for key in ('sensor_name', 'frame_id') if not getattr(self, key)), '')


class PoseTransform(Settings):
    """The transform that a pose broadcaster sends."""

    enable: bool = parameter(True, 'send the pose on /tf, too')
    child_frame_id: str = parameter('', 'its frame; empty is pose_name')
    publish_rate: float = parameter(0.0, 'transforms a second, 0 is with each pose [Hz]', ge=0.0)


class PoseBroadcasterParameters(BroadcasterParameters):
    """Parameters of ``pose_broadcaster/PoseBroadcaster``."""

    pose_name: str = configured('', 'sensor')
    frame_id: str = configured('', 'frame in the header')
    tf: PoseTransform = configured(PoseTransform(), 'the transform')

    @property
    def states(self) -> tuple[str, ...]:
        """Those of position and orientation."""
        return _of(self.pose_name, ('position', _AXES), ('orientation', _TURN))

    @property
    def missing(self) -> str:
        """Name what is empty."""
        return next((key for key in ('pose_name', 'frame_id') if not getattr(self, key)), '')


class SpeedScalingStateBroadcasterParameters(BroadcasterParameters):
    """Parameters of ``ur_controllers/SpeedScalingStateBroadcaster``."""

    state_publish_rate: float = configured(
        100.0, 'messages a second [Hz]', gt=0.0, allow_inf_nan=False)
    tf_prefix: str = configured('', "before the interface's name")

    @property
    def states(self) -> tuple[str, ...]:
        """That of the factor."""
        return (f'{self.tf_prefix}{SPEED_SCALING}',)


class StateInterfacesBroadcasterParameters(BroadcasterParameters):
    """Parameters of ``state_interfaces_broadcaster/StateInterfacesBroadcaster``."""

    interfaces: tuple[str, ...] = fixed(
        ..., 'state interfaces to publish, as joint/interface', min_length=1)

    @property
    def states(self) -> tuple[str, ...]:
        """Those that are named."""
        return self.interfaces


SPEED_SCALING = 'speed_scaling/speed_scaling_factor'
"""The state interface with the speed scaling of a robot; 1 is as planned."""


def _of(sensor: str, *quantities: tuple[str, tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(f'{sensor}/{name}.{part}' for name, parts in quantities for part in parts)
