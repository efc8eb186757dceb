# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of plans and motions when the program ends."""

import signal
import time

from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.action import MoveGroup as MoveAction
from moveit_msgs.msg import (
    Constraints,
    JointConstraint,
    MotionPlanRequest,
    RobotState,
    RobotTrajectory,
)
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from armsim_ros.clients.action_client import PatientActionClient
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import trajectory_message
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.conversions.motion_plan_request import request_from_message
from armsim_ros.nodes.move_group.program import MoveGroup, MoveGroupProgram
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.testing.program import private_domain, start_program


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


@pytest.mark.parametrize(('kind', 'name'), [
    (MoveAction, '/move_action'), (ExecuteTrajectory, '/execute_trajectory')])
def test_who_waits_for_the_first_joint_state_is_answered_at_the_end(kind, name):
    """No simulation runs, so the goal waits for a state until the program ends."""
    joints = [f'joint_{number}' for number in range(1, 7)]
    goal = kind.Goal()
    if kind is MoveAction:
        goal.request.group_name, goal.planning_options.plan_only = 'manipulator', True
        goal.request.start_state = RobotState(is_diff=True)
        goal.request.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(joint_name=joint, weight=1.0) for joint in joints])]
    else:
        goal.trajectory = RobotTrajectory(
            joint_trajectory=trajectory_message(joints, [(0.0, [0.0] * 6), (1.0, [0.1] * 6)]))
    with (
        private_domain() as domain, ClientNode(domain, 'client') as client,
        start_program('move_group', domain) as program,
    ):
        actions = PatientActionClient(client.node, kind, name)
        assert actions.wait_for_server(30.0)
        handle = client.result(actions.send_goal_async(goal), 10.0, 'answer to the goal')
        pending = handle.get_result_async()
        program.signal(signal.SIGTERM)
        answer = client.result(pending, 10.0, 'result')
        assert answer.result.error_code.message == 'move_group is shutting down'
        assert program.wait() == 0
