# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A simulation by the arguments of ros2_control_node."""

from pathlib import Path
import re

import pytest
import yaml

from armsim_ros.cli.node_arguments import read_node_arguments
from armsim_ros.config.draft import ConfigDraft
from armsim_ros.config.layout import LayoutReader
from armsim_ros.config.sections import read_sections
from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.errors import ConfigError, Severity
from armsim_ros.model.cell_loading import survey_cell
from armsim_ros.nodes.upstream.robot_programs import simulation_words
from armsim_ros.sim.assembly import build_simulation

CONTROLLERS = """
controller_manager:
  ros__parameters:
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
"""


@pytest.mark.parametrize(('told', 'spawned'), [('true', ['states']), ('false', [])])
def test_the_broadcaster_that_no_spawner_starts_is_active_at_once(tmp_path, told, spawned):
    """Controllers wait for spawners; a broadcaster that the launch lacks one for does not."""
    file = tmp_path / 'controllers.yaml'
    file.write_text(CONTROLLERS)
    arguments = read_node_arguments(
        ['--params-file', str(file), '-p', f'armsim.joint_states:={told}'], 'controller_manager')
    words = simulation_words('<robot name="r"/>', arguments, tmp_path)
    folder = Path(words[0].removeprefix('robot:='))
    content = yaml.safe_load((folder / 'config' / 'simulation.yaml').read_text())
    assert content['spawn'] == spawned


@pytest.mark.parametrize('name', ['', 'panda_gripper'])
def test_the_hand_has_the_name_and_the_parameters_of_its_own_arguments(tmp_path, name):
    """No other node has them; without a name it is that of the program."""
    file = tmp_path / 'franka_gripper_node.yaml'
    file.write_text(f'{name or "franka_gripper_node"}:\n  ros__parameters:\n'
                    '    default_grasp_epsilon: {inner: 0.01}\n    state_publish_rate: 50\n')
    own = ['--ros-args', '--params-file', str(file)]
    own += ['-r', f'__node:={name}'] if name else []
    arguments = read_node_arguments(
        ['-p', f'armsim.gripper:={yaml.safe_dump(own, default_flow_style=True, width=999)}'],
        'controller_manager')
    words = simulation_words('<robot name="r"/>', arguments, tmp_path)
    folder = Path(words[0].removeprefix('robot:='))
    content = yaml.safe_load((folder / 'config' / 'simulation.yaml').read_text())
    assert content['hardware'] == {'gripper': name or 'franka_gripper_node'}
    given = Path(words[words.index('--params-file') + 1])
    assert yaml.safe_load(given.read_text()) == {f'/**/{name or "franka_gripper_node"}': {
        'ros__parameters': {'default_grasp_epsilon.inner': 0.01, 'state_publish_rate': 50}}}


@pytest.mark.parametrize(('arguments', 'floor'), [
    ([], False), (['-p', 'armsim.floor:=true'], True)])
def test_only_a_simulators_world_has_a_floor(small_package, tmp_path, arguments, floor):
    """ros2_control_node alone knows nothing around the robot; a launch file's Gazebo does."""
    urdf = survey_cell(str(small_package.folder)).checked().model.urdf
    words = dict(word.split(':=') for word in simulation_words(
        urdf, read_node_arguments(arguments, 'controller_manager'), tmp_path / 'launched')
        if ':=' in word)
    launched = survey_cell(words['robot'], urdf=Path(words['urdf']), world=words.get('world'))
    assert launched.checked().settings.world.floor is floor


def test_a_robot_that_cannot_move_is_refused(small_package, tmp_path):
    """An object that a launch file took for the robot ends it with one line."""
    urdf = f'<robot name="cube">{small_package.LINK.format("box")}</robot>'
    words = dict(word.split(':=') for word in simulation_words(
        urdf, read_node_arguments([], 'controller_manager'), tmp_path / 'launched')
        if ':=' in word)
    cell = survey_cell(words['robot'], urdf=Path(words['urdf'])).checked()
    with pytest.raises(ConfigError, match=r"robot 'cube' has no movable joint.*docs/world\.md"):
        build_simulation(cell.settings, cell.model)


LIMITED = """
joint_limits:
  elbow: {min_position: -1.0, max_position: 1.0, has_velocity_limits: true, max_velocity: 0.5}
"""


def test_the_robot_is_that_of_bringup(small_package, tmp_path):
    """
    Ranges, drives, hardware and controllers are equal, whatever joint_limits.yaml says.

    moveit_ros/planning/robot_model_loader/src/robot_model_loader.cpp: only move_group reads it.
    """
    small_package.ros2_control(*(
        f'<joint name="{name}"><command_interface name="position">'
        '<param name="min">-1.5</param><param name="max">1.5</param></command_interface>'
        '<state_interface name="position"/><state_interface name="velocity"/></joint>'
        for name in ('shoulder', 'elbow', 'grip')))
    small_package.write('config/joint_limits.yaml', LIMITED)
    own = survey_cell(str(small_package.folder)).checked()
    controllers = small_package.folder / 'config/ros2_controllers.yaml'
    arguments = read_node_arguments(['--params-file', str(controllers)], 'controller_manager')
    words = dict(word.split(':=') for word in simulation_words(
        own.model.urdf, arguments, tmp_path / 'launched') if ':=' in word)
    launched = survey_cell(
        words['robot'], urdf=Path(words['urdf']),
        controllers=[Path(file) for file in words['controllers'].split(',')]).checked()
    assert launched.model.active_joints == own.model.active_joints
    assert {name: joint.limits for name, joint in launched.model.joints.items()} == {
        name: joint.limits for name, joint in own.model.joints.items()}
    assert launched.model.hardware == own.model.hardware
    assert [(one.name, one.parameters) for one in launched.settings.controllers] == [
        (one.name, one.parameters) for one in own.settings.controllers]
    assert launched.settings.controller_manager == own.settings.controller_manager
    ours, theirs = own.settings.simulation, launched.settings.simulation
    assert theirs == ours.model_copy(update={'state_publisher': False})


def test_parameters_of_the_manager_from_a_dictionary(tmp_path):
    """
    Parameters of a launch file's dictionary reach the manager as those of a file do.

    Those that have no effect here are reported, each once.

    controller_manager.cpp declares parameters from overrides, wherever they come from.
    """
    file = tmp_path / 'controllers.yaml'
    file.write_text(CONTROLLERS)
    given = {'hardware_components_initial_state.inactive': ['hand'],
             'defaults.allow_controller_activation_with_inactive_hardware': True,
             'overruns.manage': False, 'overruns.print_warnings': False,
             'diagnostics.threshold.controller_manager.periodicity.mean_error.warn': 3.0,
             'enforce_command_limits': True, 'arm.fallback_controllers': ['hold'],
             'arm.node_options_args': ['-r', 'a:=b'], 'arm.params_file': ['arm.yaml']}
    ignored = {'thread_priority': 40, 'cpu_affinity': [1], 'lock_memory': True,
               'handle_exceptions': False, 'hardware_synchronization.minimum_cycle_time': 0.1,
               'diagnostics.threshold.controllers.periodicity.mean_error.warn': 3.0}
    words = [word for key, value in {**given, **ignored}.items()
             for word in ('-p', f'{key}:={yaml.safe_dump(value, default_flow_style=True)}')]
    arguments = read_node_arguments(
        ['--params-file', str(file), *words], 'controller_manager')
    *_, controllers = [word for word in simulation_words(
        '<robot name="r"/>', arguments, tmp_path) if word.startswith('controllers:=')]
    draft = ConfigDraft()
    for path in controllers.removeprefix('controllers:=').split(','):
        LayoutReader(draft).read(read_yaml_file(Path(path)), Path(path).stem)
    manager = read_sections(draft)['controller_manager']
    assert manager.hardware_components_initial_state.inactive == ('hand',)
    assert manager.defaults.allow_controller_activation_with_inactive_hardware
    assert manager.enforce_command_limits
    assert (manager.overruns.manage, manager.overruns.print_warnings) == (False, False)
    assert manager.diagnostics.threshold.controller_manager.periodicity.mean_error.warn == 3.0
    arm = manager.controllers['arm']
    assert (arm.fallback_controllers, arm.node_options_args, arm.params_file) == (
        ('hold',), ('-r', 'a:=b'), ('arm.yaml',))
    wrong = [one for one in draft.problems if 'has no effect here' in one.what]
    assert all(one.severity is Severity.WARNING for one in wrong), wrong
    assert {re.search("'([^']+)'", one.what)[1] for one in wrong} == {
        *(name.partition('.')[0] for name in ignored if 'diagnostics' not in name),
        'diagnostics.threshold.controllers'}
