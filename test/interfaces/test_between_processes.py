# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Messages, services and actions cross from one process to another and back."""

from pathlib import Path
import subprocess
import sys

from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.srv import SwitchController
from filled import filled, interface
import pytest
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from type_description_interfaces.srv import GetTypeDescription

from armsim_ros.clients.client_node import ClientNode

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

# One message of each package, those that hold the most.
MESSAGES = (
    'control_msgs/msg/JointTrajectoryControllerState',
    'controller_manager_msgs/msg/ControllerManagerActivity',
    'moveit_msgs/msg/MotionPlanRequest',
    'moveit_task_constructor_msgs/msg/Solution',
    'object_recognition_msgs/msg/RecognizedObjectArray',
    'octomap_msgs/msg/OctomapWithPose',
    'simulation_interfaces/msg/EntityFilters',
    'tf2_msgs/msg/TFMessage',
)


@pytest.fixture(scope='module')
def peer():
    """Run the echoing process."""
    program = Path(__file__).with_name('echo_peer.py')
    process = subprocess.Popen([sys.executable, program, *MESSAGES], start_new_session=True)
    yield process
    process.terminate()
    try:
        process.wait(5)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise


@pytest.fixture
def client(ros_domain_id):
    """Give a client that copes with the responses that Fast DDS drops."""
    with ClientNode(ros_domain_id, 'interfaces_client') as client:
        yield client


@pytest.mark.parametrize('name', MESSAGES)
@pytest.mark.usefixtures('peer')
def test_message(node, wait_until, name):
    """A message with a value in every field arrives unchanged, there and back."""
    package = name.split('/')[0]
    received = []
    node.create_subscription(interface(name), f'/back/{package}', received.append, LATCHED)
    sent = filled(interface(name))
    node.create_publisher(interface(name), f'/there/{package}', LATCHED).publish(sent)
    wait_until(lambda: received, f'{name} comes back')
    assert received == [sent]


@pytest.mark.usefixtures('peer')
def test_service(client):
    """A request arrives, its response too."""
    request = SwitchController.Request(
        activate_controllers=['arm'], strictness=SwitchController.Request.STRICT)
    response = client.call('/switch', SwitchController, request)
    assert response.ok
    assert response.message == 'arm 2'


@pytest.mark.usefixtures('peer')
def test_action(node, wait_until):
    """A goal arrives; feedback and result come back."""
    client = ActionClient(node, FollowJointTrajectory, '/follow')
    wait_until(client.server_is_ready, '/follow is offered')
    goal = filled(FollowJointTrajectory.Goal)
    seen = []
    future = client.send_goal_async(goal, feedback_callback=seen.append)
    wait_until(future.done, 'the goal is answered')
    assert future.result().accepted
    wait_until(lambda: seen, 'feedback')
    result = future.result().get_result_async()
    wait_until(result.done, 'the result')
    assert result.result().result.error_string == 'done'
    assert seen[0].feedback.joint_names == goal.trajectory.joint_names
    assert seen[0].feedback.desired == goal.trajectory.points[-1]
    client.destroy()


@pytest.mark.usefixtures('peer')
def test_type_hash_in_the_graph(node, wait_until, type_hashes):
    """The middleware tells others the hash of a topic's type."""
    wait_until(lambda: node.get_publishers_info_by_topic('/back/moveit_msgs'), 'the publisher')
    info = node.get_publishers_info_by_topic('/back/moveit_msgs')[0]
    assert str(info.topic_type_hash) == type_hashes['moveit_msgs/msg/MotionPlanRequest']


@pytest.mark.usefixtures('peer')
def test_type_description_service(client, type_hashes):
    """A node describes the types that it uses, with the text of their definitions."""
    name = 'moveit_msgs/msg/MotionPlanRequest'
    response = client.call(
        '/echo_peer/get_type_description', GetTypeDescription, GetTypeDescription.Request(
            type_name=name, type_hash=type_hashes[name], include_type_sources=True))
    assert response.successful, response.failure_reason
    assert response.type_description.type_description.type_name == name
    text = next(
        origin.raw_file_contents for origin in response.type_sources if origin.type_name == name)
    assert 'max_velocity_scaling_factor' in text
