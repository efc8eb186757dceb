# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""rosapi: over the bridge, and as services of ROS."""

import json
import os
import threading
import time

import pytest
from rcl_interfaces.srv import ListParameters
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.task import Future
from rosapi_msgs.srv import TopicType
from std_msgs.msg import Int32, String

from armsim_ros.nodes.bridge.rosapi import service_name, typedefs

#: For what the graph brings [s].
PATIENCE = 15.0
LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def known(peer):
    """Have a topic and a parameter in the graph."""
    peer.declare_parameter('gain', 1.5)
    peer.declare_parameter('names', ['a', 'b'])
    return peer.create_publisher(String, '/known', 10)


@pytest.fixture
def ask(talk, known):
    """Return a function that returns the values of a service of rosapi."""
    client = talk()

    def ask(service, /, **args):
        answer = client.call(f'/rosapi/{service}', args)
        assert answer['result'] is True, answer
        return answer['values']

    deadline = time.monotonic() + PATIENCE
    while '/peer' not in ask('publishers', topic='/known')['publishers']:
        assert time.monotonic() < deadline
    return ask


def test_names_of_services_follow_from_their_types():
    """In snake case, with two that differ."""
    assert service_name('TopicsAndRawTypes') == 'topics_and_raw_types'
    assert service_name('GetROSVersion') == 'get_ros_version'
    assert service_name('GetActionServers') == 'action_servers'


def test_a_description_has_types_lengths_and_constants():
    """Each type once, names as in definitions of messages."""
    from sensor_msgs.msg import BatteryState, CameraInfo

    first, *rest = typedefs(CameraInfo)
    fields = dict(zip(first.fieldnames, zip(first.fieldtypes, first.fieldarraylen, strict=True),
                      strict=True))
    assert first.type == 'sensor_msgs/CameraInfo'
    assert fields['header'] == ('std_msgs/Header', -1)
    assert (fields['k'], fields['d']) == (('float64', 9), ('float64', 0))
    assert [found.type for found in rest] == [
        'std_msgs/Header', 'builtin_interfaces/Time', 'sensor_msgs/RegionOfInterest']
    battery = typedefs(BatteryState)[0]
    constants = dict(zip(battery.constnames, battery.constvalues, strict=True))
    assert constants['POWER_SUPPLY_STATUS_FULL'] == '4'
    assert 'SLOT_TYPES' not in constants


def test_the_graph_is_described(ask, known):
    """Topics, nodes, types, publishers."""
    topics = ask('topics')
    assert dict(zip(topics['topics'], topics['types'], strict=True))['/known'] == (
        'std_msgs/msg/String')
    assert ask('topic_type', topic='known') == {'type': 'std_msgs/msg/String'}
    assert '/known' in ask('topics_for_type', type='std_msgs/String')['topics']
    assert {'/peer', '/rosapi', '/rosbridge_websocket'} <= set(ask('nodes')['nodes'])
    assert ask('publishers', topic='/known') == {'publishers': ['/peer']}
    assert '/known' in ask('node_details', node='/peer')['publishing']
    assert ask('service_node', service='/rosapi/topics') == {'node': '/rosapi'}
    assert ask('service_providers', service='rosapi_msgs/Topics') == {'providers': ['/rosapi']}
    assert ask('service_type', service='/rosapi/topics') == {'type': 'rosapi_msgs/srv/Topics'}
    assert ask('get_ros_version') == {'version': 2, 'distro': os.environ.get('ROS_DISTRO',
                                                                              'jazzy')}
    assert set(ask('get_time')['time']) == {'sec', 'nanosec', 'secs', 'nsecs'}


def test_types_are_described_with_their_full_text(ask, known):
    """Also types that are built from this package's sources."""
    raw = ask('topics_and_raw_types')
    text = dict(zip(raw['topics'], raw['typedefs_full_text'], strict=True))['/known']
    assert text.strip() == 'string data'
    assert ask('message_details', type='moveit_msgs/RobotState')['typedefs'][0]['fieldnames'] == [
        'joint_state', 'multi_dof_joint_state', 'attached_collision_objects', 'is_diff']
    goal = ask('action_goal_details', type='control_msgs/action/FollowJointTrajectory')
    assert goal['typedefs'][0]['fieldnames'][0] == 'trajectory'
    request = ask('service_request_details', type='std_srvs/srv/SetBool')['typedefs'][0]
    assert (request['fieldnames'], request['fieldtypes']) == (['data'], ['bool'])
    assert 'std_msgs/msg/String' in ask('interfaces')['interfaces']


@pytest.mark.parametrize(('service', 'args', 'expected'), [
    ('message_details', {'type': 'no_such/Type'}, {'typedefs': []}),
    ('message_details', {'type': 'os/path'}, {'typedefs': []}),
    ('action_goal_details', {'type': ''}, {'typedefs': []}),
    ('topic_type', {'topic': '/nowhere'}, {'type': ''}),
    ('node_details', {'node': '/nobody'}, {'subscribing': [], 'publishing': [], 'services': []}),
    ('publishers', {'topic': 'not a name'}, {'publishers': []}),
    ('service_node', {'service': 'not a name'}, {'node': ''}),
    ('action_type', {'action': '/nothing'}, {'type': ''}),
])
def test_what_is_not_there_has_an_empty_answer(ask, service, args, expected):
    """No question ends or blocks anything."""
    assert ask(service, **args) == expected


def test_parameters_are_read_and_set(ask, known):
    """As node:name, with values in JSON; a wrong name is answered with those there are."""
    assert ask('get_param', name='/peer:gain') == {
        'value': '1.5', 'successful': True, 'reason': ''}
    assert json.loads(ask('get_param', name='/peer:names')['value']) == ['a', 'b']
    assert ask('set_param', name='/peer:gain', value='2') == {'successful': True, 'reason': ''}
    assert ask('get_param', name='/peer:gain')['value'] == '2.0'
    assert ask('has_param', name='/peer:gain') == {'exists': True}
    assert ask('has_param', name='/peer:pain') == {'exists': False}
    missing = ask('get_param', name='/peer:pain', default_value='7')
    assert (missing['value'], missing['successful']) == ('7', False)
    assert missing['reason'].startswith("node /peer has no parameter pain; did you mean 'gain'?")
    assert ask('get_param', name='/nobody:x')['value'] == '""'
    assert ask('set_param', name='/peer:gain', value='"text"')['successful'] is False
    assert '/peer:gain' in ask('get_param_names')['names']


def test_a_silent_node_blocks_no_question(ask, talk, peer):
    """Its parameters are left out; what was asked after them is answered first."""
    waiting = Future()

    async def answer(_, response):
        await waiting
        return response

    peer.create_service(ListParameters, '/silent/list_parameters', answer,
                        callback_group=ReentrantCallbackGroup())
    deadline = time.monotonic() + PATIENCE
    while '/silent/list_parameters' not in ask('services')['services']:
        assert time.monotonic() < deadline
    client = talk()
    for service in ('get_param_names', 'get_time'):
        client.send('call_service', service=f'/rosapi/{service}', id=service)
    assert client.until('service_response')['id'] == 'get_time'
    names = client.until('service_response')['values']['names']
    peer.executor.create_task(waiting.set_result, None)
    assert '/peer:gain' in names
    assert not any(name.startswith('/silent') for name in names)


def test_services_of_ros_answer_the_same(peer, bridge, known):
    """A program with ROS uses them as services."""
    client = peer.create_client(TopicType, '/rosapi/topic_type')
    assert client.wait_for_service(10)
    done = threading.Event()
    answer = client.call_async(TopicType.Request(topic='/known'))
    answer.add_done_callback(lambda _: done.set())
    assert done.wait(10)
    assert answer.result().type == 'std_msgs/msg/String'


def test_connected_clients_are_published(peer, bridge, talk):
    """Their number is latched."""
    counts, changed = [], threading.Event()
    talk().settle()
    peer.create_subscription(Int32, '/client_count', lambda message: (
        counts.append(message.data), message.data >= 1 and changed.set()), LATCHED)
    assert changed.wait(10), counts
