# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sensors, gpios and mock hardware of ``<ros2_control>``."""

from dataclasses import replace

import pytest
from ros2_control_tags import INITIAL, joint, start

from armsim_ros.model.cell_loading import survey_cell
from armsim_ros.sim.assembly import build_managers, build_simulation


def test_sensors_and_gpios_are_listed(small_package):
    """Their states have the value that the tag gives, else 0."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        '<sensor name="hot"><state_interface name="temperature"/></sensor>' + GPIO)
    simulation, manager, _ = start(small_package)
    command, state = manager.list_hardware_interfaces()
    assert 'speed/target' in [one.name for one in command]
    assert {'hot/temperature', 'speed/factor'} <= {one.name for one in state}
    assert simulation.other_states == {
        'hot/temperature': 0.0, 'speed/factor': 1.0, 'speed/target': 0.0}


GPIO = ('<gpio name="speed"><command_interface name="target"/><state_interface name="target"/>'
        '<state_interface name="factor">' + INITIAL.format(1) + '</state_interface></gpio>')
FORWARD = ('speed_controller:\n  ros__parameters:\n'
           '    type: forward_command_controller/ForwardCommandController\n'
           '    joints: [{0}]\n    interface_name: {1}\n')


def managed(package):
    """Return simulation and manager of all controllers that the package describes."""
    survey = survey_cell(str(package.folder))
    cell = survey.checked()
    cell = replace(cell, robots=tuple(replace(one, settings=one.settings.model_copy(
        update={'spawn_only': False})) for one in cell.robots))
    simulation = build_simulation(cell.settings, cell.model)
    (manager,) = build_managers(cell, simulation).values()
    return simulation, manager


def forwarding(package, interface, owner='speed'):
    """Return the same with a forward controller, of a gpio or joint, that has had 0.5."""
    package.write('config/ros2_controllers.yaml', package.ROS2 + FORWARD.format(owner, interface))
    simulation, manager = managed(package)
    assert manager.switch(activate=['speed_controller']).ok
    manager.controllers['speed_controller'].receive([0.5])
    manager.update(simulation.time_ns, 0.002)
    return simulation, manager


def test_the_state_of_a_gpio_mirrors_its_command(small_package):
    """A forward controller commands it; the state of the same name follows, others stay."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), GPIO)
    simulation, manager = forwarding(small_package, 'target')
    assert simulation.other_states == {'speed/factor': 1.0, 'speed/target': 0.5}
    claimed = {one.name for one in manager.list_hardware_interfaces()[0] if one.is_claimed}
    assert 'speed/target' in claimed
    manager.update(simulation.time_ns + 10**8, 0.002)
    broadcaster = manager.controllers['joint_state_broadcaster']
    sample = [broadcaster.poll(), broadcaster.poll()][-1]
    assert ('speed', ('target', 'factor'), (0.5, 1.0)) in sample.dynamic


FURTHER = joint(
    'grip', 'position', 'set_gripper_max_effort', inside='<state_interface name="temperature">'
    + INITIAL.format(25) + '</state_interface><state_interface name="set_gripper_max_effort"/>')


def test_further_interfaces_of_a_joint_are_like_those_of_a_gpio(small_package):
    """
    A state mirrors the command of its name, others have their initial value; no drive follows.

    generic_system.cpp: GenericSystem::read, the loopback on all other interfaces.
    """
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), FURTHER)
    simulation, manager = forwarding(small_package, 'set_gripper_max_effort', 'grip')
    assert simulation.other_states == {
        'grip/set_gripper_max_effort': 0.5, 'grip/temperature': 25.0}
    commands, states = manager.list_hardware_interfaces()
    assert [one.name for one in commands if one.name.startswith('grip/')] == [
        'grip/position', 'grip/set_gripper_max_effort']
    assert 'grip/temperature' in [one.name for one in states]
    sample = manager.controllers['joint_state_broadcaster'].read(0)
    (found,) = (entry for entry in sample.dynamic if entry[0] == 'grip')
    assert found[1][2:] == ('temperature', 'set_gripper_max_effort')
    assert found[2][2:] == (25.0, 0.5)


def test_a_gripper_whose_bound_is_a_further_interface(small_package):
    """It can be activated, and moves (parallel_gripper_action_controller_impl.hpp)."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), FURTHER)
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2 + (
        'speed_controller:\n  ros__parameters:\n'
        '    type: parallel_gripper_action_controller/GripperActionController\n    joint: grip\n'
        '    max_effort_interface: grip/set_gripper_max_effort\n'))
    simulation, manager = managed(small_package)
    result = manager.switch(activate=['speed_controller'])
    assert result.ok, result.message
    assert manager.controllers['speed_controller'].send_goal([0.2], [], [30.0]).accepted
    for _ in range(1000):
        manager.update(simulation.time_ns, 0.002)
        simulation.write(1)
        simulation.step()
    assert simulation.state.position[simulation.index['grip']] == pytest.approx(0.2, abs=0.01)


def test_a_simulators_joint_has_no_further_interfaces(small_package):
    """Re-enacts gz_system.cpp: initSim registers position, velocity and effort alone."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), FURTHER,
                               plugin='gz_ros2_control/GazeboSimSystem')
    simulation, manager, _ = start(small_package)
    assert not simulation.other_states
    assert 'grip/set_gripper_max_effort' not in [
        one.name for one in manager.list_hardware_interfaces()[0]]


def test_a_gpio_of_inactive_hardware_keeps_its_command(small_package):
    """A command reaches a gpio only while its hardware is active (system.cpp, System::write)."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), GPIO)
    simulation, manager = forwarding(small_package, 'target')
    (name,) = (one.name for one in manager.list_hardware_components())
    controller = manager.controllers['speed_controller']
    manager.set_hardware_component_state(name, 'inactive')
    assert controller.receive([0.9]) == ''
    manager.update(simulation.time_ns + 10**8, 0.002)
    assert simulation.other_states['speed/target'] == 0.5
    manager.set_hardware_component_state(name, 'active')
    manager.update(simulation.time_ns + 2 * 10**8, 0.002)
    assert simulation.other_states['speed/target'] == 0.9


def test_mock_hardware_lets_states_of_gpios_be_commanded(small_package):
    """mock_gpio_commands makes a command interface of each state."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'), GPIO,
        '<hardware><param name="x"/></hardware>', plugin='mock_components/GenericSystem</plugin>'
        '<param name="mock_gpio_commands">true</param><plugin>')
    simulation, _ = forwarding(small_package, 'factor')
    assert simulation.other_states == {'speed/factor': 0.5, 'speed/target': 0.0}


WRIST = ('<sensor name="wrist">' + ''.join(
    f'<state_interface name="{one}.{axis}"/>' for one in
    ('force', 'torque', 'linear_acceleration', 'angular_velocity') for axis in 'xyz')
    + '<state_interface name="orientation.w"/>{0}</sensor>')
#: A frame on the last link; nothing hangs on it.
TIP = ('<link name="tip"/><joint name="tip_joint" type="fixed"><parent link="finger"/>'
       '<child link="tip"/><origin xyz="0 0 0.1"/></joint>')

TOOL = ('<link name="tool"><inertial><mass value="0.5"/><inertia ixx="0.01" ixy="0" ixz="0" '
        'iyy="0.01" iyz="0" izz="0.01"/></inertial></link><joint name="tool_joint" type="fixed">'
        '<parent link="tip"/><child link="tool"/></joint>')


@pytest.mark.parametrize(('inside', 'more', 'weight'), [
    ('<param name="frame_id">finger</param>', '', 9.81),
    ('', '<gazebo reference="elbow"><sensor name="wrist" type="force_torque"/></gazebo>', 19.62),
    ('', '', 9.81),
    ('<param name="frame_id">tip</param>', TIP, 9.81),
    ('<param name="frame_id">tip</param>', TIP + TOOL, 4.905),
])
def test_a_sensor_measures_what_hangs_beyond_its_frame(small_package, inside, more, weight):
    """
    Its frame is the tag's, else Gazebo's, else the end of the arm.

    On a frame without mass it measures what hangs beyond the link that carries the frame.
    """
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'), joint('grip', 'position'),
        WRIST.format(inside), more=more)
    simulation, _, _ = start(small_package)
    for _ in range(500):
        simulation.write(1)
        simulation.step()
    measured = simulation.other_states
    assert measured['wrist/force.z'] == pytest.approx(-weight, abs=0.05)
    assert measured['wrist/linear_acceleration.z'] == pytest.approx(9.81, abs=0.05)
    assert measured['wrist/orientation.w'] == pytest.approx(1.0, abs=1e-3)


IMU = ('<sensor name="{0}">{1}' + ''.join(
    f'<state_interface name="{what}.{axis}"/>' for what, axes in (
        ('orientation', 'xyzw'), ('angular_velocity', 'xyz'), ('linear_acceleration', 'xyz'))
    for axis in axes) + '</sensor>')


@pytest.mark.parametrize('pose', [
    '<pose>0 0.05 0.1 0.3 0 0.7</pose>',
    '<pose degrees="true">0 0.05 0.1 17.188733854 0 40.107045659</pose>',
])
def test_an_imu_measures_where_gazebo_mounts_it(small_package, pose):
    """In motion it has the values of an IMU on a link there (gz-sim's Imu.cc, Update)."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'), joint('grip', 'position'),
        IMU.format('mounted', ''), IMU.format('fixed', '<param name="frame_id">tip</param>'),
        more=TIP.replace('"0 0 0.1"', '"0 0.05 0.1" rpy="0.3 0 0.7"')
        + f'<gazebo reference="finger"><sensor name="mounted">{pose}</sensor></gazebo>')
    simulation, _, _ = start(small_package)
    simulation.apply_wrench('finger', (50.0, 20.0, 0.0))
    for _ in range(20):
        simulation.write(1)
        simulation.step()
    measured = simulation.other_states
    names = [name.partition('/')[2] for name in measured if name.startswith('fixed/')]
    assert abs(measured['fixed/angular_velocity.y']) > 0.1
    for name in names:
        assert measured[f'mounted/{name}'] == pytest.approx(measured[f'fixed/{name}'], abs=1e-6)


@pytest.mark.parametrize('pose', [
    '<pose>0 0 0.1</pose>', '<pose>a b c d e f</pose>',
    '<pose relative_to="base">0 0 0 0 0 1</pose>',
    '<pose rotation_format="quat_xyzw">0 0 0.1 0 0 0 1</pose>',
])
def test_a_pose_of_an_imu_that_is_not_read_is_told(small_package, pose):
    """The line names the sensor; it measures at the origin of its link."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'), IMU.format('mounted', ''),
        more=f'<gazebo reference="finger"><sensor name="mounted">{pose}</sensor></gazebo>')
    simulation, _, problems = start(small_package)
    assert "sensor 'mounted' measures at the origin of 'finger'" in ' '.join(
        problem.what for problem in problems)
    simulation.step()
    assert simulation.other_states['mounted/orientation.w'] == pytest.approx(1.0)


def test_a_sensor_feels_a_push(small_package):
    """A force on the link beyond, and its torque about the frame."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'), joint('grip', 'position'),
        WRIST.format('<param name="frame_id">lower</param>'))
    simulation, _, _ = start(small_package)
    before = None
    for force in (0.0, 5.0):
        simulation.apply_wrench('finger', (0, force, 0))
        for _ in range(1500):
            simulation.write(1)
            simulation.step()
        if before is None:
            before = simulation.other_states
    after = simulation.other_states
    change = {name: after[name] - before[name] for name in after}
    assert change['wrist/force.y'] == pytest.approx(5.0, abs=0.02)
    assert change['wrist/torque.x'] == pytest.approx(-1.0, abs=0.02)


def mocked(parameter):
    """Return the plugin of mock hardware with a parameter."""
    name, value = parameter
    return f'mock_components/GenericSystem</plugin><param name="{name}">{value}</param><plugin>'


@pytest.mark.parametrize(('parameter', 'reached'), [
    (('disable_commands', 'true'), 0.0),
    (('position_state_following_offset', '0.1'), 0.4),
    (('state_following_offset', '-0.1'), 0.2),
    (('calculate_dynamics', 'true'), 0.3),
])
def test_parameters_of_mock_hardware(small_package, parameter, reached):
    """They act as there: on what becomes of a command of 0.3 rad."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'),
                               plugin=mocked(parameter))
    simulation, _, _ = start(small_package)
    shoulder = simulation.index['shoulder']
    for step in range(1000):
        simulation.command.position[shoulder] = 0.3 * min(1.0, step / 500)
        simulation.write(1)
        simulation.step()
    assert simulation.state.position[shoulder] == pytest.approx(reached, abs=2e-3)


def test_parameters_of_mock_hardware_mean_nothing_to_others(small_package):
    """A vendor's plugin has parameters of its own."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        plugin=mocked(('disable_commands', 'true')).replace('mock_components', 'vendor'))
    assert not start(small_package)[0].model.hardware[0].deaf


def test_mock_hardware_lets_states_of_sensors_be_commanded(small_package):
    """
    mock_sensor_commands makes a command interface of each state; without it there is none.

    Upstream: test_generic_system.cpp, generic_system_2dof_sensor_mock_command and its _True.
    """
    sensor = ('<sensor name="tcp"><state_interface name="fx"/>'
              '<state_interface name="fy">' + INITIAL.format(0.5) + '</state_interface></sensor>')
    for text, commands in (('True', {'tcp/fx', 'tcp/fy'}), ('false', set())):
        small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'),
                                   sensor, plugin=mocked(('mock_sensor_commands', text)))
        simulation, manager, _ = start(small_package)
        found = {one.name for one in manager.list_hardware_interfaces()[0]}
        assert {name for name in found if name.startswith('tcp')} == commands
        assert simulation.other_states == {'tcp/fx': 0.0, 'tcp/fy': 0.5}


@pytest.mark.parametrize(('text', 'value'), [('true', 1.0), ('False', 0.0)])
def test_initial_value_of_a_switch(small_package, text, value):
    """
    An interface of the type bool is 1 or 0.

    Upstream: test_generic_system.cpp, valid_urdf_ros2_control_system_robot_with_gpio_bool_....
    """
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        '<gpio name="pump"><state_interface name="on" data_type="bool">'
        + INITIAL.format(text) + '</state_interface></gpio>')
    simulation, _, problems = start(small_package)
    assert simulation.other_states == {'pump/on': value}
    assert not [one for one in problems if 'initial_value' in one.what]
