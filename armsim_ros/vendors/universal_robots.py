# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Universal Robots, as ``ur_robot_driver`` of Jazzy presents them."""

from __future__ import annotations

from armsim_ros.vendors.vendor import Vendor

VENDOR = Vendor(
    name='ur',
    plugins=('ur_robot_driver/URPositionHardwareInterface',),
    unlock_delay=5.0,
    power_step=1.0,
    # Neither is of the driver, which leaves both to the controller of the arm: a share and a
    # force at which nothing stops in free motion, and everything in a blow.
    collision_effort=0.5,
    collision_force=150.0,
    emergency_power_off=True,
    program=True,
    pace='speed_scaling/speed_scaling_factor',
    tool='tool0',
    endpoints='armsim_ros.nodes.vendors.universal_robots.endpoints:UniversalRobots',
)
