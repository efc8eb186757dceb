# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What ``<ros2_control>`` declares is what controllers find; each convention has one test."""

import pytest
from ros2_control_tags import INITIAL, joint, mistakes, said, start, STATES

from armsim_ros.errors import Severity
from armsim_ros.model.cell_loading import survey_cell
from armsim_ros.model.description.ros2_control import plugin_parameters
from armsim_ros.sim.control_loop import ControlLoop


def test_each_tag_is_a_component(small_package):
    """Name, type and plugin as written, active; any plugin is simulated, and a line says so."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        more='<ros2_control name="Hand" type="actuator"><hardware><plugin>other/Gripper</plugin>'
             '</hardware>' + joint('grip', 'position') + '</ros2_control>')
    _, manager, problems = start(small_package)
    found = [(one.name, one.type, one.plugin_name, one.state)
             for one in manager.list_hardware_components()]
    assert found == [('Arm', 'system', 'vendor/Hardware', 'active'),
                     ('Hand', 'actuator', 'other/Gripper', 'active')]
    assert sum('is simulated' in text for text in said(problems, Severity.CHANGED)) == 2
    hand = manager.list_hardware_components()[1]
    assert [one.name for one in hand.command_interfaces] == ['grip/position']


def test_without_a_tag_every_joint_has_all_interfaces(small_package):
    """A robot that declares nothing is one component."""
    _, manager, _ = start(small_package)
    (component,) = manager.list_hardware_components()
    assert len(component.command_interfaces) == 12


def test_only_what_is_declared_can_be_claimed(small_package):
    """Asking for another interface fails the activation with the list; the rest starts."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'velocity'))
    _, manager, _ = start(small_package)
    command, state = manager.list_hardware_interfaces()
    assert [one.name for one in command] == ['shoulder/position', 'elbow/velocity']
    assert [one.name for one in state] == [
        'shoulder/position', 'shoulder/velocity', 'elbow/position', 'elbow/velocity']
    assert manager.controllers['arm_controller'].state.value == 'inactive'
    assert manager.controllers['joint_state_broadcaster'].active
    assert "which does not exist; 'elbow' has: elbow/velocity" in manager.refusals[0]


def test_a_joint_in_no_tag_is_held_and_not_listed(small_package):
    """Nobody can read or claim it."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'))
    simulation, manager, _ = start(small_package)
    manager.switch(activate=['joint_state_broadcaster'])
    assert 'grip' not in manager.controllers['joint_state_broadcaster'].read(0).names
    for _ in range(200):
        simulation.write(1)
        simulation.step()
    assert simulation.state.position[simulation.index['grip']] == pytest.approx(0.0, abs=1e-3)


def test_a_planning_group_with_a_joint_in_no_tag_is_told(small_package):
    """Nobody would know where it is."""
    small_package.ros2_control(joint('shoulder', 'position'))
    _, _, problems = start(small_package)
    assert any("planning group 'arm' has elbow, which no <ros2_control> has" in text
               for text in said(problems))


def test_the_start_is_the_initial_value(small_package):
    """The state's before the command's, else 0; beyond the limits it is moved, with a warning."""
    commanded = f'<command_interface name="position">{INITIAL.format(0.02)}</command_interface>'
    small_package.ros2_control(
        joint('shoulder', inside=commanded, states=STATES.format(INITIAL.format(0.5))),
        joint('elbow', 'position', states=STATES.format(INITIAL.format(9))),
        joint('grip', inside=commanded))
    simulation, _, problems = start(small_package)
    positions = dict(zip(simulation.joint_names, simulation.state.position, strict=True))
    assert positions == pytest.approx({'shoulder': 0.5, 'elbow': 2.0, 'grip': 0.02})
    assert any("joint 'elbow' starts at 2: 9 is outside" in text for text in said(problems))


def test_the_packages_start_acts_where_no_tag_uses_it(small_package):
    """A tag's value wins over initial_positions.yaml, the user's word over both."""
    small_package.write('config/initial_positions.yaml',
                        'initial_positions: {shoulder: 0.3, elbow: 0.4, grip: 0.1}\n')
    small_package.ros2_control(
        joint('shoulder', 'position', states=STATES.format(INITIAL.format(0.5))),
        joint('elbow', 'position'))
    simulation, _, _ = start(small_package, overrides={'simulation.initial_positions.grip': 0.2})
    positions = dict(zip(simulation.joint_names, simulation.state.position, strict=True))
    assert positions == pytest.approx({'shoulder': 0.5, 'elbow': 0.4, 'grip': 0.2})


@pytest.mark.parametrize(('inside', 'words', 'expected'), [
    ('<command_interface name="position"><param name="min">-0.5</param>'
     '<param name="max">9</param></command_interface>', '', (-0.5, 2.0)),
    ('<command_interface name="position"><param name="min">-0.5</param>'
     '<limits enable="false"/></command_interface>', '', (-9.0, 9.0)),
    ('<command_interface name="position"/><limits enable="false"/>', '', (-9.0, 9.0)),
])
def test_limits_of_the_tag(small_package, inside, words, expected):
    """
    They narrow the URDF's and never widen them, and can be switched off.

    component_parser.cpp, update_interface_limits.
    """
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2.replace(
        'update_rate: 500\n', 'update_rate: 500\n    enforce_command_limits: true\n'))
    small_package.ros2_control(joint('shoulder', inside=inside, words=words),
                               joint('elbow', 'position'))
    simulation, manager, _ = start(small_package)
    position = simulation.command.position
    for value, limit in zip((-9.0, 9.0), expected, strict=True):
        position[simulation.index['shoulder']] = value
        manager.resources.limits.enforce(100.0)
        assert position[simulation.index['shoulder']] == limit


def test_commands_are_not_clamped_by_default(small_package):
    """As in Jazzy."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'))
    _, manager, _ = start(small_package)
    assert manager.resources.limits is None


MIMIC = '<mimic joint="elbow" multiplier="1"/></joint>'


@pytest.fixture
def following(small_package):
    """Return the package with a gripper that follows the elbow."""
    text = (small_package.description / 'urdf/arm.urdf').read_text()
    head, sign, rest = text.partition('<joint name="grip"')
    small_package.write('../description_folder/urdf/arm.urdf',
                        head + sign + rest.replace('</joint>', MIMIC, 1))
    return small_package


def test_a_joint_that_follows_has_no_command_interface(following):
    """One that is declared is dropped with a warning; --strict refuses it."""
    following.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'),
                           joint('grip', 'position'))
    _, manager, problems = start(following)
    assert 'grip/position' not in [one.name for one in manager.list_hardware_interfaces()[0]]
    assert any("joint 'grip' follows another joint" in text for text in said(problems))


def test_a_joint_that_follows_can_be_freed(following):
    """mimic='false' gives it a command interface of its own."""
    following.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'),
                           joint('grip', 'position', words='mimic="false"'))
    _, manager, _ = start(following)
    assert 'grip/position' in [one.name for one in manager.list_hardware_interfaces()[0]]


def test_mimic_without_a_mimic_of_the_urdf_warns(small_package):
    """The URDF decides who follows whom."""
    small_package.ros2_control(joint('shoulder', 'position', words='mimic="true"'),
                               joint('elbow', 'position'))
    _, _, problems = start(small_package)
    assert any('no <mimic> in the URDF' in text for text in said(problems))


@pytest.mark.parametrize(('joints', 'message'), [
    ([joint('shouldr', 'position')], "a joint 'shouldr', which is not in the URDF"),
    ([joint('plate', 'position')], "the joint 'plate', which is fixed"),
])
def test_a_joint_that_cannot_be_driven_is_a_mistake(small_package, joints, message):
    """The message names the tag's joint."""
    text = (small_package.description / 'urdf/arm.urdf').read_text()
    small_package.write('../description_folder/urdf/arm.urdf', text.replace(
        '</robot>', '<link name="flange"/><joint name="plate" type="fixed"><parent link="lower"/>'
        '<child link="flange"/></joint></robot>'))
    small_package.ros2_control(*joints)
    assert any(message in text for text in mistakes(small_package))


MOCK, GAZEBO = 'mock_components/GenericSystem', 'gz_ros2_control/GazeboSimSystem'


@pytest.mark.parametrize(('first', 'second', 'kept'), [
    (GAZEBO, MOCK, GAZEBO), (MOCK, GAZEBO, GAZEBO), ('vendor/Hardware', MOCK, 'vendor/Hardware'),
    (MOCK, 'vendor/Hardware', 'vendor/Hardware'), ('vendor/Hardware', GAZEBO, GAZEBO),
    (MOCK, 'fake_components/GenericSystem', MOCK)])
def test_of_two_tags_for_the_same_joints_one_counts(small_package, first, second, kept):
    """A simulator's plugin comes before a vendor's, mock comes last; a warning names the other."""
    joints = joint('shoulder', 'position') + joint('elbow', 'position')
    small_package.ros2_control(
        joints, plugin=first, more='<ros2_control name="Second" type="system"><hardware><plugin>'
        f'{second}</plugin></hardware>{joints}</ros2_control>')
    _, manager, problems = start(small_package)
    assert [one.plugin_name for one in manager.list_hardware_components()] == [kept]
    left_out, = [text for text in said(problems) if 'is left out for shoulder, elbow' in text]
    assert (first if kept == second else second) in left_out


def test_a_tag_keeps_the_joints_that_no_other_has(small_package):
    """Of a component that shares some joints with another, the other joints stay."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        more=f'<ros2_control name="Second" type="system"><hardware><plugin>{MOCK}</plugin>'
             f'</hardware>{joint("shoulder", "position")}{joint("grip", "position")}'
             '</ros2_control>')
    _, manager, _ = start(small_package)
    assert [[i.name for i in one.command_interfaces]
            for one in manager.list_hardware_components()] == [
        ['shoulder/position', 'elbow/position'], ['grip/position']]


def test_two_tags_of_one_name(small_package):
    """The second of two tags with the same name is left out with a warning."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        more='<ros2_control name="Arm" type="system"><hardware/>' + joint('grip', 'position')
             + '</ros2_control>')
    _, manager, problems = start(small_package)
    assert [one.name for one in manager.list_hardware_components()] == ['Arm']
    assert any("hardware 'Arm' is defined twice" in text for text in said(problems))


def test_a_component_that_is_not_active_keeps_its_joints(small_package):
    """Controllers of the other component can still be switched on."""
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        more='<ros2_control name="Hand" type="system"><hardware/>' + joint('grip', 'position')
             + '</ros2_control>')
    _, manager, _ = start(small_package)
    manager.set_hardware_component_state('Hand', 'unconfigured')
    available = {one.name: one.is_available for one in manager.list_hardware_interfaces()[0]}
    assert available == {'shoulder/position': True, 'elbow/position': True,
                         'grip/position': False}
    assert manager.switch(deactivate=['arm_controller']).ok
    assert manager.switch(activate=['arm_controller']).ok


def test_a_component_that_does_not_start_active(small_package):
    """
    Its controllers stay inactive, its joints hold where they start, and all else runs.

    controller_manager.cpp, ControllerManager::set_initial_hardware_components_state.
    """
    small_package.write('config/ros2_controllers.yaml', small_package.ROS2.replace(
        'update_rate: 500\n', 'update_rate: 500\n    hardware_components_initial_state:\n'
        '      inactive: [Arm]\n'))
    small_package.ros2_control(
        joint('shoulder', 'position', states=STATES.format(INITIAL.format(0.5))),
        joint('elbow', 'position'))
    simulation, manager, _ = start(small_package)
    assert [one.state for one in manager.list_hardware_components()] == ['inactive']
    assert manager.controllers['joint_state_broadcaster'].active
    assert not manager.controllers['arm_controller'].active
    assert "hardware 'Arm', which is inactive" in manager.refusals[0]
    ControlLoop(simulation, manager, 500).advance(400)
    assert simulation.state.position[simulation.index['shoulder']] == pytest.approx(0.5, abs=1e-3)
    manager.set_hardware_component_state('Arm', 'active')
    assert manager.switch(['arm_controller']).ok


def test_hardware_makes_a_joint_follow(small_package):
    """
    <param name="mimic"> and <param name="multiplier"> of a joint couple it to another.

    topic_based_ros2_control, mujoco_ros2_control and Humble's Gazebo plugin read them so.
    """
    small_package.ros2_control(
        joint('shoulder', 'position'), joint('elbow', 'position'),
        joint('grip', inside='<param name="mimic">elbow</param>'
                             '<param name="multiplier">-0.5</param>'))
    simulation, manager, _ = start(small_package)
    assert 'grip/position' not in [one.name for one in manager.list_hardware_interfaces()[0]]
    simulation.set_positions({'elbow': 0.4})
    place = simulation.joint_names.index('grip')
    assert simulation.state.position[place] == pytest.approx(-0.2)


def test_a_joint_follows_one_that_is_there(small_package):
    """With a leader that the URDF lacks it moves by itself, with a warning."""
    small_package.ros2_control(joint('elbow', 'position'), joint(
        'grip', inside='<param name="mimic">elbw</param>'))
    found = survey_cell(str(small_package.folder))
    assert 'grip' in found.model.active_joints
    assert any("joint 'elbw' is not in the URDF" in text for text in said(found.problems))


@pytest.mark.parametrize(('part', 'text'), [
    ('<joints name="elbow"/>', "has a <joints>, which ros2_control refuses; did you mean 'joint'"),
    ('<gpio><state_interface name="level"/></gpio>', 'a <gpio> has no name'),
    ('<sensor name="hot"><state_interface/></sensor>',
     "a <state_interface> of sensor 'hot' has no name"),
    ('<gpio name="out"><command_interface/></gpio>',
     "a <command_interface> of gpio 'out' has no name"),
])
def test_parts_that_ros2_control_refuses_are_left_out(small_package, part, text):
    """
    A part of a wrong kind or without a name is left out with a warning; the rest counts.

    Upstream: test_component_parser.cpp, invalid_child_throws_error,
    missing_attribute_throws_error, component_interface_type_empty_throws_error.
    """
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'), part)
    _, manager, problems = start(small_package)
    assert any(text in one for one in said(problems)), said(problems)
    command, state = manager.list_hardware_interfaces()
    assert [one.name for one in command] == ['shoulder/position', 'elbow/position']
    assert {one.name.partition('/')[0] for one in state} == {'shoulder', 'elbow'}


def test_hardware_without_a_plugin_is_simulated_with_a_warning(small_package):
    """Upstream: test_component_parser.cpp, missing_hardware_plugin_tag_includes_component_name."""
    small_package.ros2_control(joint('shoulder', 'position'), joint('elbow', 'position'),
                               plugin='')
    _, manager, problems = start(small_package)
    assert any("hardware 'Arm' has no plugin" in text for text in said(problems))
    assert len(manager.list_hardware_interfaces()[0]) == 2


def test_files_of_a_plugin_in_a_comment_do_not_count():
    """A plugin that is commented out has no controllers' file, one beside it keeps its own."""
    assert plugin_parameters(
        '<gazebo><plugin><parameters> a.yaml </parameters></plugin><!--\n<plugin>'
        '<parameters>$(find p)/b.yaml</parameters></plugin> --></gazebo>') == ['a.yaml']
