# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the joints start."""

from __future__ import annotations

from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.errors import nearest, SimulationError
from armsim_ros.model.robot_model import RobotModel

#: Keys of simulation.yaml that say where the joints start.
START_KEYS = ('initial_positions', 'initial_state')


def initial_positions(model: RobotModel, settings: SimulationSettings) -> dict[str, float]:
    """
    Return the positions at the start that the settings give, by joint [rad or m].

    The named state comes first, single joints win over it.

    :raises SimulationError: an unknown state or joint, or a position outside the limits.
    """
    wanted = dict(_named_state(model, settings.initial_state))
    wanted.update(settings.initial_positions)
    for name, position in wanted.items():
        joint = model.joints.get(name)
        if joint is None or not joint.active:
            raise SimulationError(
                f"the initial position of '{name}' does not fit robot '{model.name}'; "
                f'allowed: {", ".join(model.active_joints)}; ' + nearest(name, model.active_joints)
            )
        if not joint.limits.lower <= position <= joint.limits.upper:
            raise SimulationError(
                f"the initial position {position:g} of joint '{name}' is outside its limits; "
                f'allowed: {joint.limits.lower:g} to {joint.limits.upper:g}'
            )
    return wanted


def _named_state(model: RobotModel, wanted: str) -> dict[str, float]:
    if not wanted:
        return {}
    states = model.semantic.named_states
    group, _, name = wanted.rpartition('/')
    for candidate, values in states.items():
        if name in values and group in ('', candidate):
            return values[name]
    known = [f'{one}/{state}' for one, values in states.items() for state in values]
    raise SimulationError(
        f"the initial state '{wanted}' is not in the SRDF of robot '{model.name}'; "
        f'allowed: {", ".join(known) or "the SRDF has none"}'
    )
