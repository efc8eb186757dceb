# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the PID controller and of PID gains, named as in ros2_control."""

from __future__ import annotations

from collections.abc import Mapping
import math
import re
from typing import Any, Literal

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import (
    configured,
    ControllerParameters,
    entry_per_name,
    fixed,
    parameter,
    Settings,
    unique_names,
)

_PART_OF_A_TOPIC = re.compile(r'[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)


class PidGains(Settings):
    """Gains of ``u = ff*v_d + p*e + I + d*(v_d - v)`` and what bounds I and u."""

    p: float = parameter(0.0, 'proportional gain', allow_inf_nan=False)
    i: float = parameter(0.0, 'integral gain', allow_inf_nan=False)
    d: float = parameter(0.0, 'derivative gain', allow_inf_nan=False)
    i_clamp: float = parameter(
        math.inf, 'deprecated: bound of the integral part, both ways; 0 switches it off', ge=0.0)
    i_clamp_max: float = parameter(math.inf, 'upper bound of the integral part', ge=0.0)
    i_clamp_min: float = parameter(-math.inf, 'lower bound of the integral part', le=0.0)
    ff_velocity_scale: float = parameter(
        0.0, 'share of the desired velocity in the command', allow_inf_nan=False)
    u_clamp_max: float = parameter(math.inf, 'upper bound of the output')
    u_clamp_min: float = parameter(-math.inf, 'lower bound of the output')
    antiwindup_strategy: Literal[
        'legacy', 'none', 'back_calculation', 'conditional_integration'
    ] = fixed('legacy', 'what keeps the integral part from winding up')
    tracking_time_constant: float = parameter(
        0.0, 'of back_calculation, 0 takes it from the gains [s]', ge=0.0)
    error_deadband: float = parameter(0.0, 'errors below do not integrate [rad or m]', ge=0.0)
    antiwindup: bool = fixed(
        False, 'ROS 1: clamp the integrated error instead of its part in the output')

    @model_validator(mode='after')
    def _ordered(self) -> Self:
        if self.u_clamp_min > self.u_clamp_max:
            raise ValueError(
                f'u_clamp_min {self.u_clamp_min:g} is above u_clamp_max {self.u_clamp_max:g}')
        return self

    @property
    def integral_bounds(self) -> tuple[float, float]:
        """Bounds of the integral part; a finite bound of its own overrides i_clamp."""
        lower = self.i_clamp_min if math.isfinite(self.i_clamp_min) else -self.i_clamp
        upper = self.i_clamp_max if math.isfinite(self.i_clamp_max) else self.i_clamp
        return lower, upper


class DofGains(PidGains):
    """Gains of a degree of freedom."""

    feedforward_gain: float = parameter(
        0.0, 'share of the reference, or of its derivative, in the command', allow_inf_nan=False)
    angle_wraparound: bool = parameter(False, 'take the shorter way round')
    save_i_term: bool = parameter(True, 'keep the integral part through a deactivation')
    activate_state_publisher: bool = parameter(
        False, 'publish the parts of the command on ~/<dof>/pid_state')


class PidControllerParameters(ControllerParameters):
    """
    Parameters of ``pid_controller/PidController``.

    What is needed and empty is reported when the controller is configured.
    """

    dof_names: tuple[str, ...] = fixed(
        (), 'what is commanded: joints, or joints of a following controller')
    reference_and_state_dof_names: tuple[str, ...] = fixed(
        (), 'what is measured and has references; empty is dof_names')
    command_interface: str = fixed('', 'interface that is commanded')
    reference_and_state_interfaces: tuple[str, ...] = fixed(
        (), 'what is controlled, and its derivative', max_length=2)
    use_external_measured_states: bool = configured(
        False, 'take the states from ~/measured_state instead of state interfaces')
    enable_feedforward: bool = parameter(False, 'add feedforward_gain times the reference')
    set_current_state_as_first_setpoint: bool = parameter(
        True, 'hold what is measured until a reference comes')
    gains: dict[str, DofGains] = parameter({}, 'degree of freedom -> its gains, 0 by default')

    @field_validator('dof_names', 'reference_and_state_dof_names',
                     'reference_and_state_interfaces')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return unique_names(value)

    @model_validator(mode='before')
    @classmethod
    def _gains_of_all(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        gains = entry_per_name(data.get('dof_names', ()), data.get('gains', {}))
        return {**data, 'gains': gains}

    @model_validator(mode='after')
    def _together(self) -> Self:
        measured = self.reference_and_state_dof_names
        if measured and len(measured) != len(self.dof_names):
            raise ValueError(f'reference_and_state_dof_names has {len(measured)} names and '
                             f'dof_names {len(self.dof_names)}')
        strange = sorted(set(self.gains) - set(self.dof_names))
        if strange:
            raise ValueError(f"gains: '{strange[0]}' is not among dof_names "
                             f'({", ".join(self.dof_names)})')
        for name, gains in self.gains.items():
            if gains.activate_state_publisher and not _PART_OF_A_TOPIC.fullmatch(name):
                raise ValueError(f"gains: '{name}' cannot be part of a topic's name, as "
                                 'activate_state_publisher needs it')
        return self

    @property
    def measured(self) -> tuple[str, ...]:
        """What is measured and has references, in the order of ``dof_names``."""
        return self.reference_and_state_dof_names or self.dof_names

    @property
    def joints(self) -> tuple[str, ...]:
        """What is commanded."""
        return self.dof_names

    @property
    def missing(self) -> str:
        """The parameter that has to be given and is empty, '' where there is none."""
        needed = ('dof_names', 'command_interface', 'reference_and_state_interfaces')
        return next((key for key in needed if not getattr(self, key)), '')
