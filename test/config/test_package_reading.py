# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the files of a package say, read as the original stack reads them."""

import pytest

from armsim_ros.config.ompl_planning import Planner
from armsim_ros.errors import Severity
from armsim_ros.kinematics.planning_limits import planning_robot
from armsim_ros.model.cell_loading import survey_cell
from armsim_ros.model.description.moveit_parameters import MoveItParameters


def survey(package, **words):
    """Return what was found; there are no mistakes."""
    found = survey_cell(str(package.folder), **words)
    mistakes = [str(one) for one in found.problems if one.severity is Severity.ERROR]
    assert not mistakes
    return found


def said(found, severity=Severity.WARNING):
    """Return what was said, without the paths."""
    return [one.what for one in found.problems if one.severity is severity]


def test_what_move_group_knows_starts_and_the_rest_stays_unloaded(small_package):
    """Without a launch file the broadcaster and the planned controllers are active."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'other_controller:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'
        '    joints: [shoulder, elbow]\n    command_interfaces: [position]\n'
        '    state_interfaces: [position]\n'))
    settings = survey(small_package).settings
    assert set(settings.spawn) == {'arm_controller', 'joint_state_broadcaster'}
    assert settings.controller('other_controller') is not None
    assert settings.spawn_only


def test_controllers_are_made_from_what_move_group_knows(small_package):
    """Where no file describes controllers, those of move_group run, and a line says so."""
    small_package.remove('config/ros2_controllers.yaml')
    found = survey(small_package)
    assert found.settings.controller('arm_controller').joints == ('shoulder', 'elbow')
    assert 'joint_state_broadcaster' in found.settings.spawn
    assert any('no file describes the controllers' in text
               for text in said(found, Severity.INFO))


def test_tolerances_of_joints_that_a_controller_lacks_have_no_effect(small_package):
    """The original reads those of its own joints only, so the controller runs, with a warning."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        '    constraints: {goal_time: 0.5, elbow: {goal: 0.1}, joint1: {goal: 0.2}}\n'
        '    gains: {joint1: {p: 1.0}}\n'))
    found = survey(small_package)
    controller = found.settings.controller('arm_controller')
    assert controller.parameters.constraints.joints['elbow'].goal == 0.1
    assert [one for one in said(found, Severity.WARNING) if "'joint1'" in one] == [
        f"controller 'arm_controller': {key}: 'joint1' is not among the controller's joints "
        'and has no effect' for key in ('constraints', 'gains')]


def test_a_controller_of_efforts_starts_behind_one_of_positions(small_package):
    """Of two that share joints the one that holds them starts, and move_group prefers it."""
    small_package.write('config/moveit_controllers.yaml', small_package.MOVEIT.replace(
        '[arm_controller]', '[push_controller, arm_controller]').replace(
            'default: true', 'default: false') + (
        '  push_controller:\n'
        '    {type: FollowJointTrajectory, action_ns: follow_joint_trajectory, default: true,\n'
        '     joints: [shoulder, elbow]}\n'))
    small_package.write('config/ros2_controllers.yaml', (
        'push_controller:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'
        '    joints: [shoulder, elbow]\n    command_interfaces: [effort]\n'
        '    state_interfaces: [position, velocity]\n'
        '    gains: {shoulder: {p: 75.0}, elbow: {p: 75.0}}\n') + small_package.ROS2)
    settings = survey(small_package).settings
    assert [name for name in settings.spawn if name != 'joint_state_broadcaster'] == [
        'arm_controller', 'push_controller']
    assert {one.name: one.default for one in settings.moveit_controllers} == {
        'push_controller': False, 'arm_controller': True}


def test_without_controllers_of_move_group_all_that_fit_together_start(small_package):
    """The first that has a joint keeps it."""
    small_package.write('config/moveit_controllers.yaml', 'moveit_simple_controller_manager: {}\n')
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + ''.join(
        f'{name}:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'
        f'    joints: [{joint}]\n    command_interfaces: [position]\n'
        '    state_interfaces: [position, velocity]\n'
        for name, joint in (('second_of_elbow', 'elbow'), ('third', 'elbow'))))
    spawned = survey(small_package).settings.spawn
    assert [name for name in spawned if name != 'joint_state_broadcaster'] == ['arm_controller']


def test_a_manager_that_asks_knows_all_trajectory_controllers(small_package):
    """moveit_ros_control_interface names no controllers: it asks for those that there are."""
    small_package.write('config/moveit_controllers.yaml', (
        'moveit_controller_manager: moveit_ros_control_interface/Ros2ControlManager\n'))
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'untyped:\n  ros__parameters: {joints: [shoulder]}\n'
        'jointless:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'))
    found = survey(small_package)
    (one,) = found.settings.moveit_controllers
    assert (one.name, one.joints, one.action_name) == (
        'arm_controller', ('shoulder', 'elbow'), 'arm_controller/follow_joint_trajectory')
    assert 'arm_controller' in found.settings.spawn


@pytest.mark.parametrize(('kind', 'runs_as'), [
    ('scaled_controllers/ScaledJointTrajectoryController',
     'joint_trajectory_controller/JointTrajectoryController'),
    ('vendor/VendorJointTrajectoryController',
     'joint_trajectory_controller/JointTrajectoryController'),
    ('joint_state_controller/JointStateController',
     'joint_state_broadcaster/JointStateBroadcaster'),
    ('vendor/ForceTorqueSensorBroadcaster', 'vendor/ForceTorqueSensorBroadcaster'),
    ('vendor/GPIOController', 'vendor/GPIOController'),
    ('vendor/SpeedScalingStateBroadcaster', 'vendor/SpeedScalingStateBroadcaster'),
])
def test_a_vendors_controller_is_stood_in_for(small_package, kind, runs_as):
    """Each gets a line; what it is in the end is a type that can be loaded."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        f'more:\n  ros__parameters:\n    type: {kind}\n    joints: [grip]\n'
        '    command_interfaces: [position]\n    state_interfaces: [position]\n'))
    found = survey(small_package)
    assert found.settings.controller('more').type == runs_as
    assert sum(kind in text for text in said(found, Severity.CHANGED)) == 1


def test_a_type_that_nobody_has_here_only_warns(small_package):
    """The robot starts; --strict refuses."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'twist:\n  ros__parameters: {type: vendor/TwistController, joint: tcp}\n'))
    found = survey(small_package)
    assert any("type 'vendor/TwistController' is not known" in text for text in said(found))
    strict = survey_cell(str(small_package.folder), strict=True)
    assert [one.where.line for one in strict.problems if one.severity is Severity.ERROR] == [12]


def test_other_nodes_may_have_parameters_in_the_file_of_controllers(small_package):
    """A block without a type is a controller's if it names joints or interfaces."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'bus_driver:\n  ros__parameters: {retries: 5}\n'
        'typeless:\n  ros__parameters: {joints: [grip]}\n'))
    assert [text for text in said(survey(small_package)) if 'has no type' in text] == [
        "controller 'typeless' has no type"]


def test_unknown_keys_are_left_out_with_a_warning(small_package):
    """What the original does not know it does not read."""
    small_package.write('config/kinematics.yaml', 'arm: {kinematics_solver: a/B, drot: 1}\n')
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2.replace(
        '    joints: [shoulder, elbow]\n', '    joints: [shoulder, elbow]\n    my_key: 3\n'))
    found = survey(small_package)
    assert found.settings.kinematics['arm'].kinematics_solver == 'a/B'
    assert len([text for text in said(found) if 'is not known' in text]) == 2


def test_limits_count_only_where_they_are_switched_on(small_package):
    """As in MoveIt; a whole number is a number; an unknown joint is a warning."""
    small_package.write('config/joint_limits.yaml', (
        'joint_limits:\n'
        '  shoulder: {has_velocity_limits: true, max_velocity: 1, max_acceleration: 3}\n'
        '  elbow: {max_velocity: 0.5}\n  nobody: {has_velocity_limits: false}\n'))
    found = survey(small_package)
    planned = planning_robot(found.model, found.settings.joint_limits)
    limits = {name: joint.limits for name, joint in planned.joints.items()}
    assert limits['shoulder'].velocity == 1.0
    assert limits['shoulder'].acceleration == float('inf')
    assert limits['elbow'].velocity == 2.0
    assert any("'nobody'" in text for text in said(found))


def test_a_key_twice_is_read_as_ros_reads_it(small_package):
    """Blocks of a parameter file are merged, as rcl does it; elsewhere the second one counts."""
    text = small_package.ROS2
    head, sign, rest = text.partition('arm_controller:\n  ros')
    small_package.write('config/ros2_controllers.yaml', (
        '/**:\n' + ''.join(f'  {line}\n' for line in head.splitlines())
        + '/**:\n' + ''.join(f'  {line}\n' for line in (sign + rest).splitlines())))
    small_package.write('config/kinematics.yaml', (
        'arm: {kinematics_solver: a/B}\narm: {kinematics_solver: c/D}\n'))
    found = survey(small_package)
    assert found.settings.controller('arm_controller').joints == ('shoulder', 'elbow')
    assert found.settings.controller_manager.update_rate == 500
    assert found.settings.kinematics['arm'].kinematics_solver == 'c/D'
    assert sum('is defined twice, first in line' in text for text in said(found)) == 2


def test_a_named_node_wins_over_a_wildcard(small_package):
    """Whatever the order; nested and dotted keys are one."""
    small_package.write('config/ros2_controllers.yaml', (
        small_package.ROS2.replace('update_rate: 500', 'update_rate: 250')
        + '/**/controller_manager:\n  ros__parameters: {update_rate: 100}\n'
        + '/**/arm_controller:\n  ros__parameters:\n    constraints.goal_time: 2.0\n'))
    settings = survey(small_package).settings
    assert settings.controller_manager.update_rate == 250
    assert settings.controller('arm_controller').parameters.constraints.goal_time == 2.0


def test_values_of_a_launch_file_are_filled_in(small_package):
    """$(var x) takes a word of the user, else the xacro's default; without either it warns."""
    small_package.write('config/small.urdf.xacro', small_package.XACRO.format(
        '<xacro:arg name="prefix" default=""/>'
        '<xacro:include filename="$(find small_description)/urdf/arm.urdf"/>'))
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2.replace(
        '[shoulder, elbow]', '[$(var prefix)shoulder, $(var missing)elbow]'))
    found = survey(small_package)
    assert found.settings.controller('arm_controller').joints == ('shoulder', 'elbow')
    assert [text for text in said(found) if 'has no value' in text] == [
        "'$(var missing)' has no value; nothing is put in its place"]
    assert not [text for text in said(survey(small_package, arguments={'missing': ''}))
                if 'has no value' in text]


def test_the_urdfs_plugin_names_the_controllers(small_package, tmp_path):
    """Its <parameters> wins over config/ros2_controllers.yaml; controllers:= wins over both."""
    plugged = tmp_path / 'plugged.yaml'
    plugged.write_text(small_package.ROS2.replace('500', '250'))
    given = tmp_path / 'given.yaml'
    given.write_text(small_package.ROS2.replace('500', '125'))
    plugin = (f'<gazebo><plugin filename="gz_ros2_control-system" name="x"><parameters>{plugged}'
              '</parameters></plugin></gazebo>')
    small_package.ros2_control(more=plugin)
    assert survey(small_package).settings.controller_manager.update_rate == 250
    settings = survey(small_package, controllers=[given]).settings
    assert settings.controller_manager.update_rate == 125


def test_xacro_arguments_go_to_urdf_and_srdf(small_package):
    """The word wins over the file's default; what is declared is known by name and value."""
    small_package.write('config/small.urdf.xacro', small_package.XACRO.format(
        '<xacro:arg name="reach" default="0.2"/><xacro:arg name="never" default="no"/>'
        '<xacro:include filename="$(find small_description)/urdf/arm.urdf"/>'
        '<link name="tip_$(arg reach)"/><joint name="tip" type="fixed"><parent link="lower"/>'
        '<child link="tip_$(arg reach)"/></joint>'))
    (small_package.folder / 'config/small.srdf').rename(
        small_package.folder / 'config/small.srdf.xacro')
    small_package.write('config/small.srdf.xacro', small_package.SRDF.replace(
        '<robot ', '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ').replace(
        '<group name="arm">', '<xacro:arg name="group" default="arm"/><group name="$(arg group)">'
    ).replace('group="arm"', 'group="$(arg group)"'))
    found = survey(small_package, arguments={'reach': '0.7', 'group': 'left'})
    assert 'tip_0.7' in found.model.links
    assert set(found.model.semantic.groups) == {'left'}
    assert found.declared == {'reach': '0.7', 'never': 'no', 'group': 'left'}


def test_a_pipeline_of_the_package_replaces_the_default(small_package):
    """The planners of ompl_planning.yaml are offered, those of others get a line."""
    small_package.write('config/ompl_planning.yaml', (
        'planning_plugins: [ompl_interface/OMPLPlanner]\n'
        'planner_configs: {Mine: {type: geometric::RRT, range: 1}}\n'
        'arm: {planner_configs: [Mine]}\n'))
    small_package.write('config/stomp_planning.yaml', 'stomp_moveit: {num_timesteps: 60}\n')
    found = survey(small_package)
    assert set(found.settings.pipelines['ompl'].planner_configs) == {'Mine'}
    assert found.settings.planning_parameters.planning_pipelines[0] == 'ompl'
    assert any("pipeline 'stomp'" in text for text in said(found, Severity.INFO))


def test_pipelines_have_the_names_of_their_files(small_package):
    """
    A file makes a pipeline of any name; its plugin, not its name, is its planner.

    moveit_configs_utils' MoveItConfigsBuilder: planning_pipelines.
    """
    small_package.write(
        'config/pilz_planning.yaml',
        'planning_plugins: [pilz_industrial_motion_planner/CommandPlanner]\n')
    small_package.write('config/fast_planning.yaml', (
        'planning_plugins: [ompl_interface/OMPLPlanner]\n'
        'planner_configs: {Mine: {type: geometric::RRT, range: 1}}\n'))
    settings = survey(small_package).settings
    assert settings.pipelines['pilz'].planner is Planner.PILZ
    assert settings.pipelines['fast'].planner is Planner.OMPL
    assert set(settings.pipelines['fast'].planner_configs) == {'Mine'}
    assert settings.planning_parameters.planning_pipelines == (
        'ompl', 'fast', 'pilz', 'pilz_industrial_motion_planner')


MESH = '<collision><geometry><mesh filename="package://lost/meshes/{}.stl"/></geometry></collision>'


def test_a_missing_package_of_meshes_is_told_once(small_package):
    """All links that go without are named in one line; --strict refuses the robot."""
    text = (small_package.description / 'urdf/arm.urdf').read_text()
    for link in ('base', 'upper', 'lower'):
        text = text.replace(f'<link name="{link}">', f'<link name="{link}">{MESH.format(link)}')
    small_package.write('../description_folder/urdf/arm.urdf', text)
    found = [text for text in said(survey(small_package)) if 'geometry' in text]
    assert len(found) == 1
    assert found[0].startswith('the links base, upper, lower have no collision geometry: '
                               "package 'lost' is not found; searched: ")
    strict = survey_cell(str(small_package.folder), strict=True)
    assert any(one.strict for one in strict.problems)


def test_a_mistake_costs_what_it_is_about(small_package):
    """A controller with wrong values or a wrong limit is left out, and the others count."""
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'gripper:\n  ros__parameters: {type: position_controllers/GripperActionController}\n'))
    small_package.write('config/joint_limits.yaml', (
        'joint_limits:\n  shoulder: {has_velocity_limits: true, max_velocity: quick}\n'
        '  elbow: {has_velocity_limits: true, max_velocity: 1}\n'))
    found = survey(small_package)
    assert found.settings.controller('gripper') is None
    planned = planning_robot(found.model, found.settings.joint_limits)
    assert planned.joints['elbow'].limits.velocity == 1.0
    assert planned.joints['shoulder'].limits.velocity == 2.0
    assert any("'joint_limits.shoulder.max_velocity' is the text 'quick'" in text
               for text in said(found))


def test_a_controller_of_joints_that_are_not_there_stays_inactive(small_package):
    """The others start."""
    small_package.write('config/moveit_controllers.yaml', small_package.MOVEIT.replace(
        '[arm_controller]', '[arm_controller, other]')
        + '  other: {type: FollowJointTrajectory, joints: [nobody]}\n')
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'other:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'
        '    joints: [nobody]\n    command_interfaces: [position]\n'
        '    state_interfaces: [position]\n'))
    found = survey(small_package)
    assert set(found.cell.settings.spawn) == {'arm_controller', 'joint_state_broadcaster'}
    assert any("joint 'nobody' is not in the URDF" in text for text in said(found))


def test_of_two_controllers_of_one_arm_move_groups_default_starts(small_package):
    """Both are known to move_group; the one that it prefers is first."""
    small_package.write('config/moveit_controllers.yaml', small_package.MOVEIT.replace(
        '[arm_controller]', '[arm_controller, other]').replace('default: true', 'default: false')
        + '  other: {type: FollowJointTrajectory, joints: [shoulder, elbow], default: true}\n')
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'other:\n  ros__parameters:\n'
        '    type: joint_trajectory_controller/JointTrajectoryController\n'
        '    joints: [shoulder, elbow]\n    command_interfaces: [position]\n'
        '    state_interfaces: [position]\n'))
    spawn = survey(small_package).settings.spawn
    assert spawn == ('joint_state_broadcaster', 'other', 'arm_controller')


def test_planners_without_a_file_are_those_of_the_builder(small_package):
    """
    A package without ompl_planning.yaml has the planners that its launch file would load.

    moveit_configs_utils' MoveItConfigsBuilder: planning_pipelines.
    """
    launched = MoveItParameters(small_package.folder).planning_pipelines()['ompl']
    ompl = survey(small_package).settings.pipelines['ompl']
    assert {name: one.type for name, one in ompl.planner_configs.items()} == {
        name: one['type'] for name, one in launched['planner_configs'].items()}
    assert list(ompl.request_adapters) == launched['request_adapters']
    assert list(ompl.response_adapters) == launched['response_adapters']


@pytest.mark.parametrize(('text', 'message'), [
    ('joint_limits:\n  shoulder: [1, 2\n', '2:13: the bracket that opens here is not closed'),
    ('joint_limits:\n  shoulder:\n    has_velocity_limits: true\n    max_velocity: quick\n',
     "4:19: joint limits: 'joint_limits.shoulder.max_velocity' is the text 'quick'"),
])
def test_a_mistake_has_file_and_line(small_package, text, message):
    """Of YAML that cannot be read, and of a value that is of the wrong kind."""
    small_package.write('config/joint_limits.yaml', text)
    lines = [str(problem) for problem in survey_cell(str(small_package.folder)).problems]
    assert any(f'config/joint_limits.yaml:{message}' in line for line in lines), lines
