# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the PID controller, as pid_controller declares them."""

from __future__ import annotations

from pydantic import field_validator, model_validator
from typing_extensions import Self

from armsim_ros.config.base import parameter, unique_names
from armsim_ros.config.controllers.controller_parameters import ControllerParameters
from armsim_ros.config.controllers.pid_gains import PidGains


class DofGains(PidGains):
    """Gains of a degree of freedom."""

    feedforward_gain: float = parameter(
        0.0, 'share of the reference, or of its derivative, in the command', allow_inf_nan=False
    )
    angle_wraparound: bool = parameter(False, 'take the shorter way round')
    save_i_term: bool = parameter(True, 'keep the integral part through a deactivation')


class PidControllerParameters(ControllerParameters):
    """
    Parameters of ``pid_controller/PidController``.

    What is needed and empty is reported when the controller is configured.
    """

    dof_names: tuple[str, ...] = parameter(
        (), 'what is commanded: joints, or joints of a following controller', read_only=True
    )
    reference_and_state_dof_names: tuple[str, ...] = parameter(
        (), 'what is measured and has references; empty is dof_names', read_only=True
    )
    command_interface: str = parameter('', 'interface that is commanded', read_only=True)
    reference_and_state_interfaces: tuple[str, ...] = parameter(
        (), 'what is controlled, and its derivative', read_only=True, max_length=2
    )
    use_external_measured_states: bool = parameter(
        False, 'take the states from ~/measured_state instead of state interfaces', read_only=True
    )
    enable_feedforward: bool = parameter(False, 'add feedforward_gain times the reference')
    set_current_state_as_first_setpoint: bool = parameter(
        True, 'hold what is measured until a reference comes'
    )
    gains: dict[str, DofGains] = parameter({}, 'degree of freedom -> its gains')

    @field_validator('dof_names', 'reference_and_state_dof_names',
                     'reference_and_state_interfaces')
    @classmethod
    def _unique(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        return unique_names(value)

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
        lacking = [key for key in needed if not getattr(self, key)]
        lacking += [f'gains.{name}' for name in self.dof_names if name not in self.gains]
        return lacking[0] if lacking else ''
