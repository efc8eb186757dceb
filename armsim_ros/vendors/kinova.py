# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Kinova's Gen3, as ``ros2_kortex`` presents it."""

from __future__ import annotations

from armsim_ros.vendors.vendor import Vendor

VENDOR = Vendor(
    name='kinova',
    plugins=('kortex_driver/KortexMultiInterfaceHardware',),
    tool='end_effector_link',
    endpoints='armsim_ros.nodes.vendors.kinova:KinovaEndpoints',
)
