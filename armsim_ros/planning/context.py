# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What all parts of planning share: robot, collision model, settings, solvers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
import logging
from typing import Any

from armsim_ros.config.kinematics import KinematicsSettings
from armsim_ros.config.ompl_planning import (
    CartesianLimits,
    offered_pipelines,
    PipelineSettings,
    Planner,
    PlanningParameters,
)
from armsim_ros.config.pipeline_defaults import OMPL, PILZ
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.inverse import IKOptions, IKTarget, InverseKinematics
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.log import Log
from armsim_ros.planning.budget import nothing, Poll
from armsim_ros.planning.collision.collision_model import CollisionChecker
from armsim_ros.planning.collision.state_validity import FINE_STEP, StateValidity
from armsim_ros.planning.constraint_terms import Frame
from armsim_ros.planning.constraints import ConstraintSet
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import joined, StartState
from armsim_ros.planning.search.planners import DEFAULT_PLANNER, PlannerTable
from armsim_ros.planning.timing.limits import LimitTable

_LOGGER = 'armsim_ros.planning'


@dataclass(frozen=True, slots=True)
class PlanningPipeline:
    """
    A planner and its settings; what a user calls it decides nothing.

    :param planner: plans the requests.
    :param planners: the planner configurations.
    :param start_state_max_bounds_error: a start may be this far [rad or m] beyond a limit.
    :param request_adapters: names of the steps before planning that the user lists.
    :param jiggle_fraction: share of the joints' ranges by which a colliding start may be moved.
    :param max_sampling_attempts: tries to find such a start.
    :param path_tolerance: largest deviation of a motion from its path's corners [rad or m].
    """

    planner: Planner = Planner.OMPL
    planners: PlannerTable = field(default_factory=PlannerTable)
    start_state_max_bounds_error: float = 0.0
    request_adapters: frozenset[str] = frozenset()
    jiggle_fraction: float = 0.02
    max_sampling_attempts: int = 100
    path_tolerance: float = 0.1


def _default_pipelines() -> dict[str, PlanningPipeline]:
    return {OMPL: PlanningPipeline(), PILZ: PlanningPipeline(Planner.PILZ)}


@dataclass(frozen=True, slots=True)
class PlanningSettings:
    """
    Settings of the motion planner.

    :param pipelines: the planning pipelines by name.
    :param default_pipeline: used where a request names none.
    :param position_only_ik: groups whose inverse kinematics leaves orientations free.
    :param strict_start_state: a start state that is not a diff drops attached objects.
    :param seed: a number >= 0 makes every request repeatable.
    :param fine_step: largest motion [m] of any point of the robot between two checks of a
        result.
    :param cartesian_limits: of the tool, for linear and circular motions.
    :param solver_groups: groups with a kinematics solver; none named: every chain has a solver.
    :param ik_timeouts: group -> [s] for inverse kinematics where a request gives none.
    """

    pipelines: Mapping[str, PlanningPipeline] = field(default_factory=_default_pipelines)
    default_pipeline: str = OMPL
    position_only_ik: frozenset[str] = frozenset()
    strict_start_state: bool = False
    seed: int = -1
    fine_step: float = FINE_STEP
    cartesian_limits: CartesianLimits = field(default_factory=CartesianLimits)
    solver_groups: frozenset[str] = frozenset()
    ik_timeouts: Mapping[str, float] = field(default_factory=dict)

    def requested_pipeline(self, pipeline_id: str) -> PlanningPipeline:
        """
        Return the pipeline that a request names, '' for the default.

        :raises PlanningError: FAILURE where there is none of that name.
        """
        name = pipeline_id or self.default_pipeline
        if name not in self.pipelines:
            known = tuple(self.pipelines)
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f"planning pipeline '{name}' is not known; {nearest(name, known)} "
                f'known: {", ".join(known)}', 'planning pipeline')
        return self.pipelines[name]


def settings_from_config(
    parameters: PlanningParameters, pipelines: Mapping[str, PipelineSettings],
    kinematics: Mapping[str, KinematicsSettings], log: Log | None = None,
) -> PlanningSettings:
    """
    Return the settings that a user's files mean.

    :param parameters: of move_group.
    :param pipelines: planning pipeline -> its settings.
    :param kinematics: planning group -> its block of kinematics.yaml.
    :param log: hears of pipelines that are not available.
    """
    parameters = offered_pipelines(parameters, pipelines, log or logging.getLogger(_LOGGER))
    timeouts = {name: each.kinematics_solver_timeout for name, each in kinematics.items()}
    return PlanningSettings(
        pipelines={name: _pipeline(pipelines[name]) for name in parameters.planning_pipelines},
        default_pipeline=parameters.default_planning_pipeline,
        position_only_ik=frozenset(
            name for name, each in kinematics.items() if each.leaves_orientation_free),
        strict_start_state=parameters.strict_start_state,
        cartesian_limits=parameters.cartesian_limits,
        seed=_seed(parameters, pipelines),
        solver_groups=frozenset(
            name for name, each in kinematics.items() if each.kinematics_solver),
        ik_timeouts=timeouts)


def _seed(parameters: PlanningParameters, pipelines: Mapping[str, PipelineSettings]) -> int:
    """Return the seed of all pipelines: that of ``ompl``, which the argument ``seed`` sets."""
    seeds = (pipelines[name].planning_seed
             for name in (OMPL, *parameters.planning_pipelines) if name in pipelines)
    return next((seed for seed in seeds if seed >= 0), -1)


def _pipeline(settings: PipelineSettings) -> PlanningPipeline:
    assert settings.planner is not None
    return PlanningPipeline(
        settings.planner, PlannerTable(_planner_configs(settings)),
        start_state_max_bounds_error=settings.start_state_max_bounds_error,
        request_adapters=frozenset(
            adapter.rpartition('/')[2] for adapter in settings.request_adapters or ()),
        jiggle_fraction=settings.jiggle_fraction,
        max_sampling_attempts=settings.max_sampling_attempts,
        path_tolerance=settings.path_tolerance)


def _planner_configs(pipeline: PipelineSettings) -> dict[str, dict[str, Any]]:
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


class PlanningContext:
    """
    Everything that lives longer than a request; one thread at a time.

    :param scene: any scene of the robot; each request brings its own.
    :param settings: what the user set.
    :param log: hears warnings.
    """

    def __init__(
        self, scene: PlanningScene, settings: PlanningSettings | None = None,
        log: Log | None = None,
    ) -> None:
        self.model: KinematicModel = scene.kinematic_model
        self.settings = settings or PlanningSettings()
        self.log = log or logging.getLogger(_LOGGER)
        self.limits = LimitTable(self.model.robot, self.log)
        self.checker = CollisionChecker(scene)
        self._inverse: dict[str, InverseKinematics] = {}
        self._poll: Poll = nothing

    @contextmanager
    def polled(self, poll: Poll) -> Iterator[None]:
        """
        Have long checks of a request call a function now and then.

        :param poll: raises what ends the request.
        """
        self._poll = poll
        try:
            yield
        finally:
            self._poll = nothing

    def inverse(self, group: str) -> InverseKinematics:
        """Return the inverse kinematics of a group."""
        if group not in self._inverse:
            self._inverse[group] = InverseKinematics(
                self.model, group, position_only=group in self.settings.position_only_ik)
        return self._inverse[group]

    def prepare(self) -> None:
        """Make the start tables of inverse kinematics for the tip of every solver."""
        q = self.model.default()
        for group in self.model.robot.semantic.groups:
            tip = self.solver_tip(group)
            if tip is not None:
                self.inverse(group).solutions(
                    [IKTarget(tip, self.model.link_pose(q, tip))], q, IKOptions(max_starts=1))

    def started(self, scene: PlanningScene, start: StartState) -> PlanningScene:
        """
        Return a snapshot with a start state; what of it is refused is logged.

        :raises PlanningError: INVALID_ROBOT_STATE.
        """
        started = scene.with_start_state(start, strict=self.settings.strict_start_state)
        refusals = started.refusals[len(scene.refusals):]
        if refusals:
            self.log.warning(f'start state: {joined(refusals)}')
        return started

    def validity(
        self, scene: PlanningScene, group: str, on_path: ConstraintSet | None = None,
        avoid_collisions: bool = True,
    ) -> StateValidity:
        """Return the validity of a group's states in a scene; it holds until the next call."""
        self.checker.use(scene)
        return StateValidity(
            self.checker, self.model, group, scene.q, on_path, avoid_collisions, self._poll)

    def solver_tip(self, group: str) -> str | None:
        """
        Return the link that a group's kinematics solver positions, None where it has no solver.

        Only chains have solvers.
        """
        configured = self.settings.solver_groups
        if (configured and group not in configured) or not self.model.is_chain(group):
            return None
        return self.model.robot.semantic.groups[group].links[-1]

    def solver_target(self, scene: PlanningScene, group: str, link_name: str) -> Frame:
        """
        Return the frame that a group's kinematics solver is to position.

        :param link_name: '' for the solver's tip; a link, an attached object or a subframe that is
            rigidly fixed to it.
        :raises PlanningError: NO_IK_SOLUTION where the solver cannot position it.
        """
        tip = self.solver_tip(group)
        if tip is None:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"group '{group}' has no kinematics solver; only chains with a kinematics_solver "
                'in kinematics.yaml have a solver')
        found = scene.robot_frame(link_name or tip)
        if found is None:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"'{link_name}' is not a link, an attached object or its subframe "
                f'{nearest(link_name, tuple(self.model.robot.links))}'.rstrip())
        if self.model.link_joint(found[0])[0] != self.model.link_joint(tip)[0]:
            raise PlanningError(
                MoveItErrorCode.NO_IK_SOLUTION,
                f"'{link_name}' is not rigidly fixed to '{tip}', the tip of the kinematics solver "
                f"of group '{group}'")
        return Frame(*found)
