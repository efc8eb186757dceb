# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The numbers and names of a request, made usable or refused."""

from __future__ import annotations

from collections.abc import Sequence
import math

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.errors import MoveItErrorCode, nearest, PlanningError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.collision.state_validity import StateValidity
from armsim_ros.planning.log import Log
from armsim_ros.planning.request import MotionPlanRequest
from armsim_ros.planning.settings import PlanningSettings
from armsim_ros.planning.timing.limits import LimitTable, MotionLimits, scaling_factor
from armsim_ros.planning.timing.time_parameterization import SpeedLimit

_SOURCE = 'planning pipeline'
_DEFAULT_TIME = 1.0
LONGEST_PLANNING_TIME = 600.0
"""The most that a request gets [s]."""


class RequestChecks:
    """
    Rules for the parts of a request that are no constraints.

    :param model: the robot's kinematics.
    :param settings: what the user set.
    :param log: hears of values that were replaced.
    """

    def __init__(self, model: KinematicModel, settings: PlanningSettings, log: Log) -> None:
        self._model = model
        self._settings = settings
        self._log = log

    def group(self, name: str) -> str:
        """Return a group's name; INVALID_GROUP_NAME where it is unknown or cannot move."""
        if not len(self._model.group_indices(name)):
            raise PlanningError(
                MoveItErrorCode.INVALID_GROUP_NAME,
                f"planning group '{name}' has no joint that can be moved", _SOURCE,
            )
        return name

    def pipeline(self, request: MotionPlanRequest) -> None:
        """Refuse an unknown pipeline, and parts of a request that no planner here uses."""
        wanted = request.pipeline_id or self._settings.default_pipeline
        if wanted not in self._settings.pipelines:
            known = self._settings.pipelines
            raise PlanningError(
                MoveItErrorCode.FAILURE,
                f"planning pipeline '{wanted}' is not known; {nearest(wanted, known)} "
                f'known: {", ".join(known)}', _SOURCE,
            )
        if request.has_trajectory_constraints:
            raise PlanningError(
                MoveItErrorCode.PLANNING_FAILED,
                'trajectory_constraints are not supported; use path_constraints', _SOURCE,
            )

    def planning_time(self, request: MotionPlanRequest) -> float:
        """Return the time for the search [s]."""
        wanted = request.allowed_planning_time
        if LONGEST_PLANNING_TIME < wanted < math.inf:
            self._log.warning(
                f'allowed_planning_time is {wanted:g} s: using {LONGEST_PLANNING_TIME:g} s, as '
                'others wait meanwhile'
            )
            return LONGEST_PLANNING_TIME
        if 0.0 < wanted < math.inf:
            return wanted
        self._log.info(
            f'allowed_planning_time is {request.allowed_planning_time:g}: using {_DEFAULT_TIME} s'
        )
        return _DEFAULT_TIME

    def attempts(self, request: MotionPlanRequest) -> int:
        """Return how often to search."""
        if request.num_planning_attempts < 0:
            self._log.error(
                f'num_planning_attempts is {request.num_planning_attempts}: using 1'
            )
        return max(1, request.num_planning_attempts)

    def limits(
        self, table: LimitTable, joint_names: Sequence[str], request: MotionPlanRequest
    ) -> MotionLimits:
        """Return the joint limits times the request's scaling factors."""
        return table.limits(joint_names).scaled(
            scaling_factor(
                request.max_velocity_scaling_factor, 'max_velocity_scaling_factor', self._log
            ),
            scaling_factor(
                request.max_acceleration_scaling_factor, 'max_acceleration_scaling_factor',
                self._log,
            ),
        )

    def speed_limit(
        self, request: MotionPlanRequest, validity: StateValidity, group: str
    ) -> SpeedLimit | None:
        """Return the limit of a link's translation speed, None where none is asked for."""
        return link_speed_limit(
            self._model, validity, group, request.cartesian_speed_limited_link,
            request.max_cartesian_speed,
        )


def link_speed_limit(
    model: KinematicModel, validity: StateValidity, group: str, link: str, speed: float
) -> SpeedLimit | None:
    """
    Return the largest path speed at which a link's origin keeps a translation speed.

    :param link: '' for the group's last link.
    :param speed: [m/s]; not above 0 for no limit.
    :raises PlanningError: INVALID_LINK_NAME for an unknown link.
    """
    if not speed > 0.0:
        return None
    name = link or model.robot.semantic.groups[group].links[-1]
    model.frame_index(name)

    def limit(positions: Vector, slopes: Vector) -> Vector:
        rates = [
            float(np.linalg.norm(model.jacobian(validity.full(q), name, group)[:3] @ slope))
            for q, slope in zip(positions, slopes, strict=True)
        ]
        fastest: Vector = speed / np.maximum(np.array(rates), 1e-9)
        return fastest

    return limit
