# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.servo_client.devices.ps4_dualshock``."""

from armsim_ros.moveit_py.devices import (
    DualShockAxes,
    DualShockButtons,
    PS4DualShock,
    PS4DualShockTeleop,
)

__all__ = ['DualShockAxes', 'DualShockButtons', 'PS4DualShock', 'PS4DualShockTeleop']
