# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""robot_state_publisher and joint_state_publisher as programs, without a simulation."""

from collections.abc import Iterator
from contextlib import ExitStack
import subprocess
import sys
from textwrap import dedent
from typing import Any

import pytest
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
import yaml

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.nodes.upstream.main import main
from armsim_ros.testing.program import private_domain, start_program

JOINT = ('<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>{4}'
         '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
URDF = '<robot name="r">{}{}{}</robot>'.format(
    ''.join(f'<link name="{name}"/>' for name in ('base', 'arm', 'tip', 'tool')),
    JOINT.format('turn', 'revolute', 'base', 'arm', '')
    + JOINT.format('bend', 'revolute', 'arm', 'tip', '<mimic joint="turn" multiplier="2"/>'),
    JOINT.format('mount', 'fixed', 'tip', 'tool', ''))
NODE = '/left/rsp'


class Publishers:
    """Both programs in a namespace, and a client."""

    def __init__(self, client: ClientNode) -> None:
        self.client = client
        self.parameters = ParameterClient(client, NODE)
        self.static = client.collect('/tf_static', TFMessage, LATCHED)
        self.descriptions = client.collect('/left/robot_description', String, LATCHED)
        self.moving = client.collect('/tf', TFMessage, 100)
        self.source = client.node.create_publisher(JointState, '/left/given', 10)

    def transforms(self, matches: Any) -> dict[str, Any]:
        """Return child frame -> transform of the first message from now on that matches."""
        self.moving.clear()
        message = self.moving.wait_for(lambda one: matches(one.transforms))
        return {one.child_frame_id: one for one in message.transforms}


@pytest.fixture(scope='module')
def publishers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Publishers]:
    """Give both programs, joint_state_publisher with a source."""
    folder = tmp_path_factory.mktemp('parameters')
    words = {}
    for name, values in (
            ('robot_state_publisher', {'robot_description': URDF, 'frame_prefix': 'l_'}),
            ('joint_state_publisher', {'source_list': ['given'], 'rate': 50,
                                       'zeros': {'turn': 0.25}})):
        file = folder / f'{name}.yaml'
        file.write_text(yaml.safe_dump({'/**': {'ros__parameters': values}}), encoding='utf-8')
        words[name] = [name, '--ros-args', '-r', '__ns:=/left', '--params-file', str(file)]
    words['robot_state_publisher'] += ['-r', '__node:=rsp']
    with ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        client = stack.enter_context(ClientNode(domain, 'user'))
        for arguments in words.values():
            stack.enter_context(start_program('original', domain, *arguments))
        yield Publishers(client)


def test_a_node_in_a_namespace_keeps_name_prefix_and_rate(publishers: Publishers) -> None:
    """
    Its topics are in its namespace, its frames have the prefix, and the rate is as given.

    robot_state_publisher/src/robot_state_publisher.cpp: RobotStatePublisher.
    """
    get = publishers.parameters.get
    assert get('publish_frequency') == 20.0
    assert get('frame_prefix') == 'l_'
    assert get('ignore_timestamp') is False
    assert publishers.descriptions.wait(1)[0].data == URDF == get('robot_description')
    (fixed,) = publishers.static.wait(1)[0].transforms
    assert (fixed.header.frame_id, fixed.child_frame_id) == ('l_tip', 'l_tool')
    frames = publishers.transforms(bool)
    assert list(frames) == ['l_tip', 'l_arm']
    (info,) = publishers.client.node.get_subscriptions_info_by_topic('/left/joint_states')
    profile = info.qos_profile
    assert (profile.reliability, profile.durability) == (
        qos_profile_sensor_data.reliability, qos_profile_sensor_data.durability)


def test_joint_states_come_from_the_description_and_the_source(publishers: Publishers) -> None:
    """
    A joint begins where zeros says and follows the source, its mimic joint with it.

    joint_state_publisher/joint_state_publisher/joint_state_publisher.py: timer_callback.
    """
    states = publishers.client.collect('/left/joint_states', JointState)
    first = states.wait(1)[0]
    assert list(first.name) == ['turn', 'bend']
    assert list(first.position) == [0.25, 0.5]
    assert not first.velocity
    source = publishers.source
    timer = publishers.client.node.create_timer(0.05, lambda: source.publish(
        JointState(name=['turn', 'lost'], position=[0.4, 1.0], velocity=[1.0, 1.0])))
    moved = states.wait_for(lambda one: one.position[0] == 0.4)
    publishers.client.node.destroy_timer(timer)
    assert list(moved.position) == [0.4, 0.8]
    assert list(moved.velocity) == [1.0, 2.0]


def test_parameters_that_are_refused(publishers: Publishers) -> None:
    """
    An empty or unreadable description and a frequency out of range are refused with a reason.

    robot_state_publisher/src/robot_state_publisher.cpp: parameterUpdate.
    """
    for name, value in (('robot_description', ''), ('robot_description', '<robot name="r"'),
                        ('publish_frequency', 1000.1), ('publish_frequency', -0.1)):
        assert publishers.parameters.set(name, value)
    assert publishers.parameters.get('robot_description') == URDF


def test_a_prefix_set_while_running(publishers: Publishers) -> None:
    """
    /tf has it from the next message on, /tf_static from the next description on.

    robot_state_publisher/src/robot_state_publisher.cpp: publishTransforms, onParameterEvent.
    """
    assert publishers.parameters.set('frame_prefix', 'm_') == ''
    publishers.transforms(lambda found: 'm_arm' in {one.child_frame_id for one in found})
    assert len(publishers.static.messages) == 1
    changed = URDF.replace('"tool"', '"hand"').replace('"bend"', '"lean"')
    assert publishers.parameters.set('robot_description', changed) == ''
    publishers.descriptions.wait_for(lambda one: one.data == changed)
    frames = publishers.static.wait_for(lambda one: len(one.transforms) == 2).transforms
    assert {one.child_frame_id for one in frames} == {'l_tool', 'm_hand'}
    states = publishers.client.collect('/left/joint_states', JointState)
    states.wait_for(lambda one: list(one.name) == ['turn', 'lean'])


def test_a_circle_of_mimic_joints_ends_the_program(
    publishers: Publishers, tmp_path: Any
) -> None:
    """
    The status is 1.

    joint_state_publisher/joint_state_publisher/joint_state_publisher.py: timer_callback.
    """
    file = tmp_path / 'circle.urdf'
    file.write_text(URDF.replace('<mimic joint="turn"', '<mimic joint="bend"'), encoding='utf-8')
    domain = publishers.client.context.get_domain_id()
    with start_program('original', domain, 'joint_state_publisher', str(file),
                       '--ros-args', '-r', '__ns:=/alone') as program:
        assert program.wait(30.0) == 1
        assert 'Traceback' not in program.text
        assert 'bend -> bend' in program.text


def test_sigint_interrupts_no_callback() -> None:
    """What is being done is completed, and the status is 0; no KeyboardInterrupt is raised."""
    made = subprocess.run([sys.executable, '-c', dedent("""
        import os, signal
        from armsim_ros.nodes.upstream.single_node import spin

        def make(node):
            os.kill(os.getpid(), signal.SIGINT)
            print('made')

        raise SystemExit(spin('any', [], make))
    """)], capture_output=True, text=True, timeout=60, check=False)
    # Fast DDS may print a line of its own where two participants open a port at the same time.
    assert (made.returncode, made.stdout.splitlines()[-1:]) == (0, ['made']), made.stderr


@pytest.mark.parametrize('words', [
    ['robot_state_publisher', '--ros-args', '-p', 'publish_frequency:=fast'],
    ['robot_state_publisher'],
    ['robot_state_publisher', '/nowhere.urdf'],
    ['joint_state_publisher', '--ros-args', '-p', 'rate:=fast'],
    ['joint_state_publisher', '--ros-args', '-p', 'dependent_joints.a.factor:=2.0'],
    ['joint_state_publisher', '--ros-args', '-p', 'dependent_joints.a.other:=2.0'],
    ['joint_state_publisher', '/nowhere.urdf']])
def test_an_error_of_the_user_is_one_line(capfd: Any, words: list[str]) -> None:
    """A wrong parameter or file ends the program with the status 2."""
    assert main(words) == 2
    printed = capfd.readouterr().err
    assert 'Traceback' not in printed
    assert len([line for line in printed.splitlines() if not line.startswith('[')]) == 1


@pytest.mark.parametrize('word', ['-h', '--help'])
def test_joint_state_publisher_has_a_help(capsys: Any, word: str) -> None:
    """Re-enacts joint_state_publisher.py, main: it is not taken for a file."""
    assert main(['joint_state_publisher', word]) == 0
    assert '[description_file]' in capsys.readouterr().out
