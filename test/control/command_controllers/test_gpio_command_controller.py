# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The gpio controller: what it sets, what it drops, what it tells."""

import math

import pytest

from armsim_ros.control.command_controllers.hand_drive import HandDrive
from armsim_ros.errors import ControllerError

GPIO = 'gpio_controllers/GpioCommandController'
LAMP = {'gpios': ['lamp'], 'command_interfaces': {'lamp': {'interfaces': ['on', 'hue']}},
        'publish_rate': 0.0}


@pytest.fixture
def made(rig):
    """Return joints with an active controller of a lamp."""
    made = rig()
    made.hardware.other_commands.update({'lamp/on': math.nan, 'lamp/hue': math.nan})
    made.hardware.given_states.update({'lamp/on': 0.0, 'lamp/lit': 3.0})
    made.gpios = made.load('gpios', GPIO, **LAMP)
    result = made.manager.switch(activate=['gpios'])
    assert result.ok, result.message
    made.step()
    return made


def test_named_values_are_set(made):
    """What a command names is set at the next update, the rest stays."""
    assert made.gpios.receive([('lamp', ['hue'], [0.5])]) == ''
    made.step()
    assert made.hardware.other_commands['lamp/hue'] == 0.5
    assert math.isnan(made.hardware.other_commands['lamp/on'])


@pytest.mark.parametrize(('groups', 'words'), [
    ([('lamp', ['on', 'hue'], [1.0])], '2 interface names and 1 values'),
    ([('lamp', ['on'], [math.nan])], 'nan for lamp/on'),
    ([('lamp', ['on'], [1.0]), ('lamp', ['hue'], [math.inf])], 'inf for lamp/hue'),
])
def test_what_is_no_command(made, groups, words):
    """It is dropped as a whole, with a reason; the controller stays active."""
    assert words in made.gpios.receive(groups)
    made.step()
    assert all(map(math.isnan, made.hardware.other_commands.values()))
    assert made.gpios.active
    assert any(words in text for text in made.texts())


def test_unknown_names_are_told(made):
    """A name that is not commanded is told of; the others are set."""
    assert made.gpios.receive([('lamp', ['onn', 'on'], [1.0, 1.0])]) == ''
    made.step()
    assert made.hardware.other_commands['lamp/on'] == 1.0
    assert any("'lamp/onn'" in text and 'lamp/on' in text for text in made.texts())


def test_all_states_are_told(made):
    """Where no state is named, all of the gpio are told."""
    assert made.gpios.interfaces == ('lamp/on', 'lamp/lit')
    assert made.gpios.poll().values.tolist() == [0.0, 3.0]


@pytest.fixture
def finger(rig):
    """Return joints with an active controller of joint a's position, and of its states."""
    def make(**parameters):
        made = rig()
        made.gpios = made.load('gpios', GPIO, gpios=['a'], publish_rate=0.0, command_interfaces={
            'a': {'interfaces': ['position']}}, **parameters)
        result = made.manager.switch(activate=['gpios'])
        assert result.ok, result.message
        made.step()
        return made

    return make


def test_a_joint_is_commanded(finger):
    """Re-enacts gpio_command_controller.cpp, apply_command: any interface that it claims."""
    made = finger()
    assert made.gpios.receive([('a', ['position'], [0.5])]) == ''
    made.step(2)
    assert made.hardware.state.position.tolist() == [0.5, 0.0]
    assert made.gpios.joints == ('a',)
    assert made.gpios.moves_arm


@pytest.fixture
def brake(rig):
    """Return joints with an active controller of the brake of joint a, which moves no joint."""
    made = rig()
    made.hardware.other_commands['a/brake'] = math.nan
    made.gpios = made.load('gpios', GPIO, gpios=['a'], publish_rate=0.0, command_interfaces={
        'a': {'interfaces': ['brake']}})
    assert made.manager.switch(activate=['gpios']).ok
    made.step()
    return made


def test_a_command_that_does_not_move_a_joint_is_followed_while_the_arm_is_stopped(brake):
    """The controller goes on, and the stop holds the joint that it belongs to."""
    assert brake.gpios.joints == ()
    assert not brake.gpios.moves_arm
    brake.manager.arm.protective_stop()
    brake.step()
    assert brake.manager.stops.arm_joints == ('a', 'b')
    assert brake.gpios.receive([('a', ['brake'], [1.0])]) == ''
    brake.step()
    assert brake.hardware.other_commands['a/brake'] == 1.0


def test_a_command_that_does_not_move_a_joint_leaves_it_to_a_device(brake):
    """A device commands its joints while no controller moves them."""
    device = HandDrive.of('hand', 'a', brake.manager.context)
    brake.manager.attach(device)
    assert device.holder == ''
    brake.arm(joints=['a'])
    assert device.holder == 'arm'


def test_commands_of_a_joint_are_dropped_while_the_arm_is_stopped(finger):
    """As those of every controller that moves the arm."""
    made = finger()
    made.manager.arm.protective_stop()
    made.step()
    assert 'stop' in made.gpios.receive([('a', ['position'], [0.5])])


def test_states_of_a_joint_are_published_where_they_are_named(finger):
    """Re-enacts gpio_command_controller.cpp, set_all_state_interfaces_of_configured_gpios."""
    assert finger().gpios.interfaces == ()
    made = finger(state_interfaces={'a': {'interfaces': ['position']}})
    made.hardware.state.position[0] = 0.25
    made.gpios.sample(made.now_ns)
    assert list(iter(made.gpios.poll, None))[-1].values.tolist() == [0.25]


def test_what_is_missing(rig):
    """An empty list, a gpio that is not there, and one that is not listed."""
    with pytest.raises(ControllerError, match="'gpios'"):
        rig().load('gpios', GPIO)
    with pytest.raises(ControllerError, match='no gpio lamp'):
        rig().load('gpios', GPIO, gpios=['lamp'])
    with pytest.raises(ControllerError, match="'lamb' is not among gpios"):
        rig().load('gpios', GPIO, gpios=['lamp'],
                   command_interfaces={'lamb': {'interfaces': ['on']}})
    made = rig()
    made.load('gpios', GPIO, **LAMP)
    result = made.manager.switch(activate=['gpios'])
    assert not result.ok
    assert 'lamp/on' in result.message
