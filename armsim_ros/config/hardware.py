# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of an arm's drives and its safety (``hardware``)."""

from __future__ import annotations

from typing import Literal

from armsim_ros.config.base import parameter, Settings


class CollisionSettings(Settings):
    """When a load from outside stops the arm."""

    torque: float = parameter(
        0.0, "external torque of a joint that stops the arm after 10 ms [N*m or N]; 0 takes the "
        "vendor's, and never stops an arm without a vendor", ge=0.0, read_only=True)
    force: float = parameter(
        0.0, "contact force that stops the arm after 10 ms [N]; 0 takes the vendor's, and never "
        'stops an arm without a vendor', ge=0.0, read_only=True)


class HardwareSettings(Settings):
    """The arm behind its controllers."""

    vendor: str = parameter(
        '', "'' is the vendor of the plugin in <ros2_control>, 'none' is none; or the name of a "
        'vendor, or of a Python module that has one', read_only=True)
    start: Literal['RUNNING', 'IDLE', 'POWER_OFF'] = parameter(
        'RUNNING', 'mode of the drives at the start', read_only=True)
    program: Literal['PLAYING', 'STOPPED'] = parameter(
        'PLAYING', 'what the program does at the start by which an arm of some vendors takes '
        'commands', read_only=True)
    io: dict[str, str] = parameter(
        {}, 'digital output -> vacuum gripper, or joint of a gripper controller, that it '
        "switches; digital input -> 'VACUUM_GRIPPER/grasping'", read_only=True)
    gripper: str = parameter(
        '', "node of the hand of a vendor that has one; '' is <ARM>_gripper", read_only=True)
    unlock_delay: float = parameter(
        -1.0, "time that a protective stop lasts at least [s]; below 0 the vendor's, or 0",
        read_only=True, allow_inf_nan=False)
    watch: Literal['auto', 'always', 'never'] = parameter(
        'auto', 'whether speed, position and loads from outside can stop the arm; auto: where '
        'collision or the vendor sets a limit', read_only=True)
    collision: CollisionSettings = parameter(
        CollisionSettings(), 'loads from outside that stop the arm')
