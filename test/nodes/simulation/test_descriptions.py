# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Where a controller's settings come from when the manager loads it.

The behaviour is that of controller_manager.cpp: load_controller,
determine_controller_node_options.
"""

from types import SimpleNamespace

import pytest

from armsim_ros.config.robot_settings import RobotSettings
from armsim_ros.errors import ConfigError, ControllerError
from armsim_ros.nodes.simulation.controllers.registry import ControllerDescriptions

TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
BROADCASTER = 'joint_state_broadcaster/JointStateBroadcaster'


class Parameters:
    """Stand for the manager's node: its parameters and its namespace."""

    def __init__(self, **values):
        self._values = {key.replace('__', '.'): value for key, value in values.items()}

    def has_parameter(self, name):
        return name in self._values

    def get_parameter(self, name):
        return SimpleNamespace(value=self._values[name])

    def get_namespace(self):
        return '/left'


def robot(*controllers):
    """Return the settings of a robot with some controllers."""
    return RobotSettings(
        name='arm', folder='/', urdf_file='/arm.urdf', controllers=controllers)


def found(settings=None, **values):
    """Return what the manager finds for the controller arm."""
    node = Parameters(**values)
    return ControllerDescriptions(node, settings or robot()).find('arm')


@pytest.fixture(name='file')
def _file(tmp_path):
    """Return a function that writes a parameter file and returns its path."""
    def write(text):
        path = tmp_path / f'{len(list(tmp_path.iterdir()))}.yaml'
        path.write_text(text, encoding='utf-8')
        return str(path)
    return write


def test_a_file_is_read_for_the_controllers_own_name(file):
    """Only blocks that name the controller with its namespace count."""
    path = file('/left/arm: {ros__parameters: {joints: [a]}}\n'
                '/right/arm: {ros__parameters: {joints: [b]}}\n')
    assert found(arm__type=TRAJECTORY, arm__params_file=[path]).parameters.joints == ('a',)


def test_a_wildcard_block_is_every_controllers(file):
    """Parameters below /** are those of the controller; unknown ones are left out."""
    path = file('/**: {ros__parameters: {joints: [a], use_sim_time: true, strange: 1}}')
    assert found(arm__type=TRAJECTORY, arm__params_file=path).parameters.joints == ('a',)


def test_later_files_and_arguments_win(file):
    """A later file wins over earlier ones, and the node's own arguments over all files."""
    first = file('/**/arm: {ros__parameters: {joints: [a], constraints: {goal_time: 1.0, '
                 'stopped_velocity_tolerance: 0.2}}}')
    second = file('/**/arm: {ros__parameters: {constraints.goal_time: 2.0}}')
    constraints = found(arm__type=TRAJECTORY, arm__params_file=[first, second]
                        ).parameters.constraints
    assert (constraints.goal_time, constraints.stopped_velocity_tolerance) == (2.0, 0.2)
    third = file('/**/arm: {ros__parameters: {joints: [b]}}')
    options = ['--ros-args', '-p', 'constraints.goal_time:=3.0', '--params-file', third]
    parameters = found(arm__type=TRAJECTORY, arm__params_file=[first, second],
                       arm__node_options_args=options).parameters
    assert (parameters.constraints.goal_time, parameters.joints) == (3.0, ('b',))


def test_arguments_of_a_controller_of_the_robots_files():
    """The node's own arguments win over the robot's files, too."""
    known = found(arm__type=BROADCASTER)
    known = known.model_copy(update={
        'parameters': known.parameters.model_copy(update={'use_local_topics': True})})
    settings = robot(known)
    assert found(settings) is known
    parameters = found(settings, arm__node_options_args=['-p', 'frame_id:=b']).parameters
    assert (parameters.frame_id, parameters.use_local_topics) == ('b', True)


def test_files_of_a_spawner_add_to_the_robots_files(file):
    """
    A parameter file of the spawner wins over the robot's files, which count as well.

    Upstream passes the manager's own parameter files to every controller, and then those of the
    spawner, such as the use_sim_time of a launch file's node.
    """
    own = file('/**/arm: {ros__parameters: {joints: [a], constraints: {goal_time: 1.0}}}')
    settings = robot(found(arm__type=TRAJECTORY, arm__params_file=own))
    clock = file('/**: {ros__parameters: {use_sim_time: true}}')
    assert found(settings, arm__params_file=clock).parameters.joints == ('a',)
    later = file('/left/arm: {ros__parameters: {joints: [b]}}')
    parameters = found(settings, arm__type=TRAJECTORY, arm__params_file=[clock, later]).parameters
    assert (parameters.joints, parameters.constraints.goal_time) == (('b',), 1.0)


def test_remappings_are_arguments_of_the_node():
    """Remappings alone change no parameter; they are passed to the controller's node."""
    node = Parameters(arm__type=BROADCASTER, arm__node_options_args=['-r', 'joint_states:=/b'])
    descriptions = ControllerDescriptions(node, robot())
    assert descriptions.find('arm').parameters == found(arm__type=BROADCASTER).parameters
    assert descriptions.node_options('arm') == ('--ros-args', '-r', 'joint_states:=/b')
    assert descriptions.node_options('other') == ()


def test_nothing_describes_it():
    """Without a type and a file the controller is not loaded."""
    with pytest.raises(ControllerError, match=r"'arm\.type' is not set"):
        found()


def test_a_file_without_a_type_is_refused(file):
    """A spawner's file that gives only parameters of the node names no controller."""
    with pytest.raises(ConfigError, match="controller 'arm' has no type"):
        found(arm__params_file=[file('arm: {ros__parameters: {use_sim_time: true}}\n')])


def test_a_type_of_a_plugin_that_is_not_offered_is_named(file):
    """A file whose only fault is an unknown type is refused with that type's name."""
    path = file('/left/arm: {ros__parameters: {type: my_robot/RobotController, joints: [a]}}\n')
    with pytest.raises(ConfigError, match="type 'my_robot/RobotController' is not known"):
        found(arm__params_file=[path])
