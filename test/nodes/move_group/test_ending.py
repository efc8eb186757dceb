# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a plan when the program ends."""

import time

from moveit_msgs.msg import Constraints, JointConstraint, MotionPlanRequest
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.conversions.motion_plan_request import request_from_message
from armsim_ros.nodes.move_group.program import MoveGroup, MoveGroupProgram
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.testing.program import private_domain


@pytest.fixture
def move_group():
    """Make the endpoints; nobody runs their callbacks."""
    context = Context()
    with private_domain() as domain:
        rclpy.init(context=context, domain_id=domain,
                   signal_handler_options=SignalHandlerOptions.NO)
        node = PollingNode('move_group', context=context, **MoveGroupProgram.NODE_OPTIONS)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        made = MoveGroup(node, executor, load_cell('sunday'))
        yield made
        made.close()
        executor.shutdown(0.0)
        node.destroy_node()
        context.try_shutdown()


def test_a_plan_is_given_up_while_the_executor_is_busy(move_group):
    """Otherwise a plan keeps the interpreter from what is to tell the clients."""
    context = move_group._context
    goal = Constraints(joint_constraints=[
        JointConstraint(joint_name=f'joint_{number}', position=0.2, weight=1.0)
        for number in range(1, 7)])
    request = request_from_message(MotionPlanRequest(
        group_name='manipulator', planner_id='RRTstar', goal_constraints=[goal],
        allowed_planning_time=120.0, num_planning_attempts=1,
        max_velocity_scaling_factor=1.0, max_acceleration_scaling_factor=1.0))
    asked = []

    def cancelled():
        if not asked:
            move_group.give_up()
        asked.append(1)
        return False

    found = context.planner.plan(
        request, context.scene.snapshot(), clock=time.monotonic,
        cancelled=context.or_ending(cancelled))
    assert not found.success
    assert asked
