"""A folder with robots.yaml: several robots, their names kept apart, one value for the whole."""

import pytest

from armsim_ros.config.cell import merged_settings, read_cell
from armsim_ros.config.loading import load_robot_settings, survey_files
from armsim_ros.config.ompl_planning import Planner
from armsim_ros.config.prefix import prefixed_settings
from armsim_ros.config.robot_folder import find_files
from armsim_ros.errors import ConfigError, Severity


@pytest.fixture
def complaints(tmp_path):
    """Return a function from the text of a robots.yaml to its mistakes."""
    def find(text):
        file = tmp_path / 'robots.yaml'
        file.write_text(text)
        with pytest.raises(ConfigError) as caught:
            read_cell(file)
        return [str(one).replace(f'{tmp_path}/', '') for one in caught.value.problems]
    return find


@pytest.fixture
def merge(tmp_path):
    """Return a function from files of a cell's own and its robots to (settings, problems)."""
    def do(robots, **own):
        (tmp_path / 'robots.yaml').write_text('robots: {}')
        for name, text in own.items():
            (tmp_path / f'{name}.yaml').write_text(text)
        problems = []
        merged = merged_settings(survey_files(find_files(str(tmp_path))), robots, problems)
        return merged, problems
    return do


def named(robot, name, **arguments):
    """Return the settings of one of our robots under a prefix."""
    return prefixed_settings(load_robot_settings(robot, **arguments), f'{name}_', name)


def test_prefix_and_namespace_follow_from_the_name(tmp_path):
    """What is given wins, '' too."""
    (tmp_path / 'robots.yaml').write_text(
        "robots: {a: {robot: bot}, b: {robot: bot, prefix: '', namespace: /x/y/}}")
    cell, _ = read_cell(tmp_path / 'robots.yaml')
    assert [cell.prefix(name) for name in cell.robots] == ['a_', '']
    assert [cell.namespace(name) for name in cell.robots] == ['a', 'x/y']


@pytest.mark.parametrize(('text', 'said'), [
    ('robots: {}', "'robots' is empty; allowed: at least one robot"),
    ('robots: [bot]', "'robots' is a list; allowed: a block of keys"),
    ('robots:\n  a: {}', "robots.yaml:2:3: cell: 'robots.a.robot' is missing"),
    ('robots:\n  a: {robot: bot, prefx: b_}', "2:19: cell: key 'robots.a.prefx' is not known"),
    ('robots:\n  a: {robot: bot, prefix: a b}', "'a b' cannot begin a name"),
    ('robots:\n  a: {robot: bot, namespace: a//b}', "'a//b' is not a ROS name"),
    ('robots:\n  a: {robot: bot, xyz: [0, 0, .inf]}', 'all three numbers must be finite'),
    ('robots:\n  a-b: {robot: bot}', "2:3: cell: robots: 'a-b' is not a name for a robot"),
    ('robots:\n  a: {robot: bot}\n  b: {robot: bot, namespace: a}',
     "robots.yaml:3:3: cell: robots: 'b' and 'a' are both in namespace '/a'"),
])
def test_mistakes_name_the_place(complaints, text, said):
    """One message with line, what is allowed, and a hint."""
    (complaint,) = complaints(text)
    assert said in complaint


def test_a_cell_is_no_robot():
    """What needs one robot says so, and what to do."""
    with pytest.raises(ConfigError, match=r'two_bots/robots\.yaml: .*name the folder of one'):
        load_robot_settings('two_bots')


def test_every_name_gets_the_prefix():
    """Joints, links and planning groups, wherever the files name them."""
    arm = named('ROBOT', 'left')
    joints = tuple(f'left_j{number}' for number in range(1, 7))
    controller = arm.controller('ROBOT_joint_controller')
    assert controller.joints == joints
    assert tuple(controller.parameters.gains) == joints
    assert set(controller.parameters.constraints.joints) == set(joints)
    assert set(joints) <= set(arm.joint_limits.joint_limits)
    assert all(group.startswith('left_') for group in arm.kinematics)
    assert arm.namespace == '/left'
    assert {one.name for one in arm.moveit_controllers} == {
        'left/ROBOT_joint_controller', 'left/ROBOT_gripper_controller'}
    assert all(joint.startswith('left_') for one in arm.moveit_controllers for joint in one.joints)
    assert arm.spawn == load_robot_settings('ROBOT').spawn


def test_planners_and_start_are_renamed_too(files):
    """Groups of planners, projections, start tolerances, gains of drives, named states."""
    files.write('more.yaml', 'trajectory_execution: '
                '{allowed_start_tolerance_joints: {joint_2: 0.2}}')
    files.replace('ompl_planning.yaml', 'projection_evaluator: joints(joint_1,joint_2)',
                  'projection_evaluator: joints(joint_1, joint_2)')
    files.write('simulation.yaml', 'initial_state: manipulator/scan_food\n'
                'initial_positions: {joint_1: 0.1}\nservo: {gains: {joint_3: {p: 5}}}')
    arm = prefixed_settings(files.load(), 'a_', 'a')
    group = arm.pipelines['ompl'].groups['a_manipulator']
    assert group.projection_evaluator == 'joints(a_joint_1,a_joint_2)'
    assert arm.trajectory_execution.allowed_start_tolerance_joints == {'a_joint_2': 0.2}
    assert arm.simulation.initial_state == 'a_manipulator/scan_food'
    assert arm.simulation.initial_positions == {'a_joint_1': 0.1}
    assert list(arm.simulation.servo.gains) == ['a_joint_3']


def test_grippers_and_broadcasters_are_renamed(files):
    """The joint of a gripper, its interfaces, joints and extra joints of a broadcaster."""
    files.write('more.yaml', """sunday:
  hand:
    type: parallel_gripper_action_controller/GripperActionController
    joint: joint_6
    max_effort_interface: joint_6/effort
  all:
    type: joint_state_broadcaster/JointStateBroadcaster
    joints: [joint_1]
    interfaces: [position]
    extra_joints: [lamp]
""")
    arm = prefixed_settings(files.load(), 'a_', 'a')
    hand, broadcaster = (arm.controller(name).parameters for name in ('hand', 'all'))
    assert (hand.joint, hand.max_effort_interface) == ('a_joint_6', 'a_joint_6/effort')
    assert broadcaster.joints == ('a_joint_1',)
    assert [joint.name for joint in broadcaster.extra_joints] == ['a_lamp']
    assert broadcaster.interfaces == ('position',)


def test_sensors_and_what_reads_them_are_renamed(files):
    """Sensors, gpios, the pace of a robot, frames of broadcasters and of admittance."""
    files.write('simulation.yaml', 'sensors: {wrist: {type: force_torque, link: link_6}}')
    files.write('more.yaml', """sunday:
  wrench:
    type: force_torque_sensor_broadcaster/ForceTorqueSensorBroadcaster
    sensor_name: wrist
    frame_id: link_6
  pose:
    type: pose_broadcaster/PoseBroadcaster
    pose_name: tool
    frame_id: base_link
  states:
    type: state_interfaces_broadcaster/StateInterfacesBroadcaster
    interfaces: [wrist/force.z, loop/joint_1/position]
  speed: {type: ur_controllers/SpeedScalingStateBroadcaster}
  lamps:
    type: gpio_controllers/GpioCommandController
    gpios: [lamp]
    command_interfaces: {lamp: {interfaces: [light]}}
  scaled:
    type: ur_controllers/ScaledJointTrajectoryController
    joints: [joint_1]
  soft:
    type: admittance_controller/AdmittanceController
    joints: [joint_1]
    command_joints: [loop/joint_1]
    ft_sensor: {name: wrist, frame: {id: link_6}}
""")
    arm = prefixed_settings(files.load(), 'a_', 'a')
    found = {one.name: one.parameters for one in arm.controllers}
    assert arm.simulation.sensors['a_wrist'].link == 'a_link_6'
    assert (found['wrench'].sensor_name, found['wrench'].frame_id) == ('a_wrist', 'a_link_6')
    assert (found['pose'].pose_name, found['pose'].frame_id) == ('a_tool', 'a_base_link')
    assert found['states'].interfaces == ('a_wrist/force.z', 'loop/a_joint_1/position')
    assert found['lamps'].targets == (('a_lamp', 'light'),)
    pace = 'a_speed_scaling/speed_scaling_factor'
    assert found['speed'].states == (pace,)
    assert found['scaled'].speed_source == pace
    assert found['soft'].command_joints == ('loop/a_joint_1',)
    assert (found['soft'].ft_sensor.name, found['soft'].ft_sensor.frame.id) == (
        'a_wrist', 'a_link_6')


def test_suction_cups_of_all_robots_are_there(merge):
    """By namespace and name, each on its robot's link; the robots' own files keep their names."""
    whole, problems = merge({'a': named('sunday', 'a'), 'b': named('sunday', 'b')},
                            simulation='vacuum_grippers: {third: {link: b_link_5}}')
    cups = {name: cup.link for name, cup in whole.simulation.vacuum_grippers.items()}
    assert cups == {'third': 'b_link_5', 'a/vacuum_gripper': 'a_link_6',
                    'b/vacuum_gripper': 'b_link_6'}
    assert not [one for one in problems if 'vacuum' in one.what]


def test_two_suction_cups_of_one_name_are_a_mistake(merge):
    """Two robots in one namespace would have the same services."""
    robots = {name: prefixed_settings(load_robot_settings('sunday'), f'{name}_', '')
              for name in 'ab'}
    _, problems = merge(robots)
    assert [one for one in problems if one.severity is Severity.ERROR
            and "two suction cups are called 'vacuum_gripper'" in one.what]


def test_the_whole_has_what_all_robots_have(merge):
    """Controllers by namespace and name, limits, solvers, joint state topics."""
    whole, problems = merge({'a': named('bot', 'a'), 'b': named('bot', 'b')})
    assert whole.controller('a/bot_joint_controller').joints[0] == 'a_joint1'
    assert whole.spawn == ('a/joint_state_controller', 'a/bot_joint_controller',
                           'b/joint_state_controller', 'b/bot_joint_controller')
    assert {'a_joint1', 'b_joint1'} <= set(whole.joint_limits.joint_limits)
    assert set(whole.kinematics) == {'a_arm', 'b_arm'}
    assert whole.planning_parameters.joint_state_topics == ('/a/joint_states', '/b/joint_states')
    assert whole.controller_manager.update_rate == 1000
    assert problems == []


def test_the_cell_wins_over_its_robots(merge):
    """One value for the whole; each value overridden by it is reported with its place."""
    whole, problems = merge(
        {'a': named('magician', 'a'), 'b': named('sunday', 'b')},
        simulation='timestep: 0.002\nservo: {gains: {a_magician_joint1: {p: 7}}}',
        limits='joint_limits: {b_joint_1: {max_velocity: 0.5}}')
    assert whole.simulation.timestep == 0.002
    assert whole.simulation.servo.gains['a_magician_joint1'].p == 7.0
    assert whole.joint_limits.joint_limits['b_joint_1'].velocity == 0.5
    assert whole.simulation.world == ''
    assert whole.controller_manager.update_rate == 500
    told = {(one.where.file.rpartition('/')[2], one.where.line): str(one) for one in problems}
    assert "simulation.timestep: 0.001 of robot 'b' is overridden by 0.002 of the cell" in told[
        'simulation.yaml', 2]
    assert "300 Hz of robot 'a' is overridden by 500 Hz" in told['ros_controllers.yaml', 8]
    assert "world 'feeding_place' of robot 'b' is not used here" in told['simulation.yaml', 4]
    assert not [one for one in problems if one.severity in (Severity.ERROR, Severity.WARNING)]


def test_the_highest_rate_that_is_given_holds_for_all(merge):
    """A robot whose files name no rate runs at that of the others."""
    whole, _ = merge({'a': named('magician', 'a'), 'b': named('elfin', 'b')})
    assert whole.controller_manager.update_rate == 300


def test_planners_of_one_name_that_differ(merge, files):
    """The second gets the name of its robot, for its own groups alone."""
    files.replace('ompl_planning.yaml', 'geometric::RRTConnect\n    range: 0.0',
                  'geometric::RRTConnect\n    range: 0.7')
    other = prefixed_settings(files.load(), 'b_', 'b')
    whole, _ = merge({'a': named('sunday', 'a'), 'b': other})
    assert whole.pipelines['ompl'].planner_configs['RRTConnect'].parameters['range'] == 0.0
    assert whole.pipelines['ompl'].planner_configs['b_RRTConnect'].parameters['range'] == 0.7
    assert 'RRTConnect' in whole.pipelines['ompl'].groups['a_manipulator'].planner_configs
    assert 'b_RRTConnect' in whole.pipelines['ompl'].groups['b_manipulator'].planner_configs
    assert whole.pipelines['ompl'].groups['b_manipulator'].default_planner_config == 'b_RRTConnect'


OMPL_FILE = ('planning_plugins: [ompl_interface/OMPLPlanner]\n'
             'planner_configs: {Mine: {type: geometric::RRT}}\n')
PILZ = 'pilz_industrial_motion_planner'


def test_the_pipelines_of_all_robots_are_offered(merge, files):
    """In the order of the robots, and those that the cell's own files describe after them."""
    files.write('fast_planning.yaml', OMPL_FILE)
    robots = {'a': prefixed_settings(files.load(), 'a_', 'a')}
    files.write('slow_planning.yaml', OMPL_FILE)
    robots['b'] = prefixed_settings(files.load(), 'b_', 'b')
    whole, problems = merge(robots, shared_planning=OMPL_FILE)
    assert whole.planning_parameters.planning_pipelines == (
        'ompl', 'fast', PILZ, 'slow', 'shared')
    assert not [one for one in problems if 'pipelines' in one.what]


def test_pipelines_that_robots_list_are_those_of_the_cell(merge, files):
    """What no robot offers is not offered."""
    files.write('more.yaml', f'planning_pipelines: [{PILZ}]')
    robot = prefixed_settings(files.load(), 'a_', 'a')
    assert merge({'a': robot})[0].planning_parameters.planning_pipelines == (PILZ,)


def test_a_cell_may_list_its_pipelines(merge):
    """Its own list is the whole list."""
    whole, _ = merge({'a': named('sunday', 'a')}, more=f'planning_pipelines: [{PILZ}]')
    assert whole.planning_parameters.planning_pipelines == (PILZ,)


def test_the_plugin_of_a_robots_pipeline_is_kept(merge, files):
    """A plugin that a file gives is preferred to the plugin that follows from the name."""
    files.write('chomp_planning.yaml', OMPL_FILE)
    robot = prefixed_settings(files.load(), 'b_', 'b')
    whole, problems = merge({'a': named('sunday', 'a'), 'b': robot})
    assert whole.pipelines['chomp'].planner is Planner.OMPL
    assert whole.pipelines['stomp'].planner is None
    assert 'chomp' in whole.planning_parameters.planning_pipelines
    assert not [one for one in problems if 'planning_plugins' in one.what]


def test_plugins_that_differ_are_reported(merge, files):
    """The first robot's plugin is used."""
    files.write('fast_planning.yaml', OMPL_FILE)
    first = prefixed_settings(files.load(), 'a_', 'a')
    files.write('fast_planning.yaml', f'planning_plugin: {PILZ}/CommandPlanner')
    second = prefixed_settings(files.load(), 'b_', 'b')
    whole, problems = merge({'a': first, 'b': second})
    assert whole.pipelines['fast'].planner is Planner.OMPL
    assert any("CommandPlanner',) of robot 'b' is overridden by" in str(one) for one in problems)


def test_a_pipeline_without_a_plugin_gets_none_in_a_cell(merge, files):
    """It cannot plan there either."""
    files.write('lost_planning.yaml', 'planning_plugins: []')
    robot = prefixed_settings(files.load(), 'a_', 'a')
    assert merge({'a': robot})[0].pipelines['lost'].planner is None


def test_default_gains_of_a_robot_stay_its_own(merge, files):
    """They go to those of its joints for which no controller gives any."""
    files.write('simulation.yaml', 'servo: {default_gains: {p: 3}, gains: {joint_1: {p: 4}}}')
    files.replace('trajectory_control.yaml',
                  'joint_6:   {p: 1000.0, i: 0.0, d: 0.1, i_clamp: 0.0}', 'joint_6: {}')
    whole, _ = merge({'a': prefixed_settings(files.load(), 'a_', 'a'), 'b': named('bot', 'b')})
    assert {joint: gains.p for joint, gains in whole.simulation.servo.gains.items()} == {
        'a_joint_1': 4.0, 'a_joint_6': 3.0}


def test_controllers_belong_to_robots(merge):
    """A controller in the cell's own folder is a mistake that names the way out."""
    _, problems = merge({'a': named('bot', 'a')}, arms='both:\n  type: '
                        'position_controllers/JointTrajectoryController\n  joints: [a_joint1]')
    (mistake,) = [one for one in problems if one.severity is Severity.ERROR]
    assert "arms.yaml:1:1: controller 'both' is in the folder of a cell" in str(mistake)
