# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What can be wrong with a joint on purpose."""

from __future__ import annotations

from armsim_ros.config.base import parameter, Settings


class JointFault(Settings):
    """What is wrong with a joint, so that tests can make tolerances fail."""

    lag: float = parameter(
        0.0,
        'time constant with which the joint follows position commands, 0 for none [s]',
        ge=0.0,
        allow_inf_nan=False,
    )
    bias: float = parameter(
        0.0, 'added to the position commands of the joint [rad or m]', allow_inf_nan=False
    )
    blocked: bool = parameter(False, 'the joint does not move, whatever is commanded')

    def __str__(self) -> str:
        """Return the fault in words."""
        words = [f'lag {self.lag:g} s'] if self.lag else []
        words += [f'bias {self.bias:g}'] if self.bias else []
        words += ['blocked'] if self.blocked else []
        return ', '.join(words) or 'none'


class JointFaults(Settings):
    """The faults of all joints, as parameters of a node."""

    faults: dict[str, JointFault] = parameter({}, 'joint -> what is wrong with it')
