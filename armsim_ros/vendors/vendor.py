# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The table of a vendor."""

from __future__ import annotations

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True, kw_only=True)
class Vendor:
    """
    What an arm of a vendor does that others do not.

    :param name: short name.
    :param plugins: of ``<ros2_control>`` of such an arm.
    :param unlock_delay: a protective stop lasts at least so long [s].
    :param power_step: each step of powering up lasts so long [s].
    :param collision_torques: external torques of the arm's joints that stop it, from the base on;
        the last is that of all further joints [N*m or N].
    :param collision_effort: share of a joint's effort limit that stops it as an external torque.
    :param collision_force: contact force that stops it [N].
    :param emergency_power_off: whether a released emergency stop leaves the drives without power.
    :param program: whether the arm takes commands only while a program runs on it; while none
        does, the controllers of the arm are inactive.
    :param pace: state interface with the pace of trajectories, without the robot's prefix.
    :param tool: link at which payloads are given, without the robot's prefix.
    :param finger: end of the name of the joint that moves the fingers of the vendor's hand.
    :param endpoints: ``module:function`` that makes what the driver offers to ROS beside its
        controllers; see ``armsim_ros.nodes.vendors``.
    """

    name: str
    plugins: tuple[str, ...] = ()
    unlock_delay: float = 0.0
    power_step: float = 0.0
    collision_torques: tuple[float, ...] = (math.inf,)
    collision_effort: float = math.inf
    collision_force: float = math.inf
    emergency_power_off: bool = False
    program: bool = False
    pace: str = ''
    tool: str = ''
    finger: str = ''
    endpoints: str = ''
