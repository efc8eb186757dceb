# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The vendor's numbers and names of modes, and whether the arm starts its program by itself."""

from __future__ import annotations

from xml.etree import ElementTree

from ur_dashboard_msgs.msg import RobotMode, SafetyMode

from armsim_ros.control.safety.arm_state import ArmState, Mode, Safety

MODES: dict[Mode, int] = {
    Mode.POWER_OFF: RobotMode.POWER_OFF, Mode.POWER_ON: RobotMode.POWER_ON,
    Mode.IDLE: RobotMode.IDLE, Mode.RUNNING: RobotMode.RUNNING}
SAFETIES: dict[Safety, tuple[int, str]] = {
    Safety.NORMAL: (SafetyMode.NORMAL, 'NORMAL'),
    Safety.REDUCED: (SafetyMode.REDUCED, 'REDUCED'),
    Safety.PROTECTIVE_STOP: (SafetyMode.PROTECTIVE_STOP, 'PROTECTIVE_STOP'),
    Safety.SAFEGUARD_STOP: (SafetyMode.SAFEGUARD_STOP, 'SAFEGUARD_STOP'),
    Safety.EMERGENCY_STOP: (SafetyMode.ROBOT_EMERGENCY_STOP, 'ROBOT_EMERGENCY_STOP'),
    Safety.FAULT: (SafetyMode.FAULT, 'FAULT'),
}


def robot_mode(arm: ArmState) -> RobotMode:
    """Return the mode of the drives."""
    return RobotMode(mode=MODES[arm.mode])


def safety_mode(arm: ArmState) -> SafetyMode:
    """Return the mode of the safety system."""
    return SafetyMode(mode=SAFETIES[arm.safety][0])


def headless(urdf: str) -> bool:
    """Return whether ``<ros2_control>`` has the driver start its program by itself."""
    root = ElementTree.fromstring(urdf)
    return any((param.text or '').strip().lower() == 'true'
               for param in root.iterfind('ros2_control//param[@name="headless_mode"]'))
