"""JSON Schemas for editors: they take the files of this package and point at slips."""

import json

from jsonschema import Draft202012Validator
import pytest

from armsim_ros.config.yaml_source import read_yaml_file
from armsim_ros.resources import cell_names, find_robot, PACKAGE, robot_names, share_folder
from armsim_ros.tools.check_config.main import main, schemas

SCHEMAS = schemas()
#: File of a robot -> the schema it belongs to; the others hold several kinds of blocks.
SCHEMA_OF = {
    'robots.yaml': 'robots',
    'joint_limits.yaml': 'joint_limits', 'kinematics.yaml': 'kinematics',
    'ompl_planning.yaml': 'ompl_planning', 'simulation.yaml': 'simulation',
    'trajectory_execution.yaml': 'trajectory_execution', 'trajectory_control.yaml': 'controllers',
    'joint_states.yaml': 'controllers', 'controllers_gazebo.yaml': 'moveit_controllers',
    'controllers.yaml': 'moveit_controllers', 'controller_group_robot.yaml': 'controllers',
    'joint_state_controller.yaml': 'controllers', 'magician_arm_controller.yaml': 'controllers',
}


def mistakes(name, data):
    """Return the messages of a validator for plain data."""
    validator = Draft202012Validator(SCHEMAS[f'{name}.schema.json'])
    return [error.message for error in validator.iter_errors(data)]


@pytest.mark.parametrize('name', sorted(SCHEMAS))
def test_each_schema_is_one(name):
    """It keeps to the standard's own schema."""
    Draft202012Validator.check_schema(SCHEMAS[name])


@pytest.mark.parametrize('robot', [*robot_names(), *cell_names()])
def test_the_files_of_this_package_are_taken(robot):
    """An editor marks nothing in them."""
    checked = [file for file in find_robot(robot).glob('*.yaml') if file.name in SCHEMA_OF]
    assert checked
    for file in checked:
        assert mistakes(SCHEMA_OF[file.name], read_yaml_file(file).plain()) == []


def test_worlds_are_taken():
    """The world of this package too."""
    worlds = list((share_folder(PACKAGE) / 'worlds').glob('*.yaml'))
    assert worlds
    for file in worlds:
        assert mistakes('world', read_yaml_file(file).plain()) == []


@pytest.mark.parametrize(('name', 'data'), [
    ('joint_limits', {'joint_limits': {'a': {'max_velocty': 1.0}}}),
    ('robots', {'robots': {'left': {'robot': 'bot', 'prefx': 'l_'}}}),
    ('kinematics', {'arm': {'kinematics_solver_timeout': 'soon'}}),
    ('simulation', {'timestap': 0.001}),
    ('simulation', {'timestep': 0.5}),
    ('trajectory_execution', {'trajectory_execution': {'allowed_start_tolerance': -1}}),
    ('controllers', {'arm': {'type': 'position_controllers/JointTrajectoryControler',
                             'joints': ['a']}}),
    ('controllers', {'ns': {'arm': {'type': 'position_controllers/JointTrajectoryController'}}}),
    ('moveit_controllers', {'controller_list': [{'name': 'arm', 'joint': ['a']}]}),
])
def test_a_slip_is_marked(name, data):
    """Unknown keys, wrong values and what is missing."""
    assert mistakes(name, data)


@pytest.mark.parametrize('argument', ['--schema={}', 'schema:={}'])
def test_the_program_writes_them(tmp_path, capsys, argument):
    """--schema DIR writes one file each and checks nothing."""
    assert main([argument.format(tmp_path)]) == 0
    assert {file.name for file in tmp_path.iterdir()} == set(SCHEMAS)
    for file in tmp_path.iterdir():
        assert json.loads(file.read_text())['$schema'].startswith('https://json-schema.org/')
