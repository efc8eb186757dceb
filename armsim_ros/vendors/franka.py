# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Franka's arms, as ``franka_ros2`` presents them."""

from __future__ import annotations

from armsim_ros.vendors.vendor import Vendor

#: External torques that are a contact, and that are a collision [N*m]. As
#: ``getDefaultCollisionBehaviorRequest`` (default_robot_behavior_utils.hpp of
#: franka_example_controllers), which the example controllers set before they move.
TORQUES = (25.0, 25.0, 22.0, 20.0, 19.0, 17.0, 14.0), (35.0, 35.0, 32.0, 30.0, 29.0, 27.0, 24.0)
#: The same of the wrench [N, N*m].
FORCES = (30.0, 30.0, 30.0, 25.0, 25.0, 25.0), (40.0, 40.0, 40.0, 35.0, 35.0, 35.0)

VENDOR = Vendor(
    name='franka',
    plugins=('franka_hardware/FrankaHardwareInterface',),
    collision_torques=TORQUES[1],
    collision_force=FORCES[1][0],
    tool='link8',
    finger='_finger_joint1',
    endpoints='armsim_ros.nodes.vendors.franka.endpoints:FrankaEndpoints',
)
