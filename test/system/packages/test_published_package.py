# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A small MoveIt package, written as packages are published, from the command line to motion."""

from control_msgs.msg import DynamicJointState
from controller_manager_msgs.srv import (
    ConfigureController,
    ListControllers,
    ListHardwareComponents,
    LoadController,
    SwitchController,
)
import pytest
from std_msgs.msg import Float64, Float64MultiArray

from armsim_ros.clients.motion import SUCCESS
from armsim_ros.clients.trajectory import SUCCEEDED
from armsim_ros.testing.robot_user import running_robot

GPIO = ('<gpio name="speed"><command_interface name="target"/><state_interface name="target"/>'
        '</gpio>')
MORE = (
    'speed_controller:\n  ros__parameters:\n'
    '    {type: forward_command_controller/ForwardCommandController, joints: [speed],\n'
    '     interface_name: target}\n'
    'speed_broadcaster:\n  ros__parameters: {type: vendor/SpeedScalingStateBroadcaster}\n'
    'freedrive:\n  ros__parameters: {type: vendor/FreedriveController}\n')
LATER = ['speed_broadcaster', 'speed_controller']


@pytest.fixture
def robot(small_package):
    """Run the package with an argument of its xacro."""
    state = '<state_interface name="{0}">{1}</state_interface>'
    initial = '<param name="initial_value">$(arg bend)</param>'
    small_package.ros2_control(*(
        f'<joint name="{name}"><command_interface name="position"/>'
        f'{state.format("position", initial)}{state.format("velocity", "")}</joint>'
        for name in ('shoulder', 'elbow', 'grip')), GPIO)
    urdf = small_package.folder / 'config/small.urdf.xacro'
    urdf.write_text(urdf.read_text().replace(
        '<xacro:include', '<xacro:arg name="bend" default="0"/><xacro:include', 1))
    slower = small_package.ROS2.replace('rate: 500', 'rate: 100')
    small_package.write('config/ros2_controllers.yaml', slower + MORE)
    with running_robot(f'robot:={small_package.folder}', 'bend:=0.25') as user:
        yield user


def test_a_published_package_runs(robot):
    """It starts where its xacro says, moves, plans; vendors' controllers do what they can."""
    start = robot.positions()
    assert start == pytest.approx({'shoulder': 0.25, 'elbow': 0.25, 'grip': 0.25}, abs=1e-3)
    call, manager = robot.client.call, '/controller_manager'
    listed = call(f'{manager}/list_controllers', ListControllers).controller
    assert {one.name: one.state for one in listed} == {
        'arm_controller': 'active', 'joint_state_broadcaster': 'active'}
    (component,) = call(f'{manager}/list_hardware_components', ListHardwareComponents).component
    assert (component.name, component.plugin_name) == ('Arm', 'vendor/Hardware')
    outcome = robot.send('arm_controller', ['shoulder', 'elbow'], [(1.0, [0.1, 0.1])])
    assert outcome.status == SUCCEEDED
    bent = robot.move_group.named_states()['arm', 'bent']
    assert robot.move_group.move('arm', bent).error_code.val == SUCCESS
    assert robot.distance(bent) < 0.01
    loaded = [call(f'{manager}/load_controller', LoadController,
                   LoadController.Request(name=name)).ok
              for name in ('freedrive', *LATER)]
    assert loaded == [False, True, True]
    for name in LATER:
        assert call(f'{manager}/configure_controller', ConfigureController,
                    ConfigureController.Request(name=name)).ok
    speeds = robot.client.collect('/speed_broadcaster/speed_scaling', Float64)
    assert call(f'{manager}/switch_controller', SwitchController, SwitchController.Request(
        activate_controllers=LATER, strictness=2)).ok
    assert {message.data for message in speeds.wait(3)} == {100.0}
    states = robot.client.collect('/dynamic_joint_states', DynamicJointState)
    commands = robot.client.node.create_publisher(
        Float64MultiArray, '/speed_controller/commands', 10)

    def commanded(message):
        # Subscriptions of the system's default profile are best effort: again until it is taken.
        commands.publish(Float64MultiArray(data=[0.5]))
        place = message.joint_names.index('speed')
        return message.interface_values[place].values[0] == 0.5

    states.wait_for(commanded)
