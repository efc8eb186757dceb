# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the planning pipelines that a package has no file for."""

from __future__ import annotations

from typing import Any

_REQUEST_ADAPTERS = tuple(f'default_planning_request_adapters/{name}' for name in (
    'ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
    'CheckStartStateCollision'))
_RESPONSE_ADAPTERS = tuple(f'default_planning_response_adapters/{name}' for name in (
    'AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath'))

#: OMPL's planners that the usual templates configure.
_PLANNERS = (
    'SBL', 'EST', 'LBKPIECE', 'BKPIECE', 'KPIECE', 'RRT', 'RRTConnect', 'RRTstar', 'TRRT', 'PRM',
    'PRMstar', 'FMT', 'BFMT', 'PDST', 'STRIDE', 'BiTRRT', 'LBTRRT', 'BiEST', 'ProjEST', 'LazyPRM',
    'LazyPRMstar', 'SPARS', 'SPARStwo',
)

#: The pipelines that there are without any file, in the order of their offer.
DEFAULT_PIPELINES = ('ompl', 'pilz_industrial_motion_planner', 'chomp', 'stomp')


def planner_configs() -> dict[str, dict[str, str]]:
    """Return the planner configurations that OMPL's pipeline has without a file."""
    return {'APSConfigDefault': {'type': 'geometric::AnytimePathShortening'},
            **{f'{planner}kConfigDefault': {'type': f'geometric::{planner}'}
               for planner in _PLANNERS}}


def default_pipeline(name: str) -> dict[str, Any]:
    """Return the parameters of a pipeline without a file; empty for an unknown pipeline."""
    request, response = list(_REQUEST_ADAPTERS), list(_RESPONSE_ADAPTERS)
    if name == 'ompl':
        return {'planning_plugins': ['ompl_interface/OMPLPlanner'],
                'request_adapters': request, 'response_adapters': response}
    if name == 'pilz_industrial_motion_planner':
        return {'planning_plugins': ['pilz_industrial_motion_planner/CommandPlanner'],
                'default_planner_config': 'PTP', 'request_adapters': request,
                'response_adapters': response[1:],
                'capabilities': 'pilz_industrial_motion_planner/MoveGroupSequenceAction '
                                'pilz_industrial_motion_planner/MoveGroupSequenceService'}
    if name == 'chomp':
        return {'planning_plugins': ['chomp_interface/CHOMPPlanner'],
                'request_adapters': request, 'response_adapters': response}
    if name == 'stomp':
        return {'planning_plugins': ['stomp_moveit/StompPlanner'],
                'request_adapters': request, 'response_adapters': response}
    return {}
