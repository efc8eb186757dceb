# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Forward controllers of a running arm, seen through ROS alone."""

from __future__ import annotations

from controller_manager_msgs.srv import ConfigureController, ListControllers, ListControllerTypes
import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from std_msgs.msg import Float64MultiArray
from streaming_bench import ARM, beside, JOINTS, MANAGER, NAMESPACE, Streamed

statement = pytest.mark.statement

TYPES = {
    'forward_command_controller/ForwardCommandController',
    'forward_command_controller/MultiInterfaceForwardCommandController',
    'position_controllers/JointGroupPositionController',
    'velocity_controllers/JointGroupVelocityController',
    'effort_controllers/JointGroupEffortController',
}


@statement('FWD-1')
def test_types(arm: Streamed) -> None:
    """The types can be loaded."""
    answer = arm.client.call(f'{MANAGER}/list_controller_types', ListControllerTypes)
    assert set(answer.types) >= TYPES


@statement('FWD-2')
def test_claims_and_topic(arm: Streamed) -> None:
    """Each claims joint/interface in the order of its joints, and listens on ~/commands."""
    arm.use('velocity_stream')
    answer = arm.client.call(f'{MANAGER}/list_controllers', ListControllers)
    (state,) = [one for one in answer.controller if one.name == 'velocity_stream']
    assert list(state.claimed_interfaces) == [f'{joint}/velocity' for joint in JOINTS]
    (topic,) = arm.client.node.get_subscriptions_info_by_topic('/sunday/velocity_stream/commands')
    assert topic.topic_type == 'std_msgs/msg/Float64MultiArray'


@pytest.mark.parametrize('joints', [JOINTS[2:3], JOINTS[:2]])
def test_other_joints_from_configure_on(arm: Streamed, joints: tuple[str, ...]) -> None:
    """The parameter can be set; configure takes it over (forward_command_controller.cpp)."""
    name = 'named_stream'
    request = SetParameters.Request(
        parameters=[Parameter('joints', value=list(joints)).to_parameter_msg()])
    (result,) = arm.client.call(
        f'{NAMESPACE}/{name}/set_parameters', SetParameters, request).results
    assert result.successful, result.reason
    required = [f'{joint}/position' for joint in joints]
    assert required_of(arm, name) != required
    assert arm.client.call(f'{MANAGER}/configure_controller', ConfigureController,
                           ConfigureController.Request(name=name)).ok
    assert required_of(arm, name) == required


def required_of(arm: Streamed, name: str) -> list[str]:
    """Return the command interfaces that a controller needs."""
    answer = arm.client.call(f'{MANAGER}/list_controllers', ListControllers)
    (state,) = [one for one in answer.controller if one.name == name]
    return list(state.required_command_interfaces)


@statement('FWD-4', 'FWD-9')
@pytest.mark.parametrize('name', ['position_stream', 'velocity_stream', 'effort_stream'])
def test_switch_holds(arm: Streamed, name: str) -> None:
    """The arm stays where it is over a switch there and back."""
    before = arm.positions
    arm.use(name)
    arm.rest(0.5)
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)
    arm.use(ARM)
    arm.rest(0.5)
    np.testing.assert_allclose(arm.positions, before, atol=2e-3)


@statement('FWD-7', 'C20')
def test_a_far_position_is_reached_by_the_drive(arm: Streamed) -> None:
    """The command goes to the drive as it is, which moves no faster than it can."""
    arm.use('position_stream')
    arm.forget()
    goal = beside(1.0, 0.5)
    arm.stream(arm.streams['position_stream'], Float64MultiArray(data=goal.tolist()), 0.2)
    arm.until(lambda: np.abs(arm.positions - goal).max() < 2e-3, 'the command is reached')
    track, stamps = arm.moved(arm.measured), np.array(arm.measured.stamps)
    speed = np.abs(np.diff(track, axis=0)) / np.diff(stamps)[: len(track) - 1, None]
    assert speed.max() < 3.14 * 1.5  # the drive has headroom, and the joint swings in at first


@statement('X3', 'C21')
def test_a_velocity_stands_until_the_next_command(arm: Streamed) -> None:
    """Silence ends no motion (forward_controllers_base.cpp, update); a velocity of 0 does."""
    arm.use('velocity_stream')
    command = Float64MultiArray(data=[0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
    arm.stream_until(arm.streams['velocity_stream'], command,
                     lambda: arm.positions[0] > 0.05, 'the arm moves')
    arm.until(lambda: arm.positions[0] > 0.3, 'the arm goes on in silence')
    arm.stream(arm.streams['velocity_stream'], Float64MultiArray(data=[0.0] * 6), 0.1)
    arm.rest()
    assert arm.positions[0] < 0.5


@statement('FWD-6')
@pytest.mark.parametrize('data', [[float('nan')] * 6, [0.1] * 5, [], [float('inf')] + [0.0] * 5])
def test_garbage(arm: Streamed, data: list[float]) -> None:
    """Garbage moves nothing, is told of once, and the controller goes on."""
    arm.use('position_stream')
    before, marker = arm.positions, len(arm.program.text)
    arm.stream(arm.streams['position_stream'], Float64MultiArray(data=data), 0.2)
    arm.rest(0.3)
    np.testing.assert_allclose(arm.positions, before, atol=1e-3)
    assert arm.program.text[marker:].count('command dropped') <= 1
    goal = beside(0.1)
    arm.stream(arm.streams['position_stream'], Float64MultiArray(data=goal.tolist()), 0.1)
    arm.until(lambda: abs(arm.positions[0] - 0.1) < 2e-3, 'the next command is followed')
