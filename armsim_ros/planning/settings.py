# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a user may set about planning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from armsim_ros.config.move_group.kinematics import KinematicsSettings
from armsim_ros.config.move_group.ompl_planning import (
    CartesianLimits,
    OmplSettings,
    PlanningParameters,
)
from armsim_ros.planning.collision.state_validity import FINE_STEP
from armsim_ros.planning.search.planners import DEFAULT_PLANNER, PlannerTable


@dataclass(frozen=True, slots=True)
class PlanningSettings:
    """
    Settings of the motion planner.

    :param planners: the content of ompl_planning.yaml.
    :param pipelines: names of the planning pipelines.
    :param default_pipeline: used where a request names none.
    :param position_only_ik: groups whose inverse kinematics leaves orientations free.
    :param strict_start_state: a start state that is not a diff drops attached objects.
    :param start_state_max_bounds_error: a start may be this far [rad or m] beyond a limit.
    :param request_adapters: names of the steps before planning that the user lists.
    :param jiggle_fraction: share of the joints' ranges by which a colliding start may be moved.
    :param max_sampling_attempts: tries to find such a start.
    :param path_tolerance: largest deviation of a motion from its path's corners [rad or m].
    :param seed: a number >= 0 makes every request repeatable.
    :param fine_step: largest motion [m] of any point of the robot between two checks of a
        result.
    :param cartesian_limits: of the tool, for linear and circular motions.
    :param solver_groups: groups with a kinematics solver; none named: every chain has a solver.
    :param ik_timeouts: group -> [s] for inverse kinematics where a request gives none.
    """

    planners: PlannerTable = field(default_factory=PlannerTable)
    pipelines: tuple[str, ...] = ('ompl', 'pilz_industrial_motion_planner')
    default_pipeline: str = 'ompl'
    position_only_ik: frozenset[str] = frozenset()
    strict_start_state: bool = False
    start_state_max_bounds_error: float = 0.0
    request_adapters: frozenset[str] = frozenset()
    jiggle_fraction: float = 0.02
    max_sampling_attempts: int = 100
    path_tolerance: float = 0.1
    seed: int = -1
    fine_step: float = FINE_STEP
    cartesian_limits: CartesianLimits = field(default_factory=CartesianLimits)
    solver_groups: frozenset[str] = frozenset()
    ik_timeouts: Mapping[str, float] = field(default_factory=dict)


def settings_from_config(
    parameters: PlanningParameters, pipeline: OmplSettings,
    kinematics: Mapping[str, KinematicsSettings],
) -> PlanningSettings:
    """
    Return the settings that a user's files mean.

    :param parameters: of move_group.
    :param pipeline: of the default pipeline.
    :param kinematics: planning group -> its block of kinematics.yaml.
    """
    timeouts = {name: each.kinematics_solver_timeout for name, each in kinematics.items()}
    return PlanningSettings(
        planners=PlannerTable(_planner_configs(pipeline)),
        pipelines=parameters.planning_pipelines,
        default_pipeline=parameters.default_planning_pipeline,
        position_only_ik=frozenset(
            name for name, each in kinematics.items() if each.leaves_orientation_free),
        start_state_max_bounds_error=pipeline.start_state_max_bounds_error,
        strict_start_state=parameters.strict_start_state,
        cartesian_limits=parameters.cartesian_limits,
        request_adapters=frozenset(
            adapter.rpartition('/')[2] for adapter in pipeline.request_adapters or ()
        ),
        jiggle_fraction=pipeline.jiggle_fraction,
        max_sampling_attempts=pipeline.max_sampling_attempts,
        path_tolerance=pipeline.path_tolerance,
        seed=pipeline.planning_seed,
        solver_groups=frozenset(
            name for name, each in kinematics.items() if each.kinematics_solver),
        ik_timeouts=timeouts,
    )


def _planner_configs(pipeline: OmplSettings) -> dict[str, dict[str, Any]]:
    """Return the configurations ``group`` and ``group[config]`` of all groups with settings."""
    configs: dict[str, dict[str, Any]] = {}
    offered = pipeline.planner_configs
    for group, settings in pipeline.groups.items():
        names = {f'{group}[{name}]': name for name in settings.planner_configs if name in offered}
        shared = {'type': f'geometric::{DEFAULT_PLANNER}', **settings.shared_parameters}
        if not pipeline.simplify_solutions:
            shared['simplify_solutions'] = False
        configs[group] = shared
        if settings.default_planner_config in offered:
            names[group] = settings.default_planner_config
        for key, name in names.items():
            configs[key] = {**shared, 'type': offered[name].type, **offered[name].parameters}
    return configs
