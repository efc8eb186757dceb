# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the joint state broadcaster, as ros2_controllers declares them."""

from __future__ import annotations

import math
from typing import Any

from pydantic import field_validator

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.controllers.controller_parameters import ControllerParameters


class ExtraJoint(Settings):
    """A joint that no hardware has; it is published with fixed values."""

    name: str = parameter(..., 'name of the joint', read_only=True, min_length=1)
    position: float = parameter(0.0, 'published position [rad or m]', read_only=True)
    velocity: float = parameter(0.0, 'published velocity [rad/s or m/s]', read_only=True)
    effort: float = parameter(0.0, 'published effort [N*m or N]', read_only=True)


class InterfaceMap(Settings):
    """Which state interface fills which array of the message."""

    position: str = parameter('position', 'state interface to publish as position', read_only=True)
    velocity: str = parameter('velocity', 'state interface to publish as velocity', read_only=True)
    effort: str = parameter('effort', 'state interface to publish as effort', read_only=True)


class JointStateBroadcasterParameters(ControllerParameters):
    """
    Parameters of ``joint_state_broadcaster/JointStateBroadcaster``.

    ``publish_rate`` is ROS 1's; without it the rate is the controller's update rate.
    """

    use_local_topics: bool = parameter(
        False, "publish under the controller's name", read_only=True
    )
    joints: tuple[str, ...] = parameter(
        (), 'joints to publish; restricts only together with interfaces', read_only=True
    )
    interfaces: tuple[str, ...] = parameter(
        (), 'state interfaces to publish; restricts only together with joints', read_only=True
    )
    extra_joints: tuple[ExtraJoint, ...] = parameter(
        (), 'joints without hardware: names, or blocks of name and values', read_only=True
    )
    map_interface_to_joint_state: InterfaceMap = parameter(
        InterfaceMap(), 'custom interface names', read_only=True
    )
    use_urdf_to_filter: bool = parameter(
        True, 'publish only joints that the URDF has', read_only=True
    )
    frame_id: str = parameter('base_link', 'frame in the header', read_only=True)
    publish_dynamic_joint_states: bool = parameter(
        True, 'publish dynamic_joint_states too', read_only=True
    )
    publish_rate: float = parameter(
        math.inf,
        'messages a second of simulated time; inf is each update, 0 is none [Hz]',
        read_only=True,
    )

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
