# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Endpoints of ur_robot_driver, started by a launch file like its own.

``gpio_controller.cpp`` (setIO, setSpeedSlider, publishRobotMode), ``dashboard_client_ros.cpp``
(initServices), ``robot_state_helper.cpp`` (setModeExecute), ``controller_stopper.cpp``
(robotRunningCallback) and ``urscript_interface.cpp`` (script_callback) are what is re-enacted.
"""

from pathlib import Path
import sys

from controller_manager_msgs.srv import ListControllers
import pytest
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import SetBool, Trigger
from ur_dashboard_msgs.action import SetMode
from ur_dashboard_msgs.msg import RobotMode, SafetyMode
from ur_dashboard_msgs.srv import GetProgramState, GetRobotMode, GetSafetyMode, Load, RawRequest
from ur_msgs.msg import IOStates
from ur_msgs.srv import SetIO, SetPayload, SetSpeedSliderFraction

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.testing.program import private_domain, Program, ros_environment

HERE = Path(__file__).parent
IO, DASHBOARD = '/io_and_status_controller', '/dashboard_client'
SCALED = 'scaled_joint_trajectory_controller'


class Arm(ClientNode):
    """A client of the arm."""

    def trigger(self, name):
        """Call a Trigger; return its answer."""
        return self.call(name, Trigger)

    def set_io(self, **request):
        """Call set_io; return whether it succeeded."""
        return self.call(f'{IO}/set_io', SetIO, SetIO.Request(**request)).success

    def mode(self):
        """Return the mode of the drives."""
        return self.call(f'{DASHBOARD}/get_robot_mode', GetRobotMode).robot_mode.mode

    def states(self):
        """Return controller -> state."""
        answer = self.call('/controller_manager/list_controllers', ListControllers)
        return {entry.name: entry.state for entry in answer.controller}

    def wait_for_state(self, state):
        """Wait until the scaled controller is in a state."""
        while self.states()[SCALED] != state:
            self.settle()

    def run(self):
        """Have the program run, whatever was before."""
        self.call('/emergency_stop', SetBool, SetBool.Request(data=False))
        self.trigger('/clear_stop')
        goal = self.goal(SetMode, '/ur_robot_state_helper/set_mode', SetMode.Goal(
            target_robot_mode=RobotMode.RUNNING, stop_program=False, play_program=True))
        found = self.result(goal.result, 30.0)
        assert found.result.success, found.result
        self.wait_for_state('active')


@pytest.fixture(scope='module')
def stack():
    """Start the launch file; run the client of a real arm, unmodified, against it."""
    with private_domain() as domain:
        environment = ros_environment(domain)
        launch = Program.module(
            'armsim_ros', 'launch', str(HERE / 'ur_driver.launch.py'),
            'robot_ip:=192.168.56.101', environment=environment)
        try:
            launch.wait_for_line(f'active: {SCALED}', 90.0)  # the last
            client = Program([sys.executable, str(HERE / 'ur_client.py')],
                             environment=environment)
            status = client.wait(120.0)
            with Arm(domain, 'client') as arm:
                yield arm, status, client.text, launch
        finally:
            launch.stop(15.0)


@pytest.fixture
def arm(stack):
    """Return a client of an arm whose program runs."""
    arm = stack[0]
    arm.run()
    return arm


def test_a_client_of_a_real_arm_runs_unmodified(stack):
    """HW-A3: It powers up, unlocks, plays, sets an output and moves at half the speed."""
    _, status, text, launch = stack
    assert status == 0, text + launch.text
    assert 'set_mode: True Reached target robot mode.' in text
    assert 'Starting program' in text
    assert 'trajectory: 0' in text


def test_set_io_is_visible_in_io_states(arm):
    """
    Outputs that are set are in io_states; functions and pins that there are not fail.

    HW-C1, HW-C2.
    """
    states = arm.collect(f'{IO}/io_states', IOStates, 1)
    for value in (1.0, 0.0):
        assert arm.set_io(fun=1, pin=16, state=value)
        states.wait_for(
            lambda message, value=value: message.digital_out_states[16].state == bool(value))
    assert arm.set_io(fun=3, pin=1, state=0.5)
    message = states.wait_for(lambda message: message.analog_out_states[1].state == 0.5)
    assert [len(message.digital_in_states), len(message.analog_in_states)] == [18, 2]
    assert not arm.set_io(fun=1, pin=18, state=1.0)
    assert not arm.set_io(fun=4, pin=0, state=5.0)
    assert not arm.set_io(fun=2, pin=0, state=1.0)
    assert ParameterClient(arm, IO).set('io.digital_in_3', True) == ''
    states.wait_for(lambda message: message.digital_in_states[3].state)
    states.close()


def test_the_slider_is_published_in_percent(arm):
    """HW-C3: set_speed_slider moves the speed scaling; outside of 0.01 to 1 it fails."""
    scaling = arm.collect('/speed_scaling_state_broadcaster/speed_scaling', Float64, 1)
    for fraction, success in ((0.25, True), (0.0, False), (1.5, False), (1.0, True)):
        answer = arm.call(f'{IO}/set_speed_slider', SetSpeedSliderFraction,
                          SetSpeedSliderFraction.Request(speed_slider_fraction=fraction))
        assert answer.success == success
        if success:
            scaling.wait_for(
                lambda message, fraction=fraction: abs(message.data - 100 * fraction) < 1e-6)
    scaling.close()


def test_modes_pass_one_by_one(arm):
    """
    power_off, power_on and brake_release go through 3, 4, 5 and 7, as the answers say.

    HW-C4.
    """
    modes = arm.collect(f'{IO}/robot_mode', RobotMode, LATCHED)
    running = arm.collect(f'{IO}/robot_program_running', Bool, LATCHED)
    modes.wait_for(lambda message: message.mode == RobotMode.RUNNING)
    running.wait_for(lambda message: message.data)
    running.clear()
    assert arm.trigger(f'{DASHBOARD}/power_off').message == 'Powering off'
    running.wait_for(lambda message: not message.data)
    assert arm.mode() == RobotMode.POWER_OFF
    assert arm.trigger(f'{DASHBOARD}/power_on').message == 'Powering on'
    modes.wait_for(lambda message: message.mode == RobotMode.IDLE)
    assert arm.trigger(f'{DASHBOARD}/brake_release').message == 'Brake releasing'
    modes.wait_for(lambda message: message.mode == RobotMode.POWER_ON)
    modes.wait(5)
    passed = [message.mode for message in modes.messages]
    assert passed == [7, 3, 4, 5, 7]
    assert arm.states()[SCALED] == 'inactive'
    assert arm.trigger(f'{DASHBOARD}/play').success
    running.wait_for(lambda message: message.data)
    modes.close()
    running.close()


def test_a_protective_stop_is_unlocked_after_five_seconds(arm):
    """
    Until then it fails with the dashboard's text; afterwards the program is to be played.

    HW-B4, HW-C4.
    """
    assert arm.call('/protective_stop', SetBool, SetBool.Request(data=True)).success
    mode = arm.call(f'{DASHBOARD}/get_safety_mode', GetSafetyMode)
    assert mode.safety_mode.mode == SafetyMode.PROTECTIVE_STOP
    assert mode.answer == 'Safetymode: PROTECTIVE_STOP'
    assert not arm.trigger(f'{DASHBOARD}/play').success
    safety = arm.collect('/safety', String, LATCHED)
    while not (answer := arm.trigger(f'{DASHBOARD}/unlock_protective_stop')).success:
        assert '5s' in answer.message
        arm.settle()
    safety.wait_for(lambda message: '"NORMAL"' in message.data)
    safety.close()
    state = arm.call(f'{DASHBOARD}/program_state', GetProgramState)
    assert state.state.state == 'STOPPED'
    assert arm.trigger(f'{DASHBOARD}/play').message == 'Starting program'
    arm.wait_for_state('active')


def test_control_that_is_handed_back_deactivates_what_moves_the_arm(arm):
    """
    hand_back_control stops the program; without headless_mode it cannot be sent again.

    HW-C6.
    """
    before = arm.states()
    assert arm.trigger(f'{IO}/hand_back_control').success
    arm.wait_for_state('inactive')
    assert {name for name, state in arm.states().items() if state != before[name]} == {SCALED}
    assert not arm.trigger(f'{IO}/resend_robot_program').success
    assert arm.trigger(f'{DASHBOARD}/play').success
    arm.wait_for_state('active')
    assert arm.states() == before


def test_the_dashboard_answers_texts(arm):
    """HW-C4: raw_request, load_program, payload and force sensor answer as the real arm does."""
    raw = arm.call(f'{DASHBOARD}/raw_request', RawRequest, RawRequest.Request(query='robotmode'))
    assert raw.answer == 'Robotmode: RUNNING'
    assert not arm.call(f'{DASHBOARD}/load_program', Load, Load.Request(filename='no')).success
    assert arm.call(f'{IO}/set_payload', SetPayload, SetPayload.Request(mass=0.5)).success
    assert arm.call(f'{IO}/set_payload', SetPayload, SetPayload.Request(mass=0.0)).success
    assert arm.trigger(f'{IO}/zero_ftsensor').success


def test_a_script_sets_an_output_and_moves_the_arm(arm):
    """HW-C8: A script runs as a whole, taking control; one that is not understood does nothing."""
    states = arm.collect(f'{IO}/io_states', IOStates, 1)
    running = arm.collect(f'{IO}/robot_program_running', Bool, LATCHED)
    script = arm.node.create_publisher(String, '/urscript_interface/script_command', 1)
    while not script.get_subscription_count():
        arm.settle()
    script.publish(String(data='set_digital_out(5, True)\nmovec(p[0,0,0,0,0,0])\n'))
    script.publish(String(data=(
        'def moving():\n  set_digital_out(4, True)\n  movej([0.6, -1.2, 0.4, -1.4, 0.2, 0.1], '
        'a=2.0, v=2.0)\n  set_digital_out(6, True)\nend\n')))
    message = states.wait_for(lambda message: message.digital_out_states[6].state)
    assert message.digital_out_states[4].state
    assert not message.digital_out_states[5].state
    running.wait_for(lambda message: not message.data)
    states.close()
    running.close()
