# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gains of a joint's PID, with the names of control_toolbox."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, Settings


class PidGains(Settings):
    """Gains of ``u = ff*v_d + p*e + I + d*(v_d - v)`` and what bounds I and u."""

    p: float = parameter(0.0, 'proportional gain', allow_inf_nan=False)
    i: float = parameter(0.0, 'integral gain', allow_inf_nan=False)
    d: float = parameter(0.0, 'derivative gain', allow_inf_nan=False)
    i_clamp: float = parameter(
        math.inf, 'deprecated: bound of the integral part, both ways; 0 switches it off', ge=0.0
    )
    i_clamp_max: float = parameter(math.inf, 'upper bound of the integral part', ge=0.0)
    i_clamp_min: float = parameter(-math.inf, 'lower bound of the integral part', le=0.0)
    ff_velocity_scale: float = parameter(
        0.0, 'share of the desired velocity in the command', allow_inf_nan=False
    )
    u_clamp_max: float = parameter(math.inf, 'upper bound of the output')
    u_clamp_min: float = parameter(-math.inf, 'lower bound of the output')
    antiwindup_strategy: Literal[
        'legacy', 'none', 'back_calculation', 'conditional_integration'
    ] = parameter('legacy', 'what keeps the integral part from winding up', read_only=True)
    tracking_time_constant: float = parameter(
        0.0, 'of back_calculation, 0 takes it from the gains [s]', ge=0.0
    )
    error_deadband: float = parameter(0.0, 'errors below do not integrate [rad or m]', ge=0.0)
    antiwindup: bool = parameter(
        False,
        'ROS 1: clamp the integrated error instead of its part in the output',
        read_only=True,
    )

    @model_validator(mode='after')
    def _ordered(self) -> Self:
        if self.u_clamp_min > self.u_clamp_max:
            raise ValueError(
                f'u_clamp_min {self.u_clamp_min:g} is above u_clamp_max {self.u_clamp_max:g}'
            )
        return self

    @property
    def integral_bounds(self) -> tuple[float, float]:
        """Bounds of the integral part; a finite bound of its own overrides i_clamp."""
        lower = self.i_clamp_min if math.isfinite(self.i_clamp_min) else -self.i_clamp
        upper = self.i_clamp_max if math.isfinite(self.i_clamp_max) else self.i_clamp
        return lower, upper
