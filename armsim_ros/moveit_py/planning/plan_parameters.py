# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of a plan, from the parameters of the node."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TYPE_CHECKING

from armsim_ros.moveit_py.log import warn_once, warn_unused

if TYPE_CHECKING:
    from armsim_ros.moveit_py.planning.moveit_py import MoveItPy

#: Name -> default of each parameter.
_DEFAULTS: dict[str, Any] = {
    'planner_id': '', 'planning_pipeline': '', 'planning_time': 1.0, 'planning_attempts': 5,
    'max_velocity_scaling_factor': 1.0, 'max_acceleration_scaling_factor': 1.0,
}


class PlanRequestParameters:
    """
    How to plan; each parameter can be set.

    A name that is not used, or a namespace without any, is logged once.

    :param moveit_py: its node has the parameters.
    :param ns: they are those of ``<ns>.plan_request_params``; '' for ``plan_request_params``.
    :raises ValueError: a parameter has a value of another type.
    """

    planner_id: str
    planning_pipeline: str
    planning_time: float
    planning_attempts: int
    max_velocity_scaling_factor: float
    max_acceleration_scaling_factor: float

    def __init__(self, moveit_py: MoveItPy, ns: str = '') -> None:
        given = moveit_py._cpp.parameters
        prefix = f'{ns}.plan_request_params.' if ns else 'plan_request_params.'
        warn_unused(given, prefix, _DEFAULTS)
        if not any(key.startswith(prefix) for key in given):
            warn_once(f'no parameter {prefix}*; plans with the defaults')
        for name, default in _DEFAULTS.items():
            key = prefix + name
            value = given.get(key, default)
            kind = type(default)
            if not isinstance(value, (int, float) if kind is float else kind):
                raise ValueError(f"parameter '{key}' is {value!r}; allowed: {kind.__name__}")
            setattr(self, name, kind(value))


class MultiPipelinePlanRequestParameters:
    """
    How to plan with several pipelines.

    :param moveit_py: its node has the parameters.
    :param planning_pipeline_names: a namespace of ``PlanRequestParameters`` each.
    """

    def __init__(self, moveit_py: MoveItPy, planning_pipeline_names: Sequence[str]) -> None:
        self._all = [PlanRequestParameters(moveit_py, name) for name in planning_pipeline_names]

    @property
    def multi_plan_request_parameters(self) -> list[PlanRequestParameters]:
        """The parameters for each pipeline."""
        return self._all
