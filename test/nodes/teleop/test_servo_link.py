# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What servo_node is sent, beside a servo_node that is not ours."""

import os
import signal
import threading

from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.srv import ServoCommandType
import pytest
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from std_srvs.srv import SetBool

from armsim_ros.cli.main import main
from armsim_ros.clients.client_node import ClientNode

pytestmark = pytest.mark.usefixtures('fake_stack')


class Servo:
    """The interfaces of servo_node, and a record of what they get."""

    def __init__(self, client):
        self.client, self.types, self.pauses = client, [], []
        self.twists = client.collect('/servo/delta_twist_cmds', TwistStamped)
        self.jogs = client.collect('/servo/delta_joint_cmds', JointJog)
        self._services = [client.node.create_service(*each) for each in (
            (ServoCommandType, '/servo/switch_command_type', self._switch),
            (SetBool, '/servo/pause_servo', self._pause),
            (GetParameters, '/servo/get_parameters', self._parameters))]

    def leave(self):
        """Be gone."""
        for each in self._services:
            self.client.in_executor(lambda each=each: self.client.node.destroy_service(each))

    def _switch(self, request, response):
        self.types.append(request.command_type)
        response.success = True
        return response

    def _pause(self, request, response):
        self.pauses.append(request.data)
        response.success = True
        return response

    def _parameters(self, request, response):
        assert request.names == ['moveit_servo.command_in_type', 'moveit_servo.move_group_name']
        response.values = [
            ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
            for text in ('speed_units', 'arm')]
        return response


@pytest.fixture
def servo():
    """Give a servo_node of speeds, named /servo."""
    with ClientNode(name='servo_of_others') as client:
        yield Servo(client)


def run(use, *, interrupt=True):
    """Run teleop while another thread uses it; return the status."""
    def work():
        try:
            use()
        finally:
            if interrupt:
                os.kill(os.getpid(), signal.SIGINT)

    user = threading.Thread(target=work)
    user.start()
    try:
        return main(['teleop', '--with', 'keyboard', '--servo', '/servo', '--timeout', '20'])
    finally:
        user.join()


def test_keys_become_twists_and_jogs_and_end_with_a_halt(servo, keyboard):
    """Half the speed by default; a zero command after the last; servo is paused at the end."""
    seen = {}

    def use():
        seen['twist'] = servo.twists.wait_after(lambda: os.write(keyboard, b'q'))
        servo.twists.wait_for(lambda each: each.twist.linear.z == 0.0)
        seen['jog'] = servo.jogs.wait_after(lambda: os.write(keyboard, b'r2'))
        servo.jogs.wait_for(lambda each: list(each.velocities) == [0.0])
        os.write(keyboard, b'9')

    assert run(use) == 0
    linear = seen['twist'].twist.linear
    assert (linear.x, linear.y, linear.z) == (0.0, 0.0, pytest.approx(0.1))
    assert seen['twist'].header.frame_id == 'base'
    assert list(seen['jog'].joint_names) == ['bend']
    assert abs(seen['jog'].velocities[0]) == pytest.approx(0.25)
    assert servo.types[0] == ServoCommandType.Request.TWIST
    assert servo.types[-1] == ServoCommandType.Request.JOINT_JOG
    assert servo.pauses == [False, True]


def test_p_pauses_and_resumes(servo, keyboard):
    """By pause_servo."""
    def use():
        servo.twists.wait_after(lambda: os.write(keyboard, b'q'))
        os.write(keyboard, b'p')
        servo.client.settle()
        os.write(keyboard, b'p')
        servo.client.settle()

    assert run(use) == 0
    assert servo.pauses == [False, True, False, True]


def test_a_servo_node_that_is_gone_ends_it(servo, keyboard, capsys):
    """With a message and status 1."""
    def use():
        servo.twists.wait_after(lambda: os.write(keyboard, b'q'))
        servo.leave()
        for _ in range(40):  # as long as it is held
            os.write(keyboard, b'q')
            servo.client.settle()
            if 'is gone' in capsys.readouterr().err:
                return
        os.kill(os.getpid(), signal.SIGINT)

    assert run(use, interrupt=False) == 1
