# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The start of move_group, its parameters, its capabilities, and its robot state monitor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import math
from pathlib import Path
import shutil
import time

from lone_server import LoneServer, PlayedArm
from move_group_bench import name_of
import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from wire import robot_state

from armsim_ros.resources import find_robot

START = {f'joint_{k}': 0.1 * k for k in range(1, 7)}
URDF = f"urdf:={find_robot('sunday').parent.parent / 'urdf' / 'sunday.urdf.xacro'}"
NAMESPACE = '/kitchen'
#: The bare server never hears of the others.
FIRST = {name: START[name] for name in list(START)[:4]}
GOAL = {name: value + 0.1 for name, value in START.items()}


@dataclass(frozen=True)
class Servers:
    """
    Servers with configurations of their own; those that lack something come up later.

    :param usual: it has parameters and capabilities.
    :param bare: it has no controllers.
    :param mistaken: its SRDF has mistakes, its controller manager is not ours, it has a namespace.
    """

    usual: LoneServer
    bare: LoneServer
    mistaken: LoneServer


@pytest.fixture(scope='module')
def servers(
    pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Servers]:
    """Start the servers."""
    command = pytestconfig.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs a server of its own with parameters of its own')
    bare = robot_without(tmp_path_factory, 'controllers_gazebo.yaml', 'kinematics.yaml')
    mistaken = robot_without(tmp_path_factory)
    srdf = mistaken / 'sunday.srdf'
    text = srdf.read_text(encoding='utf-8').replace('<robot name="sunday">',
                                                    '<robot name="monday">')
    srdf.write_text(text.replace('</robot>', '<disable_collisions link1="no_link" '
                                 'link2="link_1" reason="Never"/></robot>'), encoding='utf-8')
    (mistaken / 'manager.yaml').write_text(
        'moveit_controller_manager: moveit_ros_control_interface/Ros2ControlManager\n',
        encoding='utf-8',
    )
    with LoneServer(
        '--ros-args',
        '-p', 'disable_capabilities:=move_group/MoveGroupKinematicsService move_group/Nonsense',
        '-p', 'capabilities:=pilz_industrial_motion_planner/Unheard',
        '-p', 'trajectory_execution/allowed_start_tolerance:=0.02',
        '-p', 'publish_monitored_planning_scene:=false',
        '-p', 'robot_description_planning.cartesian_limits.max_trans_vel:=0.25',
        '-p', 'monitor_dynamics:=true',
        '-p', "joint_state_topics:=['/elsewhere/joint_states', '/joint_states']",
        '--',
    ) as usual, LoneServer(
        f'robot:={bare}', URDF, wait=False
    ) as second, LoneServer(
        f'robot:={mistaken}', URDF, wait=False, namespace=NAMESPACE
    ) as third:
        yield Servers(usual, second, third)


def robot_without(tmp_path_factory: pytest.TempPathFactory, *names: str) -> Path:
    """Return a folder of the default arm without some files."""
    folder = Path(tmp_path_factory.mktemp('robots')) / 'bare'
    shutil.copytree(find_robot('sunday'), folder)
    for name in names:
        (folder / name).unlink()
    return folder


@pytest.fixture
def started(servers: Servers) -> LoneServer:
    """Give the server with parameters and capabilities."""
    return servers.usual


@pytest.fixture
def bare(servers: Servers) -> LoneServer:
    """Give the server without controllers."""
    servers.bare.wait_until_ready()
    return servers.bare


@pytest.fixture
def mistaken(servers: Servers) -> LoneServer:
    """Give the server with mistakes, in a namespace."""
    servers.mistaken.wait_until_ready()
    return servers.mistaken


@pytest.fixture
def played(started: LoneServer) -> Iterator[PlayedArm]:
    """Publish joint states for one test."""
    player = started.play(START, '/elsewhere/joint_states')
    player.arm.joint_states.clear()
    player.arm.joint_states.wait(3)
    yield player
    player.silence()


@pytest.mark.statement('ACT-2', 'BOOT-3')
def test_no_state_ever(started: LoneServer) -> None:
    """
    move_group starts without joint states; a plan is -23 and names the topic.

    Must run first: later tests publish joint states to the same server.
    """
    silent = started.play({}, '/nowhere/joint_states')
    silent.silence()
    code = silent.arm.refused(GOAL)
    assert name_of(code) == 'ROBOT_STATE_STALE'
    assert '/elsewhere/joint_states' in code.message
    answer = silent.arm.plan(GOAL, start_state=robot_state(START, is_diff=False))
    assert name_of(answer.error_code) == 'SUCCESS'


@pytest.mark.statement('CAP-2', 'CAP-1')
def test_capabilities(started: LoneServer, played: PlayedArm) -> None:
    """A disabled one is absent, the others are there; unknown names are errors in the log."""
    names = {name for name, _ in started.client.node.get_service_names_and_types()}
    assert '/plan_kinematic_path' in names
    assert not names & {'/compute_ik', '/compute_fk'}
    for text in ('move_group/Nonsense', 'pilz_industrial_motion_planner/Unheard'):
        started.program.wait_for_line(f"capability '{text}' is not known")


@pytest.mark.statement('SEED-8', 'IF-30', 'CSM-1')
def test_the_topic_of_joint_states_is_a_parameter(played: PlayedArm) -> None:
    """Joint states come from the topic that was named."""
    state = played.arm.scene().robot_state.joint_state
    found = dict(zip(state.name, state.position, strict=True))
    assert {name: found[name] for name in START} == pytest.approx(START)


@pytest.mark.statement('PAR-7', 'CSM-5')
def test_monitor_dynamics(played: PlayedArm) -> None:
    """Velocities of the joint states are told where the parameter is set, else not."""
    played.velocities = {'joint_2': 0.25}
    played.arm.joint_states.clear()
    played.arm.joint_states.wait(3)
    state = played.arm.scene().robot_state.joint_state
    assert dict(zip(state.name, state.velocity, strict=True))['joint_2'] == 0.25
    assert played.arm.parameters.set('monitor_dynamics', False) == ''
    assert not played.arm.scene().robot_state.joint_state.velocity
    assert played.arm.parameters.set('monitor_dynamics', True) == ''


@pytest.mark.statement('SEED-5', 'SEED-6', 'PAR-7', 'IF-40a')
def test_values_from_the_command_line(played: PlayedArm) -> None:
    """ROS 1's slashes and its one switch for the published scene are understood."""
    get = played.arm.parameters.get
    assert get('trajectory_execution.allowed_start_tolerance') == 0.02
    assert get('publish_planning_scene') is False
    assert get('publish_state_updates') is False
    assert get('robot_description_planning.cartesian_limits.max_trans_vel') == 0.25


@pytest.mark.statement('PAR-5')
def test_a_wrong_value_is_refused(played: PlayedArm) -> None:
    """A live parameter keeps its value, and the answer says what is allowed."""
    name = 'trajectory_execution.allowed_start_tolerance'
    assert 'greater than or equal to 0' in played.arm.execution_parameters.set(name, -1.0) or (
        played.arm.execution_parameters.get(name) == 0.02
    )
    assert played.arm.execution_parameters.get(name) == 0.02


@pytest.mark.statement('PAR-1', 'PAR-2', 'PAR-3', 'PAR-4', 'PAR-6', 'PAR-7')
@pytest.mark.parametrize('name', [
    'robot_description', 'robot_description_semantic',
    'robot_description_kinematics.manipulator.kinematics_solver',
    'robot_description_kinematics.manipulator.kinematics_solver_timeout',
    'robot_description_planning.joint_limits.joint_1.max_velocity',
    'robot_description_planning.default_velocity_scaling_factor',
    'robot_description_planning.default_acceleration_scaling_factor',
    'robot_description_planning.default_robot_padding',
    'robot_description_planning.default_robot_scale',
    'robot_description_planning.default_object_padding',
    'robot_description_planning.default_attached_padding',
    'robot_description_planning.shape_transform_cache_lookup_wait_time',
    'planning_pipelines', 'default_planning_pipeline', 'ompl.planning_plugins',
    'ompl.progress_topic', 'ompl.fix_start_state', 'ompl.default_workspace_bounds',
    'ompl.totg.path_tolerance', 'ompl.totg.resample_dt', 'ompl.totg.min_angle_change',
    'ompl.display_path_topic', 'ompl.display_contacts_topic', 'ompl.request_adapters',
    'ompl.response_adapters',
    'ompl.planner_configs.RRTConnect.type', 'ompl.manipulator.default_planner_config',
    'allow_trajectory_execution', 'moveit_manage_controllers', 'moveit_controller_manager',
    'trajectory_execution.execution_duration_monitoring',
    'trajectory_execution.allowed_execution_duration_scaling',
    'trajectory_execution.allowed_goal_duration_margin',
    'trajectory_execution.wait_for_trajectory_completion',
    'trajectory_execution.execution_velocity_scaling',
    'trajectory_execution.control_multi_dof_joint_variables',
    'plan_execution.record_trajectory_state_frequency', 'monitor_dynamics',
    'publish_planning_scene', 'publish_geometry_updates', 'publish_state_updates',
    'publish_transforms_updates', 'publish_planning_scene_hz',
    'planning_scene_monitor_options.robot_description', 'capabilities', 'use_sim_time',
])
def test_parameters_are_declared(started: LoneServer, played: PlayedArm, name: str) -> None:
    """The parameter exists and has a value."""
    assert played.arm.parameters.get(name) is not None


@pytest.mark.statement('R25')
def test_parameters_of_pilz(started: LoneServer, played: PlayedArm) -> None:
    """
    The command planner's pipeline has its own plugin and adapters, which add no times.

    Upstream: moveit_configs_utils, pilz_industrial_motion_planner_planning.yaml.
    """
    pilz = 'pilz_industrial_motion_planner'
    assert played.arm.parameters.get(f'{pilz}.planning_plugins') == [f'{pilz}/CommandPlanner']
    assert played.arm.parameters.get(f'{pilz}.response_adapters') == [
        f'default_planning_response_adapters/{name}'
        for name in ('ValidateSolution', 'DisplayMotionPath')]


# ---------------------------------------------------------------- the state monitor


@pytest.mark.statement('CSM-3')
def test_messages_that_are_none(started: LoneServer, played: PlayedArm) -> None:
    """Extra joints are ignored, lengths that differ and NaN dropped; partial ones merge."""
    played.positions['finger_of_somebody'] = 1.0
    publisher = started.client.node.create_publisher(JointState, '/joint_states', 10)
    publisher.publish(JointState(name=['joint_1'], position=[]))
    played.positions['joint_1'] = math.nan
    played.arm.joint_states.clear()
    played.arm.joint_states.wait(3)
    state = played.arm.scene().robot_state.joint_state
    found = dict(zip(state.name, state.position, strict=True))
    assert found['joint_1'] == pytest.approx(START['joint_1'])
    assert 'finger_of_somebody' not in found


@pytest.mark.statement('CSM-1', 'CSM-3')
def test_partial_messages_merge(started: LoneServer, played: PlayedArm) -> None:
    """Half of the joints on one topic, half on the other."""
    played.positions = {'joint_1': 0.5}
    other = started.play({'joint_6': -0.5}, '/joint_states')
    played.arm.joint_states.clear()
    played.arm.joint_states.wait(10)
    state = played.arm.scene().robot_state.joint_state
    other.silence()
    found = dict(zip(state.name, state.position, strict=True))
    assert (found['joint_1'], found['joint_6']) == pytest.approx((0.5, -0.5))


@pytest.mark.statement('CSM-2')
def test_missing_joints_are_named(bare: LoneServer) -> None:
    """Incomplete states: a warning with the missing joints, and plans all the same."""
    played = bare.play(FIRST)
    played.arm.joint_states.wait(1)
    assert name_of(played.arm.plan(GOAL).error_code) == 'SUCCESS'
    bare.program.wait_for_line('incomplete.*joint_5, joint_6')
    played.silence()


@pytest.mark.statement('CSM-6', 'IF-30a', 'MGI-8')
def test_unstamped_and_best_effort(started: LoneServer) -> None:
    """Best-effort messages without stamp count with the time of their arrival."""
    played = started.play(START, '/joint_states', stamped=False, qos=qos_profile_sensor_data)
    started.program.wait_for_line('have no stamp')
    before = len(started.program.output)
    for _ in range(2):
        assert played.arm.planned(GOAL).points
    assert 'no joint state newer' not in ''.join(started.program.output[before:])
    played.silence()


@pytest.mark.statement('PAR-8')
def test_clocks_that_differ_are_told(started: LoneServer, played: PlayedArm) -> None:
    """Stamps more than 10 s away: one warning that names the cure."""
    played.shift = -100.0
    assert played.arm.planned(GOAL).points
    started.program.wait_for_line('use_sim_time')
    assert started.program.text.count('set use_sim_time on both') == 1


# ---------------------------------------------------------------- robots that lack something


@pytest.mark.statement('SEED-9', 'BOOT-4')
def test_what_lacks_is_told_at_the_start(bare: LoneServer) -> None:
    """Without controllers: the log says which joints lack one, and the YAML to add."""
    for text in ("'manipulator' can be planned for but not moved", 'type: FollowJointTrajectory',
                 'joints: \\[joint_1, joint_2'):
        bare.program.wait_for_line(text)
    played = bare.play(FIRST)
    assert played.arm.planned(GOAL).points
    played.silence()


@pytest.mark.statement('BOOT-1')
def test_a_robot_that_is_not_there(lone: Callable[..., LoneServer]) -> None:
    """One sentence, exit status 2."""
    server = lone('robot:=nobody', wait=False)
    assert server.program.wait(20.0) == 2
    assert 'Traceback' not in server.program.text
    assert "'nobody'" in server.program.text.splitlines()[-1]


@pytest.mark.statement('BOOT-2')
def test_an_srdf_with_mistakes(mistaken: LoneServer) -> None:
    """Another name and unknown links are told, and the rest counts."""
    for text in ('monday', 'no_link'):
        mistaken.program.wait_for_line(text)
    played = mistaken.play(START)
    assert played.arm.planned(GOAL).points
    played.silence()


@pytest.mark.statement('SEED-4')
def test_another_controller_manager(mistaken: LoneServer) -> None:
    """Any plugin's name is accepted."""
    played = mistaken.play(START)
    manager = played.arm.parameters.get('moveit_controller_manager')
    assert manager == 'moveit_ros_control_interface/Ros2ControlManager'
    assert played.arm.planned(GOAL).points
    played.silence()


@pytest.mark.statement('CSM-1')
def test_states_of_its_namespace(mistaken: LoneServer) -> None:
    """
    The topic of joint states is relative: of the server's namespace, not the root's.

    Upstream: planning_scene_monitor.cpp, DEFAULT_JOINT_STATES_TOPIC.
    """
    played = mistaken.play(START, f'{NAMESPACE}/joint_states')
    assert name_of(played.arm.plan(GOAL).error_code) == 'SUCCESS'
    assert not mistaken.client.node.get_subscriptions_info_by_topic('/joint_states')
    played.silence()


@pytest.mark.statement('IF-0', 'IF-26')
def test_under_a_namespace(mistaken: LoneServer) -> None:
    """All relative names follow the node's namespace."""
    names = {name for name, _ in mistaken.client.node.get_service_names_and_types()}
    for name in ('plan_kinematic_path', 'compute_ik', 'move_group/list_parameters',
                 'move_action/_action/send_goal'):
        wait_for_service(mistaken, f'{NAMESPACE}/{name}')
    assert '/plan_kinematic_path' not in names


def wait_for_service(server: LoneServer, name: str) -> None:
    """Wait until a service is known."""
    deadline = time.monotonic() + 30.0
    while name not in {found for found, _ in server.client.node.get_service_names_and_types()}:
        assert time.monotonic() < deadline, f'no service {name}'
        server.client.in_executor(lambda: None)
