# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The planning pipelines that there are without any file, as moveit_configs_utils has them."""

from __future__ import annotations

from typing import Any

OMPL, PILZ = 'ompl', 'pilz_industrial_motion_planner'
OMPL_PLUGIN, PILZ_PLUGIN = 'ompl_interface/OMPLPlanner', f'{PILZ}/CommandPlanner'

REQUEST_ADAPTERS = tuple(f'default_planning_request_adapters/{name}' for name in (
    'ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
    'CheckStartStateCollision'))
RESPONSE_ADAPTERS = tuple(f'default_planning_response_adapters/{name}' for name in (
    'AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath'))
#: Its plans have times already.
PILZ_RESPONSE_ADAPTERS = RESPONSE_ADAPTERS[1:]

#: OMPL's planners that the usual templates configure.
_PLANNERS = (
    'SBL', 'EST', 'LBKPIECE', 'BKPIECE', 'KPIECE', 'RRT', 'RRTConnect', 'RRTstar', 'TRRT', 'PRM',
    'PRMstar', 'FMT', 'BFMT', 'PDST', 'STRIDE', 'BiTRRT', 'LBTRRT', 'BiEST', 'ProjEST', 'LazyPRM',
    'LazyPRMstar', 'SPARS', 'SPARStwo')

#: Their names, in the order of their offer.
DEFAULT_PIPELINES = (OMPL, PILZ, 'chomp', 'stomp')

_PLUGINS = {OMPL: OMPL_PLUGIN, PILZ: PILZ_PLUGIN, 'chomp': 'chomp_interface/CHOMPPlanner',
            'stomp': 'stomp_moveit/StompPlanner'}


def planner_configs() -> dict[str, dict[str, str]]:
    """Return the planner configurations that OMPL's pipeline has without a file."""
    return {'APSConfigDefault': {'type': 'geometric::AnytimePathShortening'},
            **{f'{planner}kConfigDefault': {'type': f'geometric::{planner}'}
               for planner in _PLANNERS}}


def default_pipeline(name: str) -> dict[str, Any]:
    """Return the parameters of a pipeline without a file; empty for an unknown pipeline."""
    if name not in _PLUGINS:
        return {}
    common = {'planning_plugins': [_PLUGINS[name]], 'request_adapters': list(REQUEST_ADAPTERS)}
    if name != PILZ:
        return {**common, 'response_adapters': list(RESPONSE_ADAPTERS)}
    return {**common, 'response_adapters': list(PILZ_RESPONSE_ADAPTERS),
            'default_planner_config': 'PTP',
            'capabilities': f'{PILZ}/MoveGroupSequenceAction {PILZ}/MoveGroupSequenceService'}
