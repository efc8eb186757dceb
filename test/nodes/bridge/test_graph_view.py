# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What clients see of a graph, without a middleware.

The tests re-enact rosapi's proxy.py: filter_globs, any_match, and the hidden names of ros2cli.
"""

import asyncio

import pytest
from rosapi_msgs import srv

from armsim_ros.nodes.bridge.graph_view import GraphView
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.rosapi import RosApi
from armsim_ros.nodes.bridge.settings import BridgeSettings

TOPICS = {'/joint_states': ['sensor_msgs/msg/JointState'], '/_hidden': ['std_msgs/msg/String'],
          '/secret': ['std_msgs/msg/String'],
          '/move/_action/feedback': ['moveit_msgs/action/MoveGroup_FeedbackMessage']}
SERVICES = {'/plan': ['std_srvs/srv/Trigger'], '/secret': ['std_srvs/srv/Trigger'],
            '/_hidden': ['std_srvs/srv/Trigger'],
            '/move/_action/send_goal': ['moveit_msgs/action/MoveGroup_SendGoal']}


class End:
    """An end of a topic."""

    node_namespace = '/'

    def __init__(self, name):
        self.node_name = name


class Node:
    """A node that knows a graph of two nodes, one of them hidden, which have all names each."""

    def get_node_names_and_namespaces(self):
        """Return both."""
        return [('move_group', '/'), ('_reader', '/')]

    def get_topic_names_and_types(self):
        """Return the topics."""
        return list(TOPICS.items())

    def get_service_names_and_types(self):
        """Return the services."""
        return list(SERVICES.items())

    def count_services(self, _):
        """Return how many serve one."""
        return 2

    def get_subscriber_names_and_types_by_node(self, *_):
        """Return all."""
        return list(TOPICS.items())

    get_publisher_names_and_types_by_node = get_subscriber_names_and_types_by_node

    def get_service_names_and_types_by_node(self, *_):
        """Return all."""
        return list(SERVICES.items())

    def get_publishers_info_by_topic(self, _):
        """Return both."""
        return [End('move_group'), End('_reader')]

    get_subscriptions_info_by_topic = get_publishers_info_by_topic


class Link(BridgeLink):
    """A link to that graph."""

    def __init__(self):
        self.node = Node()

    def expand(self, name, *, service=False):
        """Return a full name."""
        return name if name.startswith('/') else f'/{name}'


@pytest.fixture
def view():
    """Return a function that returns what patterns show."""
    return lambda **settings: GraphView(Link(), Permissions.of(BridgeSettings(**settings)))


def test_hidden_names_are_left_out(view):
    """Actions are not hidden."""
    found = view()
    assert list(found.topics()) == ['/joint_states', '/secret']
    assert list(found.services()) == ['/plan', '/secret']
    assert found.actions() == {'/move': 'moveit_msgs/action/MoveGroup'}
    assert found.nodes() == ['/move_group']
    assert found.node_details('/move_group') == [
        ['/joint_states', '/secret'], ['/joint_states', '/secret'], ['/plan', '/secret']]
    assert found.node_details('/_reader') == [[], [], []]
    assert found.providers(['/plan']) == ['/move_group']
    assert found.ends('/secret', publish=True) == ['/move_group']
    assert found.ends('/secret', publish=False) == ['/move_group']


def test_names_that_match_no_pattern_are_left_out(view):
    """Lists, types and the nodes at their ends."""
    found = view(topics_glob=('/joint_*',), services_glob=('/pl*',), actions_glob=('/other',))
    assert list(found.topics()) == ['/joint_states']
    assert list(found.services()) == ['/plan']
    assert found.actions() == {}
    assert found.node_details('/move_group') == [['/joint_states'], ['/joint_states'], ['/plan']]
    assert (found.topic_type('joint_states'), found.topic_type('/secret')) == (
        'sensor_msgs/msg/JointState', '')
    assert (found.service_type('/plan'), found.service_type('/secret')) == (
        'std_srvs/srv/Trigger', '')
    assert found.action_type('/move') == ''
    assert found.providers(['/secret']) == []
    assert found.ends('/secret', publish=True) == []


def test_read_only_hides_nothing(view):
    """It limits what clients do, not what they see."""
    assert list(view(read_only=True).services()) == ['/plan', '/secret']


def answer(settings, name, /, **request):
    """Return the response of a service of rosapi."""
    kind = getattr(srv, name)
    api = RosApi(Link(), settings, is_shared=False)
    return next(asyncio.run(respond(kind.Request(**request)))
                for found, respond in api.services.values() if found is kind)


def test_rosapi_shows_what_the_arguments_allow():
    """Names and types belong together."""
    found = answer(BridgeSettings(topics_glob=('/joint_*',)), 'Topics')
    assert (found.topics, found.types) == (['/joint_states'], ['sensor_msgs/msg/JointState'])


@pytest.mark.parametrize(('default', 'value'), [
    ('abc', '"abc"'), ('"abc"', '"abc"'), ('[1, 2]', '[1,2]'), ('', '""'), ('1.5', '1.5')])
def test_a_missing_parameter_has_its_default_as_json(default, value):
    """Also where that is not JSON (rosapi's params.py, get_param)."""
    found = answer(BridgeSettings(), 'GetParam', name='/nobody:x', default_value=default)
    assert (found.value, found.successful) == (value, False)


def test_hidden_names_can_be_included():
    """Re-enacts ros2_foxglove_bridge.cpp, updateAdvertisedTopics with include_hidden."""
    found = GraphView(Link(), Permissions.of(BridgeSettings()), include_hidden=True)
    assert {'/_hidden', '/joint_states', '/move/_action/feedback'} <= set(found.topics())
    assert '/_reader' in found.nodes()
