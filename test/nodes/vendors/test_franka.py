# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Endpoints of franka_ros2, started by a launch file like its own.

``gripper_action_server.cpp``, ``franka_param_service_server.cpp``, ``franka_action_server.cpp``
and ``franka_robot_state_broadcaster.cpp`` are what is re-enacted.
"""

from pathlib import Path

from control_msgs.action import GripperCommand
from controller_manager_msgs.srv import ListControllers, SwitchController
from franka_msgs.action import ErrorRecovery, Grasp, Homing, Move
from franka_msgs.msg import FrankaRobotState, GraspEpsilon
from franka_msgs.srv import SetLoad, SetTCPFrame
from geometry_msgs.msg import PoseStamped
import numpy as np
import pytest
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python
from sensor_msgs.msg import JointState
from simulation_interfaces.srv import DeleteEntity, SpawnEntity
from std_srvs.srv import SetBool, Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED
from armsim_ros.testing.program import private_domain, Program, ros_environment

HERE = Path(__file__).parent
HAND, STATE = '/franka_gripper', '/franka_robot_state_broadcaster'
ARM = 'joint_trajectory_controller'


class Arm(ClientNode):
    """A client of the arm."""

    def run(self, kind, name, **goal):
        """Send a goal; return status and result."""
        run = self.goal(kind, name, kind.Goal(**goal))
        assert self.result(run.accepted)
        found = self.result(run.result, 60.0)
        return found.status, found.result

    def press(self, button, pressed):
        """Press or release a button of the simulation."""
        assert self.call(f'/{button}', SetBool, SetBool.Request(data=pressed)).success

    def recover(self):
        """Recover; return the status of the goal."""
        return self.run(ErrorRecovery, '/action_server/error_recovery')[0]

    def switch(self, **controllers):
        """Activate and deactivate controllers."""
        request = SwitchController.Request(strictness=2, **controllers)
        assert self.call('/controller_manager/switch_controller', SwitchController, request).ok


@pytest.fixture(scope='module')
def arm():
    """Start the launch file; return a client."""
    with private_domain() as domain:
        launch = Program.module(
            'armsim_ros', 'launch', str(HERE / 'franka.launch.py'), 'robot_ip:=172.16.0.3',
            environment=ros_environment(domain))
        try:
            with Arm(domain, 'client') as arm:
                states = {}
                while states.get(ARM) != 'active':
                    answer = arm.call('/controller_manager/list_controllers', ListControllers,
                                      timeout=90.0)
                    states = {entry.name: entry.state for entry in answer.controller}
                yield arm
        finally:
            launch.stop(15.0)  # it gives its programs 5 s until SIGTERM, and 5 s until SIGKILL


def test_the_hand_homes_moves_and_grasps(arm):
    """HW-D1: A grasp succeeds exactly where the fingers rest within the epsilon of the width."""
    assert arm.run(Homing, f'{HAND}/homing')[1].success
    states = arm.collect(f'{HAND}/joint_states', JointState, 1)
    message = states.wait_for(lambda message: abs(message.position[0] - 0.04) < 5e-4)
    assert list(message.name) == ['left_finger', 'right_finger']
    assert message.position[0] == message.position[1]
    assert arm.run(Move, f'{HAND}/move', width=0.03, speed=0.1)[1].success
    states.wait_for(lambda message: abs(message.position[0] - 0.015) < 5e-4)
    states.close()
    for width, outer, success in ((0.04, 0.005, False), (0.0, 0.08, True)):
        status, result = arm.run(Grasp, f'{HAND}/grasp', width=width, speed=0.1, force=20.0,
                                 epsilon=GraspEpsilon(inner=0.005, outer=outer))
        assert (status, result.success, result.error) == (
            SUCCEEDED if success else ABORTED, success, '')
    status, result = arm.run(Move, f'{HAND}/move', width=0.09, speed=0.1)
    assert (status, result.success) == (ABORTED, False)
    assert '0.09 m is not allowed' in result.error


def test_the_hand_has_the_parameters_of_the_launch_file(arm):
    """Its own speed and rate, and what is not given as upstream (gripper_action_server.cpp)."""
    names = ['robot_ip', 'default_speed', 'default_grasp_epsilon.inner', 'state_publish_rate',
             'feedback_publish_rate']
    answer = arm.call(f'{HAND}/get_parameters', GetParameters, GetParameters.Request(names=names))
    assert [parameter_value_to_python(value) for value in answer.values] == [
        '172.16.0.3', 0.02, 0.005, 30, 20]


def test_a_cube_between_the_fingers_is_grasped(arm):
    """HW-D1: At its width, not at another; the fingers then are where the cube is."""
    assert arm.run(Move, f'{HAND}/move', width=0.08, speed=0.1)[1].success
    poses = arm.collect(f'{STATE}/current_pose', PoseStamped, 1)
    tool = poses.wait_for(lambda _: True)
    poses.close()
    # The base of the arm is at the origin of the world.
    tool.header.frame_id = 'world'
    height = tool.pose.position.z
    for name, size, below in (('post', '0.02,0.02,0.04', 0.04),
                              ('cube', '0.04,0.04,0.04&mass=0.1', 0.0)):
        tool.pose.position.z = height - below
        spawned = arm.call('/spawn_entity', SpawnEntity, SpawnEntity.Request(
            name=name, uri=f'armsim://box?size={size}', initial_pose=tool))
        assert spawned.result.result == 1, spawned.result.error_message
    states = arm.collect(f'{HAND}/joint_states', JointState, 1)
    for width, success in ((0.04, True), (0.02, False)):
        status, result = arm.run(Grasp, f'{HAND}/grasp', width=width, speed=0.1, force=20.0,
                                 epsilon=GraspEpsilon(inner=0.005, outer=0.005))
        assert (status, result.success) == (SUCCEEDED if success else ABORTED, success)
        states.wait_for(lambda message: abs(message.position[0] - 0.02) < 5e-4)
    states.close()
    assert arm.run(Move, f'{HAND}/move', width=0.08, speed=0.1)[1].success
    for name in ('cube', 'post'):
        deleted = arm.call('/delete_entity', DeleteEntity, DeleteEntity.Request(entity=name))
        assert deleted.result.result == 1


def test_gripper_action_takes_half_the_width(arm):
    """HW-D1: It opens and grasps; its result has the width, as upstream's."""
    assert arm.run(Move, f'{HAND}/move', width=0.02, speed=0.1)[1].success
    for position in (0.03, 0.03, 0.02):
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, 10.0
        run = arm.goal(GripperCommand, f'{HAND}/gripper_action', goal)
        found = arm.result(run.result, 60.0)
        # Nothing is between the fingers, so that to close is a grasp of nothing.
        assert found.result.reached_goal == (position == 0.03)
        if position == 0.03:
            assert found.result.position == pytest.approx(0.06, abs=1e-3)
    assert arm.call(f'{HAND}/stop', Trigger).success


def test_another_goal_stops_the_first(arm):
    """HW-D1: It is accepted at once, and the first is aborted with the reason."""
    assert arm.run(Move, f'{HAND}/move', width=0.08, speed=0.1)[1].success
    first = arm.goal(Move, f'{HAND}/move', Move.Goal(width=0.0, speed=0.001))
    assert arm.result(first.accepted)
    assert arm.run(Homing, f'{HAND}/homing')[1].success
    found = arm.result(first.result)
    assert (found.status, found.result.error) == (ABORTED, 'another command replaced it')


def test_a_stop_is_a_mode_and_an_error_of_the_state(arm):
    """
    A reflex until the recovery, and a button that the recovery does not release.

    HW-D2, HW-D3.
    """
    states = arm.collect(f'{STATE}/robot_state', FrankaRobotState, 1)
    message = states.wait_for(lambda message: message.robot_mode == 1)
    assert len(message.measured_joint_state.position) == 7
    assert max(map(abs, message.tau_ext_hat_filtered.effort)) < 0.1
    arm.press('protective_stop', True)
    states.wait_for(lambda message: message.robot_mode == 4 and (
        message.current_errors.joint_reflex))
    assert arm.recover() == SUCCEEDED
    states.wait_for(lambda message: message.robot_mode == 1 and (
        not message.current_errors.joint_reflex and message.last_motion_errors.joint_reflex))
    arm.press('emergency_stop', True)
    states.wait_for(lambda message: message.robot_mode == 5)
    assert arm.recover() == ABORTED
    arm.press('emergency_stop', False)
    assert arm.recover() == SUCCEEDED
    states.wait_for(lambda message: message.robot_mode == 1)
    states.close()


def test_parameters_are_set_while_no_controller_moves_the_arm(arm):
    """HW-D3: Until then they are refused; the frame of the tool is that of current_pose."""
    frame = np.eye(4)
    frame[2, 3] = 0.1
    request = SetTCPFrame.Request(transformation=frame.T.flatten())
    refused = arm.call('/service_server/set_tcp_frame', SetTCPFrame, request)
    assert not refused.success
    assert ARM in refused.error
    poses = arm.collect(f'{STATE}/current_pose', PoseStamped, 1)
    before = poses.wait_for(lambda _: True).pose.position.z
    arm.switch(deactivate_controllers=[ARM])
    assert arm.call('/service_server/set_tcp_frame', SetTCPFrame, request).success
    poses.wait_for(lambda message: abs(before - message.pose.position.z - 0.1) < 2e-3)
    poses.close()
    assert arm.call('/service_server/set_load', SetLoad, SetLoad.Request(mass=0.5)).success
    assert not arm.call('/service_server/set_load', SetLoad, SetLoad.Request(mass=-1.0)).success
    arm.switch(activate_controllers=[ARM])
