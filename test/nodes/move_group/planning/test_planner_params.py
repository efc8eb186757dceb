# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of planners as texts."""

import asyncio
from types import SimpleNamespace

from moveit_msgs.srv import GetPlannerParams

from armsim_ros.nodes.move_group.planning.planner_services import PlannerParams
from armsim_ros.planning.context import PlanningPipeline
from armsim_ros.planning.search.planners import PlannerTable


def test_booleans_are_written_as_rclcpp_writes_them():
    """Upstream, ompl_interface.cpp, loadPlannerConfiguration stores value_to_string()."""
    table = PlannerTable({'arm[RRTConnect]': {'anytime': True, 'simplify_solutions': False,
                                              'range': 0.5}})
    services = {}
    PlannerParams(SimpleNamespace(
        planner=SimpleNamespace(settings=SimpleNamespace(
            default_pipeline='fast', pipelines={'fast': PlanningPipeline(planners=table)})),
        serve=lambda kind, name, fill: services.update({name: fill})))
    response = GetPlannerParams.Response()
    asyncio.run(services['get_planner_params'](
        GetPlannerParams.Request(planner_config='RRTConnect', group='arm'), response))
    assert dict(zip(response.params.keys, response.params.values, strict=True)) == {
        'anytime': 'true', 'simplify_solutions': 'false', 'range': '0.5'}
