# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Outputs of an arm that switch suction cups, and inputs that show whether they hold something."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import re

from armsim_ros.control.safety.signals import Signals
from armsim_ros.sim.grippers.vacuum_control import VacuumControl

_OUTPUT, _INPUT = re.compile(r'digital_out_\d+'), re.compile(r'digital_in_\d+')
_GRASPING = '/grasping'


def wire_signals(
    signals: Signals, wires: Mapping[str, str], cups: Mapping[str, VacuumControl]
) -> list[str]:
    """
    Connect signals with suction cups.

    :param wires: output -> cup, input -> ``CUP/grasping``.
    :param cups: by name.
    :returns: a line for each wire that leads nowhere.
    """
    problems = []
    for signal, target in wires.items():
        cup = cups.get(target.removesuffix(_GRASPING))
        if cup is not None and _OUTPUT.fullmatch(signal) and not target.endswith(_GRASPING):
            signals.wire({signal: _switch(cup)}, {})
        elif cup is not None and _INPUT.fullmatch(signal) and target.endswith(_GRASPING):
            signals.wire({}, {signal: _holds(cup)})
        else:
            problems.append(
                f"hardware.io: {signal}: '{target}' cannot be wired; allowed: digital_out_N: CUP "
                f'and digital_in_N: CUP{_GRASPING}, with a vacuum gripper as CUP: '
                f'{", ".join(cups) or "there is none"}')
    return problems


def _switch(cup: VacuumControl) -> Callable[[bool], object]:
    return lambda on: cup.on() if on else cup.off()


def _holds(cup: VacuumControl) -> Callable[[], bool]:
    return lambda: bool(cup.gripper.held)
