# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Franka's arms, as ``franka_ros2`` presents them."""

from __future__ import annotations

from armsim_ros.vendors.vendor import Vendor

VENDOR = Vendor(
    name='franka',
    plugins=('franka_hardware/FrankaHardwareInterface',),
    tool='link8',
    finger='_finger_joint1',
    endpoints='armsim_ros.nodes.vendors.franka.endpoints:FrankaEndpoints',
)
