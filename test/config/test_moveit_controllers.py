# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of the files that name move_group's controllers."""

import pytest

RIGHT = """
moveit_simple_controller_manager:
  controller_names: [sunday/arm_joint_controller, odd]
  sunday/arm_joint_controller:
    action_ns: follow_joint_trajectory
    type: FollowJointTrajectory
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
"""


@pytest.fixture
def moveit(files):
    """Return a function that replaces the controllers of move_group."""
    files.remove('controllers_gazebo.yaml')

    def write(text):
        files.write('moveit_controllers.yaml', text)
        names = [one.name for one in files.load().moveit_controllers]
        return names, '\n'.join(files.remarks())

    return write


@pytest.mark.parametrize(('block', 'message'), [
    ('', "lists 'odd'"),
    ('  odd: {type: GripperCommand, joints: [joint_6]}', "'odd' has no 'action_ns'"),
    ('  odd: {action_ns: gripper_cmd, joints: [joint_6]}', "'odd' has no 'type'"),
    ('  odd: {action_ns: gripper_cmd, type: GripperCommand}', "'odd' has no 'joints'"),
    ('  odd: {action_ns: x, type: GripperCommand, joints: []}', "'joints'"),
    ('  odd: {action_ns: x, type: Strange, joints: [joint_6]}', "'type' is the text 'Strange'"),
    ('  odd: {action_ns: x, type: GripperCommand, parallel: true, joints: [joint_6]}',
     "'parallel' needs two joints; there are 1"),
])
def test_a_faulty_entry_is_left_out(moveit, block, message):
    """
    A controller without block, type, joints or action_ns is skipped; the others work.

    Upstream: moveit_simple_controller_manager.cpp, initialize.
    """
    names, remarks = moveit(RIGHT + block)
    assert names == ['sunday/arm_joint_controller']
    assert message in remarks


def test_without_controller_names_there_are_none(moveit):
    """
    Blocks that controller_names does not list are no controllers.

    Upstream: moveit_simple_controller_manager.cpp, initialize.
    """
    listed = '  controller_names: [sunday/arm_joint_controller, odd]\n'
    names, remarks = moveit(RIGHT.replace(listed, ''))
    assert not names
    assert "no 'controller_names'" in remarks


def test_execution_parameters_that_files_do_not_set(files):
    """
    Two parameters have no effect in files: they count when they are set at run time.

    Upstream: trajectory_execution_manager.cpp, initialize.
    """
    files.write('trajectory_execution.yaml', (
        'trajectory_execution:\n  execution_velocity_scaling: 0.5\n'
        '  wait_for_trajectory_completion: false\n  allowed_start_tolerance: 0.03\n'))
    found = files.load().trajectory_execution
    assert (found.execution_velocity_scaling, found.wait_for_trajectory_completion) == (1.0, True)
    assert found.allowed_start_tolerance == 0.03
    assert '\n'.join(files.remarks()).count('set at run time') == 2


def test_a_manager_that_asks(files):
    """
    Ros2ControlManager has a namespace and a time limit for answers.

    Upstream: controller_manager_plugin.cpp, initialize.
    """
    files.write('manager.yaml', (
        'moveit_controller_manager: moveit_ros_control_interface/Ros2ControlManager\n'
        'ros_control_namespace: /left\ncontroller_service_call_timeout: 5.0\n'))
    found = files.load().trajectory_execution
    assert (found.ros_control_namespace, found.controller_service_call_timeout) == ('/left', 5.0)


JOINTS = '[joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]'


@pytest.mark.parametrize('text', [
    f"""
moveit_simple_controller_manager:
  controller_names: [sunday/arm.controller]
  sunday/arm.controller.action_ns: follow_joint_trajectory
  sunday/arm.controller.type: FollowJointTrajectory
  sunday/arm.controller: {{joints: {JOINTS}}}
trajectory_execution.allowed_start_tolerance: 0.07
""", f"""
moveit_simple_controller_manager.controller_names: [sunday/arm.controller]
moveit_simple_controller_manager.sunday/arm.controller.action_ns: follow_joint_trajectory
moveit_simple_controller_manager.sunday/arm.controller.type: FollowJointTrajectory
moveit_simple_controller_manager.sunday/arm.controller.joints: {JOINTS}
trajectory_execution:
  allowed_goal_duration_margin: 0.3
trajectory_execution.allowed_start_tolerance: 0.07
""", f"""
moveit_simple_controller_manager:
  controller_names: [sunday/arm.controller]
moveit_simple_controller_manager.sunday/arm.controller:
  action_ns: follow_joint_trajectory
  type: FollowJointTrajectory
  joints: {JOINTS}
trajectory_execution: {{allowed_start_tolerance: 0.07}}
"""])
def test_dotted_keys(files, text):
    """A dot in a key is a block in a block, as in the parameters that MoveIt gets."""
    files.remove('controllers_gazebo.yaml')
    files.remove('trajectory_execution.yaml')
    files.write('moveit_controllers.yaml', text)
    settings = files.load()
    [controller] = settings.moveit_controllers
    assert (controller.name, len(controller.joints)) == ('sunday/arm.controller', 6)
    assert controller.action_name == 'sunday/arm.controller/follow_joint_trajectory'
    assert settings.trajectory_execution.allowed_start_tolerance == 0.07
