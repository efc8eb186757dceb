# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of move_group that clients read."""

import pytest
import rclpy
from rclpy.context import Context
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.move_group.parameters import declare_fixed, planning_parameters
from armsim_ros.nodes.move_group.program import MoveGroupProgram
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.testing.program import private_domain


@pytest.fixture
def parameters():
    """Return what gives the parameters of a node that has some from its command line."""
    context, nodes, cell = Context(), [], load_cell('sunday')

    def declared(**given):
        node = PollingNode(
            'move_group', context=context, **MoveGroupProgram.NODE_OPTIONS, parameter_overrides=[
                Parameter(name, value=value) for name, value in given.items()])
        nodes.append(node)
        planning = planning_parameters(node, cell.settings)
        declare_fixed(node, cell.settings, planning, cell.model)
        return lambda name: node.get_parameter(name).value

    with private_domain() as domain:
        rclpy.init(context=context, domain_id=domain,
                   signal_handler_options=SignalHandlerOptions.NO)
        yield declared
        for node in nodes:
            node.destroy_node()
        context.try_shutdown()


@pytest.mark.parametrize(('given', 'default'), [
    ({}, 'ompl'), ({'default_planning_pipeline': 'stomp'}, 'ompl'),
    ({'default_planning_pipeline': 'pilz_industrial_motion_planner'},
     'pilz_industrial_motion_planner'),
    ({'planning_pipelines': ['pilz_industrial_motion_planner', 'ompl']},
     'pilz_industrial_motion_planner'),
    ({'planning_pipelines': ['pilz_industrial_motion_planner'],
      'default_planning_pipeline': 'ompl'}, 'pilz_industrial_motion_planner'),
])
def test_the_default_pipeline_is_one_that_can_be_named(parameters, given, default):
    """
    MoveGroupInterface and RViz read the parameter, so it is rewritten where it was not valid.

    Upstream: move_group.cpp, main.
    """
    assert parameters(**given)('default_planning_pipeline') == default
