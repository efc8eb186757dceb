# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When a command knows the whole graph."""

import socket
from types import SimpleNamespace

import pytest

from armsim_ros2 import discovery

DOMAIN = 100
#: The first port for discovery in the domain.
PORT = 7400 + 250 * DOMAIN + 10


class Node:
    """
    A node that learns more of the graph with each period.

    :param views: of the graph: number of programs, nodes, names of services, half-known services,
        and number of programs that are known by no more than their existence.
    """

    def __init__(self, views):
        self._views = list(views)
        self.context = SimpleNamespace(get_domain_id=lambda: DOMAIN)
        self.periods = 0

    @property
    def view(self):
        """The present view."""
        return self._views[min(self.periods, len(self._views) - 1)]

    def get_node_names(self):
        """Return as many names as there are nodes."""
        return ['node'] * self.view[1]

    def get_node_names_and_namespaces(self):
        """Return no node in detail."""
        return []

    def get_topic_names_and_types(self):
        """Return no topics."""
        return []

    def get_service_names_and_types(self):
        """Return the services."""
        return [(name, ['a/srv/B']) for name in self.view[2]]

    def get_publishers_info_by_topic(self, topic, no_mangle=False):
        """Return one publisher per program, or those of a service."""
        silent = sum(self.view[4:])
        if topic in ('ros_discovery_info', '/parameter_events'):
            count = self.view[0] - (silent if topic == '/parameter_events' else 0)
            return [SimpleNamespace(node_name='node', endpoint_gid=[number] * 16)
                    for number in range(count)]
        return [None] * (no_mangle and topic[2:-5] not in self.view[3])

    def get_subscriptions_info_by_topic(self, topic, no_mangle):
        """Return one subscription of each service."""
        return [None]


@pytest.fixture
def settled(monkeypatch):
    """Give a function that settles on views of a graph and returns the number of periods."""
    def run(*views, programs=2, range_='LOCALHOST'):
        node = Node(views)

        def sleep(seconds):
            node.periods += 1

        monkeypatch.setattr(discovery.time, 'sleep', sleep)
        monkeypatch.setattr(discovery, 'local_programs', lambda domain: programs)
        monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', range_)
        discovery.settle(node, 0.5)
        return node.periods

    return run


def test_a_known_graph_is_complete_when_it_is_quiet(settled):
    """Nothing new for five periods of 20 ms."""
    assert settled((2, 2, ['/a'], ())) == 5
    assert settled((1, 1, [], ()), (1, 2, [], ()), (2, 3, ['/a'], ())) == 2 + 5


def test_programs_of_other_machines_have_time_to_announce_themselves_again(settled):
    """Sixteen periods of 20 ms where they are discovered, which may be quiet ones."""
    assert settled((2, 2, ['/a'], ()), range_='SUBNET') == 16
    assert settled(*[(1, 1, [], ())] * 14, (2, 2, ['/a'], ()), range_='SUBNET') == 14 + 5


def test_programs_of_this_machine_are_waited_for(settled):
    """A program with a port that has not been discovered, also beyond the spin time."""
    assert settled(*[(1, 2, [], ())] * 60, (2, 3, [], ())) == 60
    assert settled(*[(2, 3, ['/a'], ('/a',))] * 40, (2, 3, ['/a'], ())) == 40


def test_the_nodes_of_a_program_are_waited_for(settled):
    """A busy program is known to exist before anything of its nodes arrives."""
    assert settled(*[(2, 1, [], (), 1)] * 40, (2, 2, ['/a'], ())) == 40


def test_waiting_ends_if_a_program_never_answers(settled):
    """Such as one that uses DDS without ROS."""
    assert settled((1, 2, [], ()), programs=5) == 25 + 60


def test_alone_in_the_graph_the_spin_time_is_waited(settled):
    """No other node: others may be on other machines."""
    assert settled((1, 1, [], ()), programs=1) == 25


def test_programs_are_counted_by_their_ports():
    """The ports for discovery have even numbers from the first of a domain."""
    assert discovery.local_programs(DOMAIN) == 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as data, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
        for offset, endpoint in enumerate((first, data, second)):
            endpoint.bind(('127.0.0.1', PORT + offset))
        assert discovery.local_programs(DOMAIN) == 2
