# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Answers of Universal Robots' endpoints, without a middleware between client and arm.

As ``gpio_controller.cpp`` (setIO, setSpeedSlider) and ``dashboard_client_ros.cpp``
(initServices, handleSafetyModeQuery) of ur_robot_driver.
"""

import math
from types import SimpleNamespace

from direct_nodes import Node, Nodes
from geometry_msgs.msg import Vector3
import pytest
from ur_msgs.msg import Analog

from armsim_ros.nodes.vendors.ur_dashboard import Dashboard, headless
from armsim_ros.nodes.vendors.ur_endpoints import IoAndStatus
from armsim_ros.nodes.vendors.ur_urscript import read_script, ScriptError
from armsim_ros.stack import ArmSim


@pytest.fixture
def sim():
    """Return an arm of Universal Robots."""
    return ArmSim('sunday', overrides={'simulation.hardware.vendor': 'ur'})


@pytest.fixture
def nodes(sim):
    """Return its endpoints."""
    nodes = Nodes(sim)
    Dashboard(nodes)
    return nodes


@pytest.fixture
def io(nodes):
    """Return its endpoints, with an io controller whose state a test may set."""
    controller = SimpleNamespace(active=True)
    nodes.controller = controller
    nodes.io = IoAndStatus(nodes, controller, Node())
    return nodes


def test_modes_pass_one_by_one(sim, nodes):
    """
    Each mode takes its time; the program runs only once the brakes are released.

    HW-C4, HW-C5.
    """
    seen = []
    assert nodes.call('power_off').message == 'Powering off'
    for command, answer in (('power_on', 'Powering on'), ('brake_release', 'Brake releasing')):
        assert nodes.call(command).message == answer
        for _ in range(30):
            sim.run_until(sim.time + 0.1)
            seen.append(nodes.call('get_robot_mode').robot_mode.mode)
    assert sorted(set(seen)) == [3, 4, 5, 7]
    assert seen == sorted(seen)
    assert nodes.call('program_state').state.state == 'STOPPED'
    assert nodes.call('play').message == 'Starting program'
    assert nodes.call('program_running').program_running


def test_a_protective_stop_is_unlocked_after_five_seconds(sim, nodes):
    """HW-B4: Too early it is refused with the text of the dashboard; afterwards nothing plays."""
    sim.protective_stop()
    sim.step(20)
    mode = nodes.call('get_safety_mode')
    assert (mode.safety_mode.mode, mode.answer) == (3, 'Safetymode: PROTECTIVE_STOP')
    early = nodes.call('unlock_protective_stop')
    assert not early.success
    assert '5s' in early.message
    assert not nodes.call('play').success
    sim.run_until(sim.time + 5.0)
    assert nodes.call('unlock_protective_stop').message == 'Protective stop releasing'
    assert nodes.call('get_safety_mode').answer == 'Safetymode: NORMAL'
    assert nodes.call('play').success


def test_an_emergency_stop_leaves_the_power_off(sim, nodes):
    """HW-B4: Pressed, it refuses power; released, the arm is to be powered up."""
    sim.manager.arm.emergency_stop()
    sim.step(20)
    assert nodes.call('get_safety_mode').safety_mode.mode == 7
    assert not nodes.call('power_on').success
    sim.manager.arm.release_emergency_stop()
    sim.step(20)
    assert nodes.call('get_robot_mode').robot_mode.mode == 3
    assert nodes.call('brake_release').success
    sim.run_until(sim.time + 3.5)
    assert nodes.call('play').success


def test_raw_requests_are_those_of_the_services(nodes):
    """HW-C4: A command as text does what its service does; an unknown one is not understood."""
    ask = lambda query: nodes.call('raw_request', query=query).answer  # noqa: E731
    assert ask('robotmode') == 'Robotmode: RUNNING'
    assert ask('pause\n') == 'Pausing program'
    assert ask('programState') == 'PAUSED external_control.urp'
    assert ask('stop') == 'Stopped'
    assert 'could not understand' in ask('dance')
    assert not nodes.call('load_program', filename='notes.txt').success
    assert nodes.call('load_program', filename='/programs/pick.urp').success
    assert nodes.call('get_loaded_program').program_name == '/programs/pick.urp'


@pytest.mark.parametrize(('request_', 'signal'), [
    ({'fun': 1, 'pin': 17, 'state': 1.0}, 'digital_out_17'),
    ({'fun': 3, 'pin': 1, 'state': 0.5}, 'analog_out_1'),
    ({'fun': 4, 'pin': 0, 'state': 24.0}, 'tool_voltage'),
])
def test_an_output_is_set(io, request_, signal):
    """HW-C2: Outputs have the state that was set."""
    assert io.call('set_io', **request_).success
    assert io.arm.signals.get(signal) == request_['state']


@pytest.mark.parametrize('request_', [
    {'fun': 1, 'pin': 18, 'state': 1.0}, {'fun': 1, 'pin': -1, 'state': 1.0},
    {'fun': 2, 'pin': 0, 'state': 1.0}, {'fun': 3, 'pin': 2, 'state': 1.0},
    {'fun': 4, 'pin': 0, 'state': 5.0},
    {'fun': 3, 'pin': 0, 'state': 1.5}, {'fun': 3, 'pin': 0, 'state': -0.1},
    {'fun': 3, 'pin': 0, 'state': math.nan}])
def test_an_output_that_there_is_not_is_refused(io, request_):
    """HW-C2: Other functions, pins, voltages and shares fail (sendStandardAnalogOutput)."""
    assert not io.call('set_io', **request_).success


@pytest.mark.parametrize(('state', 'success'), [
    (0.0, True), (1.0, True), (1.5, False), (-0.1, False), (math.nan, False)])
def test_an_analog_output_is_a_share_of_its_range(io, state, success):
    """As ``RTDEWriter::sendStandardAnalogOutput``; what is refused sets nothing."""
    answer = io.call('set_analog_output', data=Analog(pin=1, domain=1, state=state))
    assert answer.success is success
    assert io.arm.signals.get('analog_out_1') == (state if success else 0.0)


@pytest.mark.parametrize('request_', [
    {'mass': math.nan}, {'mass': math.inf}, {'mass': 1.0, 'ixx': math.nan},
    {'mass': 1.0, 'center_of_gravity': Vector3(y=math.nan)}])
def test_a_payload_that_is_not_finite_is_refused(io, request_):
    """As ``checkAsyncIO`` (hardware_interface.cpp), which sends no such payload."""
    assert not io.call('set_payload', **request_).success
    assert not io.manager.hardware.payloads


def test_an_inactive_controller_refuses_everything(io):
    """HW-C1: Services fail and change nothing while the controller is not active."""
    io.controller.active = False
    assert not io.call('set_io', fun=1, pin=1, state=1.0).success
    assert not io.call('set_speed_slider', speed_slider_fraction=0.5).success
    assert not io.call('hand_back_control').success
    assert (io.arm.signals.get('digital_out_1'), io.arm.slider) == (0.0, 1.0)


def test_a_controller_that_was_never_active_answers(nodes):
    """Its services are there once it is configured (on_configure, ensureActive)."""
    IoAndStatus(nodes, SimpleNamespace(active=False), Node())
    assert not nodes.call('set_io', fun=1, pin=1, state=1.0).success
    assert nodes.call('resend_robot_program').success is False


def test_the_slider_and_control(io, sim):
    """HW-C3: The slider keeps to its range; control that is handed back stops the program."""
    assert io.call('set_speed_slider', speed_slider_fraction=0.01).success
    assert not io.call('set_speed_slider', speed_slider_fraction=0.0).success
    assert io.arm.slider == 0.01
    assert io.call('hand_back_control').success
    assert 'program does not run' in io.arm.obstacle
    assert not io.call('resend_robot_program').success  # without headless_mode


def test_headless_mode_is_the_drivers():
    """HW-C6: ``headless_mode`` of the hardware lets the program be sent."""
    text = ('<robot name="a"><ros2_control name="a" type="system"><hardware>'
            '<param name="headless_mode">{}</param></hardware></ros2_control></robot>')
    assert headless(text.format('true'))
    assert not headless(text.format('false'))
    assert not headless('<robot name="a"/>')


def test_a_script_is_read_with_its_arguments():
    """HW-C8: Positions, names and defaults of arguments are those of URScript."""
    secondary, commands = read_script(
        'def f():\n  set_digital_out(3, True)  # valve\n  movej([0, 1], a=2.0)\n  sleep(0.5)\n'
        'end\nf()\n', 2)
    assert not secondary
    assert [command.name for command in commands] == ['set_digital_out', 'movej', 'sleep']
    assert commands[1].arguments == {'q': [0, 1], 'a': 2.0, 'v': 1.05, 't': 0.0, 'r': 0.0}
    assert read_script('sec s():\n textmsg("a", "b")\nend', 2)[0]


@pytest.mark.parametrize(('script', 'line'), [
    ('movel(p[0, 0, 0, 0, 0, 0])', 1), ('movej(p[0, 0, 0, 0, 0, 0])', 1),
    ('textmsg("a")\nmovej([0, 1, 2])', 2), ('set_digital_out(18, True)', 1),
    ('sec s():\nmovej([0, 1])\nend', 2), ('sleep(-1)', 1), ('x = 3', 1),
    ('movej([0, 1], b=2)', 1), ('set_tool_voltage(5)', 1), ('set_digital_out(f(), 1)', 1)])
def test_what_is_not_simulated_is_an_error_with_its_line(script, line):
    """HW-C8: A script with anything else is refused as a whole."""
    with pytest.raises(ScriptError, match=f'line {line}, '):
        read_script(script, 2)
