# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From the planner's name in a request or in ompl_planning.yaml to an OMPL planner."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ompl import geometric as og

from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.log import Log

DEFAULT_PLANNER = 'RRTConnect'

_BOUND: dict[str, Callable[[Any], Any]] = {
    'AORRTC': og.AORRTC,
    'BFMT': og.BFMT,
    'BITstar': og.BITstar,
    'BKPIECE': og.BKPIECE1,
    'FMT': og.FMT,
    'InformedRRTstar': og.InformedRRTstar,
    'KPIECE': og.KPIECE1,
    'LBKPIECE': og.LBKPIECE1,
    'PRM': og.PRM,
    'PRMstar': og.PRMstar,
    'RRT': og.RRT,
    'RRTConnect': og.RRTConnect,
    'RRTstar': og.RRTstar,
    'SORRTstar': og.SORRTstar,
}

# Planner that OMPL's Python package lacks -> planner of the same kind that it has.
_SUBSTITUTES = {
    'AnytimePathShortening': 'RRTConnect',
    'BiEST': 'BKPIECE',
    'BiTRRT': 'RRTConnect',
    'EST': 'KPIECE',
    'LBTRRT': 'RRTstar',
    'LazyPRM': 'PRM',
    'LazyPRMstar': 'PRMstar',
    'LazyRRT': 'RRT',
    'PDST': 'KPIECE',
    'ProjEST': 'KPIECE',
    'SBL': 'LBKPIECE',
    'SPARS': 'PRM',
    'SPARStwo': 'PRM',
    'STRIDE': 'KPIECE',
    'TRRT': 'RRT',
}

PLANNER_TYPES = tuple(sorted({*_BOUND, *_SUBSTITUTES}))
"""All type names that are understood, without ``geometric::``."""

THREADED = frozenset({'PRM', 'PRMstar'})
"""Planners that search for a path in a second thread while the first samples."""


def _boolean(value: object) -> bool:
    return str(value).strip().lower() in ('1', 'true', 'yes', 'on')


_SETTERS: dict[str, tuple[str, Callable[[Any], Any]]] = {
    'border_fraction': ('setBorderFraction', float),
    'cache_cc': ('setCacheCC', _boolean),
    'delay_collision_checking': ('setDelayCC', _boolean),
    'extended_fmt': ('setExtendedFMT', _boolean),
    'failed_expansion_score_factor': ('setFailedExpansionCellScoreFactor', float),
    'focus_search': ('setFocusSearch', _boolean),
    'goal_bias': ('setGoalBias', float),
    'heuristics': ('setHeuristics', _boolean),
    'intermediate_states': ('setIntermediateStates', _boolean),
    'max_nearest_neighbors': ('setMaxNearestNeighbors', int),
    'min_valid_path_fraction': ('setMinValidPathFraction', float),
    'nearest_k': ('setNearestK', _boolean),
    'num_samples': ('setNumSamples', int),
    'radius_multiplier': ('setRadiusMultiplier', float),
    'range': ('setRange', float),
    'rewire_factor': ('setRewireFactor', float),
    'samples_per_batch': ('setSamplesPerBatch', int),
    'use_k_nearest': ('setUseKNearest', _boolean),
}

# Keys that belong to the search as a whole, or that make no difference to it here.
_OTHER_KEYS = frozenset({
    'anytime', 'enforce_constrained_state_space', 'enforce_joint_model_state_space', 'hybridize',
    'interpolate', 'load_planner_data', 'longest_valid_segment_fraction', 'max_hybrid_paths',
    'maximum_waypoint_distance', 'minimum_waypoint_count', 'multi_query_planning_enabled',
    'num_planners', 'optimization_objective', 'planner_data_path', 'planners',
    'projection_evaluator', 'shortcut', 'simplify_solutions', 'store_planner_data',
    'termination_condition', 'type',
})


@dataclass(frozen=True, slots=True)
class PlannerChoice:
    """
    A planner and its parameters.

    :param name: as the user calls it.
    :param type: one of :data:`PLANNER_TYPES` that OMPL binds.
    :param parameters: key -> value of ompl_planning.yaml.
    """

    name: str = DEFAULT_PLANNER
    type: str = DEFAULT_PLANNER
    parameters: Mapping[str, Any] = field(default_factory=dict)

    @property
    def simplify(self) -> bool:
        """Whether the path is to be shortened."""
        return _boolean(self.parameters.get('simplify_solutions', True))

    @property
    def own_search(self) -> bool:
        """Whether RRT-Connect is this package's, with adaptive domains, or OMPL's."""
        return self.type == DEFAULT_PLANNER and _boolean(
            self.parameters.get('adaptive_domains', True))

    def for_repairs(self) -> PlannerChoice:
        """Return what searches pieces of a path again: RRTConnect, whatever found the path."""
        own = self.parameters.get('adaptive_domains', True)
        return PlannerChoice(parameters={'adaptive_domains': own})

    @property
    def anytime(self) -> bool:
        """Whether the time that is left is spent on a shorter path."""
        return _boolean(self.parameters.get('anytime', False))


@dataclass(frozen=True, slots=True)
class PlannerTable:
    """
    The planner configurations of a pipeline, named as MoveIt names them.

    :param configs: ``group`` (the group's default) or ``group[config]`` -> key -> value;
        ``type`` names the planner.
    """

    configs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def planner_ids(self, groups: Iterable[str]) -> tuple[str, ...]:
        """Return all ids that a request may use: the configurations and the groups."""
        return tuple(sorted({*self.configs, *groups}))

    def choose(self, planner_id: str, group: str, log: Log) -> PlannerChoice:
        """
        Return the planner for a request.

        An id that contains the group's name is looked up as it is, any other as ``group[id]``;
        if it is not found, the group's default, with a warning.

        :raises PlanningError: PLANNING_FAILED where a configuration names a type that is not
            known.
        """
        name = planner_id if group in planner_id else f'{group}[{planner_id}]'
        if planner_id and name in self.configs:
            return self._choice(name, self.configs[name], log)
        if planner_id:
            known = self.planner_ids((group,))
            log.warning(
                f"planner '{planner_id}' is not configured for group '{group}': using its default "
                f'planner; {nearest(name, known) or "known: " + ", ".join(known)}')
        return self._choice(group, self.configs.get(group, {}), log)

    @staticmethod
    def _choice(name: str, config: Mapping[str, Any], log: Log) -> PlannerChoice:
        full = str(config.get('type', DEFAULT_PLANNER))
        kind = full.removeprefix('geometric::')
        if kind not in _BOUND and kind.endswith('1'):
            kind = kind[:-1]
        if kind in _SUBSTITUTES:
            log.warning(
                f"planner type '{full}' of '{name}' is not part of OMPL's Python package: "
                f"using geometric::{_SUBSTITUTES[kind]}"
            )
            kind = _SUBSTITUTES[kind]
        if kind not in _BOUND:
            raise PlanningError(
                MoveItErrorCode.PLANNING_FAILED,
                f"planner '{name}' has the unknown type '{full}'; "
                f'{nearest(kind, PLANNER_TYPES)} known: {", ".join(PLANNER_TYPES)}; '
                'change it in ompl_planning.yaml',
                'OMPL',
            )
        return PlannerChoice(name, kind, dict(config))


def settings_of(choice: PlannerChoice, log: Log) -> dict[str, Any]:
    """Return setter -> value of the parameters that the planner has; report all others."""
    kind, settings = _BOUND[choice.type], {}
    for key, value in choice.parameters.items():
        if key in _OTHER_KEYS or (key == 'adaptive_domains' and choice.type == DEFAULT_PLANNER):
            continue
        setter, convert = _SETTERS.get(key, ('', str))
        if not hasattr(kind, setter or '-'):
            hint = nearest(key, (*_SETTERS, 'adaptive_domains', 'anytime', 'simplify_solutions'))
            log.warning(f"planner '{choice.name}' ({choice.type}) has no parameter '{key}': "
                        f"ignored{hint and f'; {hint}'}")
            continue
        try:
            number = convert(value)
        except ValueError:
            log.warning(f"planner '{choice.name}': parameter '{key}' is '{value}', which is "
                        'no number: ignored')
            continue
        if key != 'range' or number > 0.0:
            settings[setter] = number
    return settings


def make_planner(
    choice: PlannerChoice, space_information: Any, default_range: float, log: Log
) -> Any:
    """
    Return a set-up OMPL planner.

    :param space_information: ``ompl.base.SpaceInformation``.
    :param default_range: length of an extension [rad or m] where none is configured.
    """
    planner = _BOUND[choice.type](space_information)
    if hasattr(planner, 'setRange'):
        planner.setRange(default_range)
    for setter, value in settings_of(choice, log).items():
        getattr(planner, setter)(value)
    return planner
