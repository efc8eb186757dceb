# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the two kinds of gripper controller, as ros2_controllers declares them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import model_validator

from armsim_ros.config.base import ControllerParameters, fixed, parameter
from armsim_ros.config.controllers.pid_controller import PidGains


class GripperParameters(ControllerParameters):
    """What both kinds share."""

    joint: str = fixed(..., 'the joint that moves the fingers', min_length=1)
    goal_tolerance: float = parameter(
        0.01, 'the goal is reached inside this distance [rad or m]', ge=0.0)
    allow_stalling: bool = parameter(False, 'a stalled gripper has succeeded')
    stall_velocity_threshold: float = parameter(
        0.001, 'slower than this is stalled, below 0 nothing is [rad/s or m/s]')
    stall_timeout: float = parameter(1.0, 'slow for longer than this is stalled [s]')
    action_monitor_rate: float = fixed(
        20.0, 'checks a second for a result [Hz]', ge=0.1, allow_inf_nan=False)


class GripperGains(PidGains):
    """Gains of an effort gripper, which integrates nothing without ``i_clamp``."""

    i_clamp: float = parameter(
        0.0, 'bound of the integral part, both ways; 0 switches it off', ge=0.0)


class GripperActionControllerParameters(GripperParameters):
    """
    Parameters of ``position_controllers/`` and ``effort_controllers/GripperActionController``.

    ``gains`` are used by the effort kind alone.
    """

    max_effort: float = parameter(0.0, 'effort of a goal that names none [N*m or N]', ge=0.0)
    gains: dict[str, GripperGains] = parameter({}, "joint -> gains of the effort kind's PID")

    @model_validator(mode='before')
    @classmethod
    def _gains_of_the_joint(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or not isinstance(data.get('joint'), str):
            return data
        gains = data.get('gains', {})
        if not isinstance(gains, Mapping):
            return data
        foreign = [name for name in gains if name != data['joint']]
        if foreign:
            raise ValueError(f"gains: '{foreign[0]}' is not the joint '{data['joint']}'")
        return {**data, 'gains': {data['joint']: gains.get(data['joint'], {})}}


class ParallelGripperActionControllerParameters(GripperParameters):
    """Parameters of ``parallel_gripper_action_controller/GripperActionController``."""

    state_interfaces: tuple[Literal['position', 'velocity'], ...] = fixed(
        ('position', 'velocity'), 'interfaces to read')
    stall_timeout: float = parameter(1.0, 'slow for longer than this is stalled [s]', ge=0.0)
    max_effort_interface: str = fixed(
        '', "command interface for a goal's effort, as joint/interface")
    max_effort: float = parameter(10.0, 'effort of a goal that names none [N*m or N]', ge=0.0)
    max_velocity_interface: str = fixed(
        '', "command interface for a goal's velocity, as joint/interface")
    max_velocity: float = parameter(
        0.1, 'velocity of a goal that names none [rad/s or m/s]', ge=0.0)
