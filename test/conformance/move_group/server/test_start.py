# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The start of move_group, its parameters, its capabilities, and its robot state monitor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
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
GOAL = {name: value + 0.1 for name, value in START.items()}


@pytest.fixture(scope='module')
def started(pytestconfig: pytest.Config) -> Iterator[LoneServer]:
    """Start a server with parameters and capabilities of its own."""
    command = pytestconfig.getoption('server_command', None)
    if command is not None and not command.endswith('armsim_ros bringup'):
        pytest.skip('needs a server of its own with parameters of its own')
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
    ) as server:
        yield server


@pytest.fixture
def played(started: LoneServer) -> Iterator[PlayedArm]:
    """Publish joint states for one test."""
    player = started.play(START, '/elsewhere/joint_states')
    player.arm.joint_states.wait(1)
    yield player
    player.silence()


@pytest.mark.statement('ACT-2', 'BOOT-3')
def test_no_state_ever(started: LoneServer) -> None:
    """move_group starts without joint states; a plan is -23 and names the topic."""
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
    assert 'greater than or equal to 0' in played.arm.parameters.set(name, -1.0) or (
        played.arm.parameters.get(name) == 0.02
    )
    assert played.arm.parameters.get(name) == 0.02


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
    'ompl.display_path_topic', 'ompl.display_contacts_topic',
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
def test_missing_joints_are_named(lone: Callable[..., LoneServer]) -> None:
    """Incomplete states: a warning with the missing joints, and plans all the same."""
    server = lone()
    played = server.play({name: START[name] for name in list(START)[:4]})
    played.arm.joint_states.wait(1)
    assert name_of(played.arm.plan(GOAL).error_code) == 'SUCCESS'
    server.program.wait_for_line('incomplete.*joint_5, joint_6')


@pytest.mark.statement('CSM-6', 'IF-30a', 'MGI-8')
def test_unstamped_and_best_effort(lone: Callable[..., LoneServer]) -> None:
    """Best-effort messages without stamp count with the time of their arrival."""
    server = lone()
    played = server.play(START, '/joint_states', stamped=False, qos=qos_profile_sensor_data)
    for _ in range(2):
        assert played.arm.planned(GOAL).points
    server.program.wait_for_line('have no stamp')
    assert 'no joint state newer' not in server.program.text


@pytest.mark.statement('PAR-8')
def test_clocks_that_differ_are_told(lone: Callable[..., LoneServer]) -> None:
    """Stamps more than 10 s away: one warning that names the cure."""
    server = lone()
    played = server.play(START)
    played.shift = -100.0
    assert played.arm.planned(GOAL).points
    server.program.wait_for_line('use_sim_time')
    assert server.program.text.count('set use_sim_time on both') == 1


# ---------------------------------------------------------------- robots that lack something


def robot_without(tmp_path: Path, *names: str) -> Path:
    """Return a folder of the default arm without some files."""
    folder = tmp_path / 'bare'
    shutil.copytree(find_robot('sunday'), folder)
    for name in names:
        (folder / name).unlink()
    return folder


@pytest.mark.statement('SEED-9', 'BOOT-4')
def test_what_lacks_is_told_at_the_start(
    lone: Callable[..., LoneServer], tmp_path: Path
) -> None:
    """Without controllers: the log says which joints lack one, and the YAML to add."""
    folder = robot_without(tmp_path, 'controllers_gazebo.yaml', 'kinematics.yaml')
    server = lone(f'robot:={folder}', URDF)
    for text in ("'manipulator' can be planned for but not moved", 'type: FollowJointTrajectory',
                 'joints: \\[joint_1, joint_2'):
        server.program.wait_for_line(text)
    assert server.play(START).arm.planned(GOAL).points


@pytest.mark.statement('BOOT-1')
def test_a_robot_that_is_not_there(lone: Callable[..., LoneServer]) -> None:
    """One sentence, exit status 2."""
    server = lone('robot:=nobody', wait=False)
    assert server.program.wait(20.0) == 2
    assert 'Traceback' not in server.program.text
    assert "'nobody'" in server.program.text.splitlines()[-1]


@pytest.mark.statement('BOOT-2')
def test_an_srdf_with_mistakes(lone: Callable[..., LoneServer], tmp_path: Path) -> None:
    """Another name and unknown links are told, and the rest counts."""
    folder = robot_without(tmp_path)
    path = folder / 'sunday.srdf'
    text = path.read_text(encoding='utf-8').replace('<robot name="sunday">',
                                                    '<robot name="monday">')
    path.write_text(text.replace('</robot>', '<disable_collisions link1="no_link" '
                                 'link2="link_1" reason="Never"/></robot>'), encoding='utf-8')
    server = lone(f'robot:={folder}', URDF)
    assert server.play(START).arm.planned(GOAL).points


@pytest.mark.statement('SEED-4')
def test_another_controller_manager(lone: Callable[..., LoneServer], tmp_path: Path) -> None:
    """Any plugin's name is accepted."""
    folder = robot_without(tmp_path)
    (folder / 'manager.yaml').write_text(
        'moveit_controller_manager: moveit_ros_control_interface/Ros2ControlManager\n',
        encoding='utf-8',
    )
    server = lone(f'robot:={folder}', URDF)
    assert server.play(START).arm.planned(GOAL).points


@pytest.mark.statement('IF-0', 'IF-26')
def test_under_a_namespace(lone: Callable[..., LoneServer]) -> None:
    """All relative names follow the node's namespace."""
    server = lone('--ros-args', '-r', '__ns:=/kitchen', '--')
    names = {name for name, _ in server.client.node.get_service_names_and_types()}
    for name in ('plan_kinematic_path', 'compute_ik', 'move_group/list_parameters',
                 'move_action/_action/send_goal'):
        wait_for_service(server, f'/kitchen/{name}')
    assert '/plan_kinematic_path' not in names


def wait_for_service(server: LoneServer, name: str) -> None:
    """Wait until a service is known."""
    deadline = time.monotonic() + 30.0
    while name not in {found for found, _ in server.client.node.get_service_names_and_types()}:
        assert time.monotonic() < deadline, f'no service {name}'
        server.client.in_executor(lambda: None)
