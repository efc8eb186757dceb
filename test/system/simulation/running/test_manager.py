# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller manager and the controllers' parameters through the real program."""

from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.msg import ControllerManagerActivity
import pytest

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import (
    BEST_EFFORT,
    ControllerManagerClient,
    ParameterClient,
)
from armsim_ros.clients.trajectory import ABORTED, SUCCEEDED, trajectory_message, TrajectoryClient
from armsim_ros.testing.program import Program

MANAGER = '/sunday/controller_manager'
ARM = 'arm_joint_controller'
BROADCASTER = 'joint_state_controller'
JOINTS = [f'joint_{i}' for i in range(1, 7)]
COMMANDS = [f'{name}/position' for name in JOINTS]


@pytest.fixture(scope='module')
def manager(simulation: Program, client: ClientNode) -> ControllerManagerClient:
    """Give a client of the manager."""
    return ControllerManagerClient(client, MANAGER)


@pytest.fixture(scope='module')
def arm(simulation: Program, client: ClientNode) -> TrajectoryClient:
    """Give a client of the arm's controller."""
    return TrajectoryClient(client, f'/sunday/{ARM}')


@pytest.fixture(scope='module')
def parameters(simulation: Program, client: ClientNode) -> ParameterClient:
    """Give a client of the controller's parameters."""
    return ParameterClient(client, f'/sunday/{ARM}')


def test_list_controllers(manager: ControllerManagerClient) -> None:
    """P1: both controllers of the files are active, with ROS 2 types and their claims."""
    controllers = manager.controllers()
    assert set(controllers) == {ARM, BROADCASTER}
    assert controllers[ARM].state == controllers[BROADCASTER].state == 'active'
    assert controllers[ARM].type == 'joint_trajectory_controller/JointTrajectoryController'
    assert controllers[BROADCASTER].type == 'joint_state_broadcaster/JointStateBroadcaster'
    assert sorted(controllers[ARM].claimed_interfaces) == COMMANDS
    assert sorted(controllers[ARM].required_command_interfaces) == COMMANDS
    assert list(controllers[BROADCASTER].claimed_interfaces) == []


def test_list_controller_types(manager: ControllerManagerClient) -> None:
    """P1: types and base classes have the same length."""
    response = manager.controller_types()
    assert 'joint_trajectory_controller/JointTrajectoryController' in response.types
    assert len(response.types) == len(response.base_classes)


def test_list_hardware(manager: ControllerManagerClient) -> None:
    """P1: each joint has its interfaces; the claimed ones are marked."""
    response = manager.hardware_interfaces()
    claimed = sorted(one.name for one in response.command_interfaces if one.is_claimed)
    assert claimed == COMMANDS
    assert {f'{name}/velocity' for name in JOINTS} <= {
        one.name for one in response.state_interfaces
    }
    (component,) = manager.hardware_components().component
    assert component.state.label == 'active'
    assert component.command_interfaces


def test_deactivation_while_moving_aborts(
    manager: ControllerManagerClient, arm: TrajectoryClient
) -> None:
    """C7, P6: the goal is ABORTED with INVALID_GOAL, goals are rejected, then all works again."""
    goal = arm.send(trajectory_message(JOINTS, [(3.0, [0.3] * 6)]))
    goal.wait_for_feedback()
    switched = manager.switch(deactivate=[ARM])
    assert switched.ok, switched.message
    outcome = goal.result()
    assert outcome.status == ABORTED
    assert outcome.error_code == FollowJointTrajectory.Result.INVALID_GOAL
    assert 'deactivat' in outcome.error_string
    assert manager.states()[ARM] == 'inactive'
    assert list(manager.controllers()[ARM].claimed_interfaces) == []
    assert not arm.send(trajectory_message(JOINTS, [(0.3, [0.1] * 6)])).accepted()
    assert manager.switch(activate=[ARM]).ok
    assert arm.send(trajectory_message(JOINTS, [(0.3, [0.1] * 6)])).result().status == SUCCEEDED


def test_strict_switches_nothing_where_one_name_is_wrong(
    manager: ControllerManagerClient,
) -> None:
    """P3: STRICT refuses as a whole and says why; BEST_EFFORT does what it can."""
    refused = manager.switch(deactivate=[ARM, 'nobody'])
    assert not refused.ok
    assert 'nobody' in refused.message
    assert manager.states()[ARM] == 'active'
    assert manager.switch(deactivate=[ARM, 'nobody'], strictness=BEST_EFFORT).ok
    assert manager.states()[ARM] == 'inactive'
    assert manager.switch(activate=[ARM]).ok


def test_life_of_a_controller(
    manager: ControllerManagerClient, arm: TrajectoryClient, client: ClientNode
) -> None:
    """P1: deactivate, cleanup, unload, load, configure, activate; its node comes and goes."""
    assert manager.switch(deactivate=[ARM]).ok
    assert manager.cleanup(ARM)
    assert manager.states()[ARM] == 'unconfigured'
    assert manager.unload(ARM)
    assert ARM not in manager.states()
    assert not manager.unload(ARM)
    assert manager.load(ARM)
    assert not manager.load(ARM)
    assert not manager.load('nobody')
    assert manager.configure(ARM)
    assert manager.states()[ARM] == 'inactive'
    assert manager.switch(activate=[ARM]).ok
    assert not manager.unload(ARM)
    assert arm.send(trajectory_message(JOINTS, [(0.3, [0.0] * 6)])).result().status == SUCCEEDED
    assert ParameterClient(client, f'/sunday/{ARM}').get('joints') == JOINTS


def test_activity_follows_the_states(
    manager: ControllerManagerClient, client: ClientNode
) -> None:
    """P9: a latched message at every change of a state."""
    activity = client.collect(f'{MANAGER}/activity', ControllerManagerActivity, 10)
    assert manager.switch(deactivate=[ARM]).ok
    activity.wait_for(lambda message: states_of(message)[ARM] == 'inactive')
    assert manager.switch(activate=[ARM]).ok
    latched = client.latched(f'{MANAGER}/activity', ControllerManagerActivity)
    activity.wait_for(lambda message: states_of(message)[ARM] == 'active')
    assert states_of(latched)[BROADCASTER] == 'active'


def states_of(message: ControllerManagerActivity) -> dict[str, str]:
    """Return controller -> state."""
    return {one.name: one.state.label for one in message.controllers}


def test_parameters_are_those_of_the_reference(parameters: ParameterClient) -> None:
    """A6, B: parameters are reached on the controller's node, with values from the files."""
    assert parameters.get('joints') == JOINTS
    assert parameters.get('command_interfaces') == ['position']
    assert parameters.get('constraints.goal_time') == 0.0
    assert parameters.get('constraints.stopped_velocity_tolerance') == 0.01
    assert parameters.get('gains.joint_1.p') == 1000.0
    assert parameters.get('action_monitor_rate') == 20.0
    assert parameters.describe('joints').read_only
    assert parameters.describe('constraints.goal_time').description


def test_there_are_no_lifecycle_services(client: ClientNode, arm: TrajectoryClient) -> None:
    """A6: states are changed through the manager alone."""
    arm.wait_for_server()
    services = dict(client.node.get_service_names_and_types())
    assert f'/sunday/{ARM}/get_parameters' in services
    assert f'/sunday/{ARM}/change_state' not in services


def test_a_tolerance_set_by_parameter_holds_for_the_next_goal(
    parameters: ParameterClient, arm: TrajectoryClient
) -> None:
    """B23: constraints are dynamic; illegal values are refused with a reason."""
    assert parameters.set('constraints.joint_1.trajectory', 1e-9) == ''
    outcome = arm.send(trajectory_message(JOINTS, [(0.5, [0.4] * 6)])).result()
    assert outcome.status == ABORTED
    assert outcome.error_code == FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED
    assert 'joint_1' in outcome.error_string
    assert parameters.set('constraints.joint_1.trajectory', 0.0) == ''
    assert arm.send(trajectory_message(JOINTS, [(0.5, [0.0] * 6)])).result().status == SUCCEEDED
    assert parameters.set('constraints.goal_time', -1.0) != ''
    assert parameters.set('joints', ['joint_1']) != ''


def test_no_joint_can_be_made_to_fail_unless_asked_for(
    simulation: Program, client: ClientNode
) -> None:
    """U4: without fault_injection in simulation.yaml there are no parameters for it."""
    names = ParameterClient(client, MANAGER).names()
    assert 'update_rate' in names
    assert not [name for name in names if name.startswith('faults')]
