# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Names of the planning request and response adapters of each pipeline."""

from __future__ import annotations

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ

#: The adapters of MoveIt's own configuration, which count where the user lists none.
REQUEST_ADAPTERS = (
    'ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
    'CheckStartStateCollision',
)
RESPONSE_ADAPTERS = ('AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath')
PILZ_RESPONSE_ADAPTERS = RESPONSE_ADAPTERS[1:]


def request_adapters(settings: OmplSettings, pipeline: str) -> tuple[str, ...]:
    """Return what a request passes before the planner, without the packages' names."""
    listed = None if pipeline == PILZ else settings.request_adapters
    return REQUEST_ADAPTERS if listed is None else tuple(map(_short, listed))


def response_adapters(settings: OmplSettings, pipeline: str) -> tuple[str, ...]:
    """Return what a plan passes after the planner, without the packages' names."""
    if pipeline == PILZ:
        return PILZ_RESPONSE_ADAPTERS
    listed = settings.response_adapters
    return RESPONSE_ADAPTERS if listed is None else tuple(map(_short, listed))


def _short(adapter: str) -> str:
    return adapter.rpartition('/')[2]
