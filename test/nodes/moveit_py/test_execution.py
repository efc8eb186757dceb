# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories of a script, and the manager that sends them."""

import threading

import pytest

from moveit.core.robot_state import RobotState


@pytest.fixture
def plan(moveit, arm):
    """Return a function that plans a turn of the first joint by an angle."""
    def make(angle):
        state = RobotState(moveit.get_robot_model())
        state.joint_positions = arm.get_start_state().joint_positions
        state.joint_positions = {'panda_joint1': angle}
        arm.set_goal_state(robot_state=state)
        response = arm.plan()
        assert response, response.error_code.message
        return response.trajectory

    return make


@pytest.mark.statement('B3')
def test_the_robot_goes_to_the_goal(moveit, plan, panda):
    """The controller that has the joints gets the trajectory; the next plan begins there."""
    status = moveit.execute(plan(0.4), controllers=[])
    assert status
    assert status.status == 'SUCCEEDED'
    assert panda.positions['panda_joint1'] == pytest.approx(0.4, abs=1e-3)
    assert moveit.execute(robot_trajectory=plan(0.0), controllers=['panda_arm_controller'])
    assert len(panda.goals) == 2


@pytest.mark.statement('B3')
def test_what_cannot_be_executed_is_aborted(moveit, plan):
    """Nothing to execute, an unknown controller, a start where the robot is not, no group."""
    assert moveit.execute(None, []).status == 'ABORTED'
    trajectory = plan(0.4)
    assert moveit.execute(trajectory, ['other_controller']).status == 'ABORTED'
    trajectory.joint_model_group_name = ''
    assert moveit.execute(trajectory, []).status == 'ABORTED'
    trajectory.joint_model_group_name = 'panda_arm'
    assert moveit.execute(trajectory.__reverse__(), []).status == 'ABORTED'


@pytest.mark.statement('B3')
def test_the_joints_of_the_group_are_sent(moveit, arm, plan, panda):
    """At once, whatever joints and stamp a message had (moveit_cpp.cpp: execute)."""
    trajectory = plan(0.2)
    message = trajectory.get_robot_trajectory_msg()
    message.joint_trajectory.header.stamp.sec = 1
    message.joint_trajectory.joint_names.append('panda_finger_joint1')
    for point in message.joint_trajectory.points:
        point.positions.append(0.04)
        point.velocities, point.accelerations = [], []
    trajectory.set_robot_trajectory_msg(arm.get_start_state(), message)
    assert moveit.execute(trajectory, [])
    sent, = panda.goals
    assert sorted(sent.joint_names) == [f'panda_joint{k}' for k in range(1, 8)]
    assert sent.header.stamp.sec == 0
    assert panda.positions['panda_finger_joint1'] == 0.0


@pytest.mark.statement('B8')
def test_trajectories_in_a_row(moveit, plan, panda):
    """Each is pushed first; callbacks get the number of each, and the status at the end."""
    manager = moveit.get_trajectory_execution_manager()
    assert manager is moveit.get_trajectory_execution_manager()
    there = plan(0.3).get_robot_trajectory_msg()
    assert manager.push(there, 'panda_arm_controller')
    assert manager.push(there.joint_trajectory, controllers=[])
    assert not manager.push(there, 'other_controller')
    parts, ended, statuses = [], threading.Event(), []

    def done(status):
        statuses.append(status.status)
        ended.set()

    manager.execute(done, parts.append, auto_clear=False)
    assert ended.wait(10.0)
    # The robot jumps to the end, where the second trajectory does not begin.
    assert (parts, statuses) == ([0], ['ABORTED'])
    assert manager.get_last_execution_status().status == 'ABORTED'
    manager.clear()
    assert manager.execute_and_wait().status == 'ABORTED'  # nothing is left
    assert len(panda.goals) == 1
    assert manager.push(plan(0.0).get_robot_trajectory_msg())
    assert manager.execute_and_wait().status == 'SUCCEEDED'


@pytest.mark.statement('B8')
def test_nothing_pushed_is_not_a_success(moveit, plan, panda):
    """
    A refused trajectory is ABORTED, also when the execution of it is asked for.

    trajectory_execution_manager.cpp: push, execute; nothing calls back.
    """
    manager = moveit.get_trajectory_execution_manager()
    message = plan(0.4).get_robot_trajectory_msg()
    assert not manager.push(message, 'other_controller')
    assert manager.get_last_execution_status().status == 'ABORTED'
    called = []
    manager.execute(called.append)
    assert manager.execute_and_wait().status == 'ABORTED'
    assert (called, panda.goals) == ([], [])


@pytest.mark.statement('B8')
def test_a_callback_that_fails_ends_the_execution(moveit, plan, panda):
    """The rest is not executed, and what waits for the end gets it: ABORTED."""
    manager = moveit.get_trajectory_execution_manager()
    message = plan(panda.positions['panda_joint1'] + 0.1).get_robot_trajectory_msg()
    assert manager.push(message)
    assert manager.push(message)
    statuses, ended = [], threading.Event()

    def done(status):
        statuses.append(status.status)
        ended.set()

    manager.execute(done, lambda part: 1 / part)
    assert ended.wait(10.0)
    assert statuses == ['ABORTED']
    assert manager.wait_for_execution().status == 'ABORTED'
    assert len(panda.goals) == 1


@pytest.mark.statement('B8')
def test_a_stop_at_rest_drops_nothing(moveit, plan, panda):
    """What was pushed is executed later (trajectory_execution_manager.cpp: stopExecution)."""
    manager = moveit.get_trajectory_execution_manager()
    assert manager.push(
        plan(panda.positions['panda_joint1'] + 0.1).get_robot_trajectory_msg())
    manager.stop_execution()
    manager.process_event('stop')
    assert manager.execute_and_wait()
    assert len(panda.goals) == 1


@pytest.mark.statement('B8')
def test_an_execution_is_stopped(moveit, plan, panda):
    """The controller's goal is cancelled, and the status says so."""
    manager = moveit.get_trajectory_execution_manager()
    panda.hangs = True
    assert manager.push(plan(0.4).get_robot_trajectory_msg())
    ended = threading.Event()
    manager.execute(lambda status: ended.set(), False)
    assert manager.get_last_execution_status().status == 'RUNNING'
    while not panda.goals:
        assert not ended.wait(0.01)
    manager.process_event('stop')
    assert panda.cancelled.wait(5.0)
    assert ended.wait(5.0)
    assert manager.wait_for_execution().status == 'PREEMPTED'


@pytest.mark.statement('A6', 'B8')
def test_another_thread_stops_an_execution(moveit, plan, panda):
    """While execute waits, other threads run; stop_execution returns when it has ended."""
    manager = moveit.get_trajectory_execution_manager()
    trajectory, waiting, found = plan(0.4), threading.Event(), []
    panda.hangs = True

    def stop():
        while not panda.goals:
            waiting.wait(0.01)
        manager.stop_execution()
        found.append(manager.get_last_execution_status().status)

    thread = threading.Thread(target=stop)
    thread.start()
    assert moveit.execute(trajectory, []).status == 'PREEMPTED'
    thread.join(10.0)
    assert found == ['PREEMPTED']


@pytest.mark.statement('B8')
def test_controllers(moveit):
    """Those of the configuration are active; others are not known."""
    manager = moveit.get_trajectory_execution_manager()
    assert manager.is_controller_active('panda_arm_controller')
    assert not manager.are_controllers_active(['panda_arm_controller', 'other'])
    assert manager.ensure_active_controllers_for_group('panda_arm')
    assert manager.ensure_active_controllers_for_joints(['panda_joint1'])
    group = moveit.get_robot_model().get_joint_model_group('panda_arm')
    assert manager.ensure_active_controllers_for_joints(
        [*group.joint_model_names, 'panda_finger_joint2', 'other'])
    assert manager.ensure_active_controller('panda_arm_controller')
    assert not manager.ensure_active_controllers(['other'])


@pytest.mark.statement('B8')
def test_settings(moveit):
    """They have the values of the configuration, can be set, and are checked."""
    manager = moveit.get_trajectory_execution_manager()
    assert manager.is_managing_controllers() is False
    assert manager.execution_duration_monitoring() is True
    manager.enable_execution_duration_monitoring(flag=False)
    assert manager.execution_duration_monitoring() is False
    manager.enable_execution_duration_monitoring(True)
    for name, value in (('allowed_execution_duration_scaling', 2.0),
                        ('allowed_goal_duration_margin', 1.0), ('allowed_start_tolerance', 0.02),
                        ('execution_velocity_scaling', 1.0)):
        before = getattr(manager, name)()
        getattr(manager, f'set_{name}')(value)
        assert getattr(manager, name)() == value
        getattr(manager, f'set_{name}')(before)
    assert manager.wait_for_trajectory_completion()
    manager.set_wait_for_trajectory_completion(True)
    with pytest.raises(ValueError, match='allowed_start_tolerance'):
        manager.set_allowed_start_tolerance(-1.0)
