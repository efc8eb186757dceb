"""A folder of files becomes one RobotSettings, or the list of all its mistakes."""

from pydantic import ValidationError
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.config.ompl_planning import Planner
from armsim_ros.errors import ConfigError
from armsim_ros.resources import robot_names


def test_the_sunday_robot():
    """The files of the sunday robot give its controllers, limits, planners and solver."""
    settings = load_robot_settings('sunday')
    assert settings.namespace == '/sunday'
    assert settings.spawn == ('joint_state_controller', 'arm_joint_controller')
    arm = settings.controller('arm_joint_controller')
    assert arm.type == 'joint_trajectory_controller/JointTrajectoryController'
    assert arm.source_type == 'position_controllers/JointTrajectoryController'
    assert arm.joints == tuple(f'joint_{n}' for n in range(1, 7))
    assert arm.parameters.command_interfaces == ('position',)
    assert arm.parameters.gains['joint_6'].p == 1000.0
    assert settings.controller('joint_state_controller').parameters.publish_rate == 50.0
    assert settings.moveit_controllers[0].action_name == (
        'sunday/arm_joint_controller/follow_joint_trajectory')
    assert settings.kinematics['manipulator'].kinematics_solver_timeout == 0.005
    assert settings.pipelines['ompl'].groups['manipulator'].longest_valid_segment_fraction == 0.005
    assert settings.pipelines['ompl'].planner_configs['RRTConnect'].type == 'geometric::RRTConnect'
    assert settings.trajectory_execution.allowed_execution_duration_scaling == 1.2
    assert settings.joint_limits.joint_limits['joint_3'].velocity == 3.14
    assert settings.joint_limits.joint_limits['joint_3'].acceleration == 5.0
    assert {'table', 'cube', 'star', 'triangle', 'picture'} == set(settings.world.objects)
    assert settings.controller_manager.update_rate == 1000


def test_settings_are_frozen():
    """Nothing changes after it was read."""
    with pytest.raises(ValidationError):
        load_robot_settings('sunday').namespace = '/other'


def test_values_are_located(files):
    """A cross check can point at the line of a value."""
    settings = files.load()
    where = settings.locate('controllers', 'arm_joint_controller', 'joints', 2)
    assert str(where) == f'{files.folder}/trajectory_control.yaml:7:9'
    assert settings.locate('controllers', 'arm_joint_controller', 'verbose') is None


def test_a_namespace_may_be_chosen():
    """The argument wins over the files; '' is the root."""
    assert load_robot_settings('sunday', namespace='/left/arm').namespace == '/left/arm'
    assert load_robot_settings('sunday', namespace='').namespace == ''


def test_named_controllers_replace_those_of_the_folder(files, tmp_path):
    """Files of controllers that the user names replace all controllers of the folder's files."""
    other = tmp_path / 'elsewhere.yaml'
    other.write_text('left_arm_controller:\n'
                     '  type: position_controllers/JointTrajectoryController\n'
                     '  joints: [joint_1]\n')
    settings = files.load(controllers=(other,))
    assert [controller.name for controller in settings.controllers] == ['left_arm_controller']
    assert settings.kinematics == files.load().kinematics


def test_controllers_without_a_namespace(files):
    """A controller at the left margin stands in the root namespace."""
    files.write('trajectory_control.yaml', 'group_controller:\n'
                '  type: position_controllers/JointTrajectoryController\n  joints: [joint_1]\n'
                '  constraints: {goal_time: 0.6, joint_1: {trajectory: 0.1, goal: 0.1}}\n')
    files.write('joint_states.yaml', 'joint_state_controller:\n'
                '  type: joint_state_controller/JointStateController\n  publish_rate: 50\n')
    settings = files.load()
    assert settings.namespace == ''
    assert settings.controller('group_controller').parameters.constraints.goal_time == 0.6


def test_all_mistakes_of_all_files_at_once(files):
    """One run names every mistake, each with file and line."""
    files.replace('trajectory_control.yaml', 'joint_6:   {p: 1000.0', 'joint_6:   {p: much')
    files.replace('joint_states.yaml', 'publish_rate', 'publish_rat')
    files.write('kinematics.yaml', 'manipulator:\n  kinematics_solver_timeout: -1\n')
    files.write('joint_limits.yaml', 'joint_limits:\n\tjoint_1: {}\n')
    assert files.complaints() == [
        'joint_limits.yaml:2:1: the line is indented with a tab; allowed: spaces only; replace '
        'each tab by spaces',
        "joint_states.yaml:5:5: controller 'joint_state_controller': key 'publish_rat' is not "
        "known; did you mean 'publish_rate'?",
        "trajectory_control.yaml:19:22: controller 'arm_joint_controller': 'gains.joint_6.p' is "
        "the text 'much'; allowed: a number",
        "kinematics.yaml:2:30: kinematics of group 'manipulator': 'kinematics_solver_timeout' is "
        'the number -1; allowed: greater than 0',
    ]


BROKEN = [
    ('trajectory_control.yaml', '"position_controllers/JointTrajectoryController"',
     'position_controllers/JointTrajectoryControler',
     "trajectory_control.yaml:3:11: controller 'arm_joint_controller': type "
     "'position_controllers/JointTrajectoryControler' is not known"),
    ('trajectory_control.yaml', '    type: "position_controllers/JointTrajectoryController"\n', '',
     "trajectory_control.yaml:2:3: controller 'arm_joint_controller' has no type"),
    ('trajectory_control.yaml', 'joint_6:   {p: 1000.0', 'joint_7:   {p: 1000.0',
     "trajectory_control.yaml:19:7: controller 'arm_joint_controller': gains: 'joint_7' is not "
     "among the controller's joints"),
    ('trajectory_control.yaml', 'joint_6:   {p: 1000.0', 'joint_6:   {i_clmp: 1000.0',
     "trajectory_control.yaml:19:19: controller 'arm_joint_controller': key "
     "'gains.joint_6.i_clmp' is not known; did you mean 'i_clamp'?"),
    ('trajectory_control.yaml', 'joint_6:   {p: 1000.0', 'joint_6:   {p: .nan',
     "trajectory_control.yaml:19:22: controller 'arm_joint_controller': '.nan' is not a number"),
    ('trajectory_control.yaml', '      - joint_6\n', '      - joint_5\n',
     "trajectory_control.yaml:4:5: controller 'arm_joint_controller': joints: named twice: "
     'joint_5'),
    ('trajectory_control.yaml', 'gains:\n', 'gain:\n',
     "trajectory_control.yaml:13:5: controller 'arm_joint_controller': key 'gain' is not known; "
     "did you mean 'gains'?"),
    ('controllers_gazebo.yaml', 'type: FollowJointTrajectory', 'type: FollowTrajectory',
     "controllers_gazebo.yaml:5:11: MoveIt controller 'sunday/arm_joint_controller': 'type' is "
     "the text 'FollowTrajectory'; allowed: 'FollowJointTrajectory', 'GripperCommand'"),
    ('controllers_gazebo.yaml', 'controller_list:', 'controler_list:',
     "controllers_gazebo.yaml:2:1: key 'controler_list' is not known in this file; did you mean "
     "'controller_list'?"),
    ('controllers_gazebo.yaml', '  - name: sunday/arm_joint_controller\n', '  - nam: x\n',
     "controllers_gazebo.yaml:3:5: an item of 'controller_list' has no name"),
    ('joint_limits.yaml', '  joint_6:\n    has_velocity_limits: true\n    max_velocity: 3.14\n',
     '  joint_6:\n    has_velocity_limits: true\n    max_velocity: 0\n',
     "joint_limits.yaml:31:5: joint limits: joint_limits.joint_6: 'max_velocity' is 0"),
    ('simulation.yaml', 'timestep: 0.001', 'timestep: 1',
     "simulation.yaml:2:11: simulation: 'timestep' is the number 1; allowed: less than or equal"),
    ('simulation.yaml', 'world: feeding_place', 'world: feeding_plac',
     "simulation.yaml:4:1: world 'feeding_plac' is not found (included: "),
]


@pytest.mark.parametrize(('name', 'old', 'new', 'message'), BROKEN)
def test_one_mistake_one_message(files, name, old, new, message):
    """A mistake in a file gives one message with file and line."""
    files.replace(name, old, new)
    found = files.complaints()
    assert len(found) == 1
    assert message in found[0]


def test_an_unknown_type_lists_those_that_are_allowed(files):
    """The message about a controller's type names all types."""
    files.replace('trajectory_control.yaml', '"position_controllers/JointTrajectoryController"',
                  'my_controllers/Best')
    message = files.complaints()[0]
    assert 'joint_trajectory_controller/JointTrajectoryController' in message
    assert 'position_controllers/JointTrajectoryController' in message


def test_lost_indentation_is_explained(files):
    """Q8, SEED-3: a controller whose keys stand beside its name."""
    files.write('trajectory_control.yaml', 'group_controller:\n'
                'type: position_controllers/JointTrajectoryController\njoints:\n- joint_1\n')
    assert files.complaints() == [
        "trajectory_control.yaml:2:1: 'type', 'joints' are beside 'group_controller', which is "
        'empty; indent them below their controller; the indentation was probably lost in copying']


def test_two_namespaces_are_too_many(files):
    """Controllers of one robot stand in one namespace, or one is chosen."""
    files.replace('joint_states.yaml', 'sunday:', 'sundy:')
    found = files.complaints()
    assert len(found) == 1
    assert "the controllers are in 2 namespaces: '" in found[0]
    assert files.load(namespace='sunday').namespace == '/sunday'


def test_the_same_key_with_two_values(files):
    """Two files that say different things of one controller are a mistake, equal ones none."""
    files.write('more.yaml', (files.folder / 'joint_states.yaml').read_text())
    files.load()
    files.replace('more.yaml', 'publish_rate: 50', 'publish_rate: 25')
    assert files.complaints() == [
        "more.yaml:5:5: controllers: 'joint_state_controller.publish_rate' has another value "
        f'here than in {files.folder}/joint_states.yaml:5:5'.replace(f'{files.folder}/', '')
        + '; remove one of the two']


def test_overrides_win_over_files(files):
    """A command line may set any value; texts are read as YAML."""
    settings = files.load(overrides={
        'simulation.paused': True, 'trajectory_execution.allowed_start_tolerance': '0.05',
        'controllers.arm_joint_controller.constraints.goal_time': 2})
    assert settings.simulation.paused is True
    assert settings.trajectory_execution.allowed_start_tolerance == 0.05
    assert settings.controller('arm_joint_controller').parameters.constraints.goal_time == 2.0


@pytest.mark.parametrize('path', ['ompl.planning_seed', 'pipelines.ompl.planning_seed'])
def test_overrides_of_ompl(files, path):
    """Its settings have the name that its parameters have, or are those of any pipeline."""
    assert files.load(overrides={path: 7}).pipelines['ompl'].planning_seed == 7


@pytest.mark.parametrize(('path', 'value', 'message'), [
    ('simulaton.paused', True, "override 'simulaton.paused': 'simulaton' is not a block"),
    ('simulation.pausd', True, "override 'simulation.pausd': simulation: key 'pausd' is not"),
    ('simulation.timestep', 'fast', "override 'simulation.timestep': simulation: 'timestep' is "),
])
def test_a_wrong_override(files, path, value, message):
    """A mistake on the command line is told as one in a file is."""
    assert message in files.complaints(overrides={path: value})[0]


def test_a_spawned_controller_that_nothing_describes(files):
    """P13: it is told of, the others start."""
    files.write('simulation.yaml', 'spawn: [joint_state_controller, arm_joint_controller, '
                'gripper_controller]\n')
    settings = files.load()
    assert settings.spawn == ('joint_state_controller', 'arm_joint_controller')
    assert any("controller 'gripper_controller' is to be spawned, but no file describes it" in
               str(one) for one in settings.remarks)


def test_controllers_that_share_joints_start_one_by_one(files):
    """P4: two controllers of the same joints cannot both be active."""
    files.write('velocity.yaml', 'sunday:\n  arm_velocity_controller:\n'
                '    type: velocity_controllers/JointTrajectoryController\n'
                '    joints: [joint_1]\n')
    settings = files.load()
    assert settings.spawn == ('joint_state_controller', 'arm_joint_controller')
    assert settings.controller('arm_velocity_controller').parameters.command_interfaces == (
        'velocity',)


def test_files_of_other_programs_are_left_out(files):
    """CFG-12: moveit_cpp.yaml and the like give a remark each."""
    files.write('moveit_cpp.yaml', 'planning_pipelines: {}\n')
    assert any('moveit_cpp' in one and 'not used here' in one for one in files.remarks())


@pytest.mark.parametrize(('name', 'content'), [
    ('chomp', 'planning_time_limit: 10.0\n'),
    ('stomp', 'stomp_moveit: {num_timesteps: 60}\n'),
])
def test_a_pipeline_whose_planner_is_not_available_is_left_out(files, name, content):
    """CFG-12: chomp_planning.yaml and the like give a remark each."""
    files.write(f'{name}_planning.yaml', content)
    (remark,) = [one for one in files.remarks() if f'{name}_planning.yaml' in one]
    assert f"planning pipeline '{name}' is not offered" in remark
    assert name not in files.load().planning_parameters.planning_pipelines


@pytest.mark.parametrize('name', ['chomp', 'stomp', 'pilz_industrial_motion_planner'])
def test_the_plugin_not_the_name_of_a_file_is_its_planner(files, name):
    """As in a MoveIt configuration package."""
    files.write(f'{name}_planning.yaml', 'planning_plugins: [ompl_interface/OMPLPlanner]\n')
    settings = files.load()
    assert settings.pipelines[name].planner is Planner.OMPL
    assert name in settings.planning_parameters.planning_pipelines


def test_a_robot_that_is_not_there():
    """The robots that there are, are named."""
    with pytest.raises(ConfigError, match=r"robot 'sundy' is not found .*did you mean 'sunday'"):
        load_robot_settings('sundy')


def test_a_folder_without_a_urdf(tmp_path):
    """The message says which file to add."""
    with pytest.raises(ConfigError, match=r'no URDF of robot .* name the file with urdf:=FILE'):
        load_robot_settings(str(tmp_path))


def test_several_urdf_files(files):
    """Which one is meant, the name says, or the argument."""
    files.write('other.urdf', '<robot/>')
    assert files.load().urdf_file.name == 'sunday.urdf.xacro'
    (files.folder / 'sunday.urdf.xacro').rename(files.folder / 'another.urdf.xacro')
    assert 'several URDF files and none is called sunday.urdf' in files.complaints()[0]
    assert files.load(urdf=files.folder / 'other.urdf').urdf_file == files.folder / 'other.urdf'


def test_a_world_file_beside_the_others(files):
    """The world may be a file of the folder; its mistakes have their line."""
    files.write('room.world.yaml', 'objects:\n  box:\n    parts: []\n')
    files.replace('simulation.yaml', 'world: feeding_place', 'world: room.world.yaml')
    assert 'room.world.yaml:3:12: world: ' in files.complaints()[0]


def test_every_folder_under_config_loads():
    """What the package brings is free of mistakes and warnings."""
    assert 'sunday' in robot_names()
    for name in robot_names():
        load_robot_settings(name)


def test_hidden_files_are_none_of_a_robot(files):
    """What an editor leaves beside a file is not read."""
    files.write('.joint_limits.yaml', 'joint_limits: [')
    assert files.load().joint_limits
