# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of planners, as clients send them."""

from __future__ import annotations

from move_group_bench import ArmBench
from moveit_msgs.srv import SetPlannerParams


def set_planner(arm: ArmBench, planner: str, **settings: str) -> None:
    """Set parameters of a planner, for the group alone."""
    request = SetPlannerParams.Request(planner_config=planner, group=arm.group)
    request.params.keys, request.params.values = list(settings), list(settings.values())
    request.params.descriptions = [''] * len(settings)
    arm.client.call(arm.name('set_planner_params'), SetPlannerParams, request)
