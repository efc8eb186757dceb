# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where the joints start."""

from __future__ import annotations

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.config.simulation import SimulationSettings
from armsim_ros.errors import Location, nearest, Problem, Severity, SimulationError
from armsim_ros.model.robot_model import RobotModel

#: Keys of simulation.yaml for the start positions of joints.
START_KEYS = ('initial_positions', 'initial_state')


def initial_positions(model: RobotModel, settings: SimulationSettings) -> dict[str, float]:
    """
    Return the positions at the start that the settings give, by joint [rad or m].

    The named state comes first, single joints win over it.

    :raises SimulationError: an unknown state or joint, or a position outside the limits.
    """
    requested = dict(_named_state(model, settings.initial_state))
    requested.update(settings.initial_positions)
    for name, position in requested.items():
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
    return requested


def with_hardware_start(settings: RobotSettings, model: RobotModel
                        ) -> tuple[RobotSettings, list[Problem]]:
    """
    Return settings in which the joints start as given by the URDF's hardware or the package.

    The user's own settings win: single joints, and the joints of a named state. A joint
    of the hardware without a value starts at 0, or at the limit nearest to it.

    :returns: the settings, and a warning for each value that does not fit.
    """
    simulation = settings.simulation
    places = dict(settings.start)
    for name, joint in model.hardware_joints.items():
        if model.joints[name].active:
            places[name] = places.get(name, 0.0) if joint.initial is None else joint.initial
    problems: list[Problem] = []
    where = Location(str(settings.urdf_file))
    if simulation.initial_state:
        for name in _named_state(model, simulation.initial_state):
            places.pop(name, None)
    start: dict[str, float] = {}
    for name, value in places.items():
        found = model.joints.get(name)
        if found is None or not found.active:
            if found is None:
                problems.append(Problem(
                    f"the start of joint '{name}' is left out: it is not in the URDF", where,
                    '', nearest(name, model.active_joints), Severity.WARNING))
            continue
        start[name] = min(max(value, found.limits.lower), found.limits.upper)
        if start[name] != value and name not in simulation.initial_positions:
            problems.append(Problem(
                f"joint '{name}' starts at {start[name]:g}: {value:g} is outside its limits",
                where, '', '', Severity.WARNING))
    if not start:
        return settings, problems
    moved = simulation.model_copy(
        update={'initial_positions': {**start, **simulation.initial_positions}})
    return settings.model_copy(update={'simulation': moved}), problems


def _named_state(model: RobotModel, requested: str) -> dict[str, float]:
    if not requested:
        return {}
    states = model.semantic.named_states
    group, _, name = requested.rpartition('/')
    for candidate, values in states.items():
        if name in values and group in ('', candidate):
            return values[name]
    known = [f'{key}/{state}' for key, values in states.items() for state in values]
    raise SimulationError(
        f"the initial state '{requested}' is not in the SRDF of robot '{model.name}'; "
        f'allowed: {", ".join(known) or "the SRDF has none"}'
    )
