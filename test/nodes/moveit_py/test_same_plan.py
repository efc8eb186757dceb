# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A plan of a script is that of move_group."""

from contextlib import ExitStack
import threading

from moveit_msgs.srv import GetMotionPlan
import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.moveit_py.description import described_cell, node_arguments
from armsim_ros.nodes.move_group.program import MoveGroup, MoveGroupProgram
from armsim_ros.nodes.polling_node import PollingNode
from moveit.core.robot_state import RobotState
from moveit.planning import PlanRequestParameters

pytestmark = pytest.mark.statement('A3')


@pytest.fixture
def move_group(panda, parameters):
    """Run the endpoints of move_group with the parameters of the script."""
    cell, _ = described_cell(node_arguments('move_group', '', [], parameters, None))
    context, ending = Context(), threading.Event()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    executor = SingleThreadedExecutor(context=context)
    node = PollingNode('move_group', context=context, **MoveGroupProgram.NODE_OPTIONS)
    executor.add_node(node)
    with ExitStack() as stack:
        made = MoveGroup(node, executor, cell)
        stack.callback(made.close)

        def spin():
            while not ending.is_set():
                try:
                    callback, *_ = executor.wait_for_ready_callbacks(None, None, ending.is_set)
                except rclpy.executors.ConditionReachedException:
                    return
                made.catch_up()
                callback()

        thread = threading.Thread(target=spin, daemon=True)
        thread.start()
        yield made
        ending.set()
        executor.create_task(lambda: None)
        thread.join(5.0)
        executor.shutdown(0.0)
        node.destroy_node()
        context.try_shutdown()


def test_the_same_request_and_seed_give_the_same_bytes(moveit, arm, move_group):
    """The trajectory that /plan_kinematic_path returns is that of plan()."""
    state = RobotState(moveit.get_robot_model())
    state.set_to_default_values('panda_arm', 'ready')
    arm.set_start_state(robot_state=state)
    state.joint_positions = {'panda_joint1': 1.2, 'panda_joint2': 0.3, 'panda_joint4': -1.5}
    arm.set_goal_state(robot_state=state)
    request = arm._request(PlanRequestParameters(moveit, ''), None)
    with RosClient('asks') as client:
        answer = client.call
        client.prepare(GetMotionPlan, '/plan_kinematic_path')
        waiting = threading.Event()
        while not client.serves(GetMotionPlan, '/plan_kinematic_path'):
            waiting.wait(0.01)
        answer = client.call(
            GetMotionPlan, '/plan_kinematic_path',
            GetMotionPlan.Request(motion_plan_request=request)).result(20.0)
    theirs = answer.motion_plan_response
    ours = arm.plan()
    assert theirs.error_code.val == ours.error_code.val == 1
    # Serialized, even a message and itself differ: nothing clears what fills up an alignment.
    assert theirs.trajectory == ours.trajectory.get_robot_trajectory_msg()
    assert theirs.trajectory_start == ours.start_state
