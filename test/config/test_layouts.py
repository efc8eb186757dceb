"""The same robot written for ROS 1 and for ROS 2 gives the same values."""

import pytest
import yaml

from armsim_ros.errors import Severity

ROS2_CONTROLLERS = """
/sunday/controller_manager:
  ros__parameters:
    update_rate: 1000
    joint_state_controller:
      type: joint_state_broadcaster/JointStateBroadcaster
    arm_joint_controller:
      type: joint_trajectory_controller/JointTrajectoryController
/sunday/joint_state_controller:
  ros__parameters:
    publish_rate: 50
/sunday/arm_joint_controller:
  ros__parameters:
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
    gains:
      joint_1: {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_2: {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_3: {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_4: {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_5: {p: 1000, i: 0, d: 0.1, i_clamp: 0}
      joint_6.p: 1000
      joint_6.i: 0
      joint_6.d: 1e-1
      joint_6.i_clamp: 0
"""

MOVEIT_CONTROLLERS = """
moveit_controller_manager: moveit_simple_controller_manager/MoveItSimpleControllerManager
moveit_simple_controller_manager:
  controller_names:
    - sunday/arm_joint_controller
  sunday/arm_joint_controller:
    action_ns: follow_joint_trajectory
    type: FollowJointTrajectory
    default: true
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
trajectory_execution:
  allowed_execution_duration_scaling: 1.2
  allowed_goal_duration_margin: 0.5
  allowed_start_tolerance: 0.01
"""

ROS1_FILES = ('trajectory_control.yaml', 'joint_states.yaml', 'controllers_gazebo.yaml',
              'trajectory_execution.yaml')


def values(settings):
    """Return what must not depend on the layout."""
    dump = settings.model_dump(exclude={'files', 'remarks', 'folder'})
    for controller in dump['controllers']:
        del controller['source_type']
    dump['controllers'] = sorted(
        ({**one, 'parameters': one['parameters'].model_dump()
          if hasattr(one['parameters'], 'model_dump') else one['parameters']}
         for one in dump['controllers']), key=lambda one: one['name'])
    return dump


def test_both_layouts_give_the_same_settings(files):
    """Q1, Q3, Q6, CFG-9: controllers, their manager and move_group's controllers."""
    expected = values(files.load())
    files.remove(*ROS1_FILES)
    files.write('ros2_controllers.yaml', ROS2_CONTROLLERS)
    files.write('moveit_controllers.yaml', MOVEIT_CONTROLLERS)
    assert values(files.load()) == expected


@pytest.mark.parametrize('prefix', ['/**/', 'sunday/', '/sunday/'])
def test_names_of_nodes(files, prefix):
    """Node keys may have a namespace or '/**'."""
    files.remove(*ROS1_FILES)
    files.write('controllers.yaml', ROS2_CONTROLLERS.replace('/sunday/', prefix))
    settings = files.load()
    assert {one.name for one in settings.controllers} == {
        'joint_state_controller', 'arm_joint_controller'}
    assert settings.namespace == ('' if '*' in prefix else '/sunday')


def test_parameters_of_all_nodes_are_the_managers_too(files):
    """A file of '/**' alone gives the update rate and the controllers, as published ones do."""
    files.remove(*ROS1_FILES)
    files.write('controllers.yaml', """
/**:
  ros__parameters:
    update_rate: 500
    arm_joint_controller:
      type: joint_trajectory_controller/JointTrajectoryController
/**/arm_joint_controller:
  ros__parameters:
    joints: [joint_1, joint_2, joint_3, joint_4, joint_5, joint_6]
    command_interfaces: [position]
    state_interfaces: [position, velocity]
""")
    manager = files.load().controller_manager
    assert manager.update_rate == 500
    assert set(manager.controllers) == {'arm_joint_controller'}
    assert files.remarks() == []


def test_nested_namespace_and_node(files):
    """A namespace may be a block of its own."""
    files.remove(*ROS1_FILES)
    indented = ROS2_CONTROLLERS.replace('/sunday/', '').replace('\n', '\n  ')
    files.write('controllers.yaml', 'sunday:\n' + indented)
    assert files.load().namespace == '/sunday'


def test_kinematics_joint_limits_and_planners_in_the_layout_of_ros2(files):
    """CFG-5, CFG-6, CFG-7: the node form of the files that ROS 1 has bare."""
    expected = values(files.load())
    for name, key in (('kinematics.yaml', 'robot_description_kinematics'),
                      ('joint_limits.yaml', 'robot_description_planning'),
                      ('ompl_planning.yaml', 'ompl')):
        text = (files.folder / name).read_text()
        inner = text.replace('\n', '\n      ')
        files.write(name, f'/**:\n  ros__parameters:\n    {key}:\n      {inner}\n')
    assert values(files.load()) == expected


def test_whole_numbers_are_taken_for_real_ones(files):
    """CFG-6: integers must be accepted where the reference wants a double."""
    text = (files.folder / 'joint_limits.yaml').read_text().replace('3.14', '3')
    assert files.write('joint_limits.yaml', text).load().joint_limits.joint_limits[
        'joint_1'].velocity == 3.0


def test_slashes_in_names_as_on_the_parameter_server(files):
    """SEED-6: trajectory_execution/... is the same as the nested form."""
    files.write('trajectory_execution.yaml',
                'trajectory_execution/allowed_execution_duration_scaling: 2\n'
                'trajectory_execution/allowed_start_tolerance: 0.02\n')
    execution = files.load().trajectory_execution
    assert execution.allowed_execution_duration_scaling == 2.0
    assert execution.allowed_start_tolerance == 0.02


def test_the_settings_of_a_control_loop_of_ros1(files):
    """Q7: loop_hz is the controllers' rate, the next one that fits the physics is taken."""
    files.write('ros_controllers.yaml', """
moveit_sim_hw_interface:
  joint_model_group: controllers_initial_group_
  joint_model_group_pose: controllers_initial_pose_
generic_hw_control_loop:
  loop_hz: 300
  cycle_time_error_threshold: 0.01
hardware_interface:
  joints: [joint_1]
  sim_control_mode: 1
""")
    settings = files.load()
    assert settings.controller_manager.update_rate == 500
    assert settings.simulation.initial_state == ''
    texts = ' '.join(files.remarks())
    assert 'placeholders' in texts
    assert 'hardware_interface' in texts
    assert ('ros_controllers.yaml:6:3: controllers cannot run at 300 Hz with physics steps of '
            '0.001 s; they run at 500 Hz') in texts


def test_the_initial_pose_of_ros1(files):
    """Q7: joint_model_group_pose names the state to start in."""
    files.write('ros_controllers.yaml', 'moveit_sim_hw_interface:\n'
                '  joint_model_group: manipulator\n  joint_model_group_pose: scan_food\n')
    assert files.load().simulation.initial_state == 'manipulator/scan_food'


def test_gains_that_gazebo_reads(files):
    """O2: gazebo_ros_control/pid_gains are the gains of the servos."""
    files.write('pid.yaml', 'sunday:\n  gazebo_ros_control:\n    pid_gains:\n'
                '      joint_1: {p: 50.0, i: 1.0, d: 2}\n')
    assert files.load().simulation.servo.gains['joint_1'].d == 2.0


def test_joints_of_a_solver_have_a_block_each(files):
    """
    The list joints names them, and beside it is one block per joint; the resolution may be 0.

    moveit_kinematics/kdl_kinematics_plugin/src/kdl_kinematics_parameters.yaml;
    moveit_ros/planning/kinematics_plugin_loader/src/kinematics_parameters.yaml.
    """
    files.write('kinematics.yaml', (
        'manipulator:\n  kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin\n'
        '  kinematics_solver_search_resolution: 0.0\n'
        '  joints: [joint_1, joint_2]\n  joint_1: {weight: 2.5}\n  joint_2: {weight: 0.5}\n'))
    settings = files.load()
    solver = settings.kinematics['manipulator']
    assert solver.joints == ('joint_1', 'joint_2')
    assert {name: one.weight for name, one in solver.weights.items()} == {
        'joint_1': 2.5, 'joint_2': 0.5}
    assert solver.kinematics_solver_search_resolution == 0.0
    assert not [one for one in settings.remarks if 'kinematics' in str(one)]


#: All of pick_ik's parameters but those that have an effect here.
PICK_IK = {
    'mode': 'global', 'gd_step_size': 1e-4, 'gd_max_iters': 100, 'gd_min_cost_delta': 1e-12,
    'position_threshold': 0.001, 'orientation_threshold': 0.01, 'cost_threshold': 0.001,
    'approximate_solution_position_threshold': 0.05,
    'approximate_solution_orientation_threshold': 0.05,
    'approximate_solution_joint_threshold': 0.0, 'approximate_solution_cost_threshold': 0.0,
    'position_scale': 1.0, 'center_joints_weight': 0.0, 'avoid_joint_limits_weight': 0.0,
    'minimal_displacement_weight': 0.0, 'stop_optimization_on_valid_solution': True,
    'memetic_num_threads': 1, 'memetic_stop_on_first_solution': True,
    'memetic_population_size': 16, 'memetic_elite_size': 4, 'memetic_wipeout_fitness_tol': 1e-5,
    'memetic_max_generations': 100, 'memetic_gd_max_iters': 25, 'memetic_gd_max_time': 0.005,
}


def test_parameters_of_pick_ik(files):
    """
    A scale of 0 frees the orientation; each other key is remarked, a slip with the right name.

    pick_ik: src/pick_ik_parameters.yaml, src/pick_ik_plugin.cpp.
    """
    block = {'kinematics_solver': 'pick_ik/PickIkPlugin', 'rotation_scale': 0.0, **PICK_IK}
    files.write('kinematics.yaml', yaml.safe_dump({'manipulator': block}))
    settings = files.load()
    assert settings.kinematics['manipulator'].leaves_orientation_free
    remarks = [one for one in settings.remarks if 'pick_ik: ' in one.what]
    assert len(remarks) == len(PICK_IK)
    assert {one.severity for one in remarks} == {Severity.INFO}
    block = {'kinematics_solver': 'pick_ik/PickIkPlugin', 'memetic_elite_sise': 3}
    files.write('kinematics.yaml', yaml.safe_dump({'manipulator': block}))
    settings = files.load()
    assert not settings.kinematics['manipulator'].leaves_orientation_free
    [slip] = [one for one in settings.remarks if 'memetic_elite_sise' in str(one)]
    assert "did you mean 'memetic_elite_size'" in str(slip)
    assert slip.severity is Severity.WARNING


def test_the_scale_of_another_solver(files):
    """KDL does not read pick_ik's scale."""
    files.write('kinematics.yaml', 'manipulator: {kinematics_solver: kdl_kinematics_plugin/'
                'KDLKinematicsPlugin, rotation_scale: 0.0}')
    assert not files.load().kinematics['manipulator'].leaves_orientation_free
