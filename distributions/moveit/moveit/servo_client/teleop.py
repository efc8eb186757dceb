# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.servo_client.teleop``."""

from armsim_ros.moveit_py.devices import TeleopDevice

__all__ = ['TeleopDevice']
