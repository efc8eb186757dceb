# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reading the parameters of many nodes."""

import asyncio
import logging
from types import SimpleNamespace

import pytest
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import Parameter

from armsim_ros.nodes.bridge import parameters as module
from armsim_ros.nodes.bridge.parameters import Parameters
from armsim_ros.nodes.bridge.permissions import NamePatterns

NODES = {'/arm': {'speed': 1.5, 'name': 'six'}, '/base': {'wheels': 4}}


class Graph:
    """The link to nodes, of which some do not answer."""

    def __init__(self, silent=()):
        self.silent, self.calls = silent, []
        self.node = SimpleNamespace(get_logger=lambda: logging.getLogger('graph'))

    def expand(self, name):
        """Return a full name."""
        return name

    def service_types(self):
        """Return the services of all nodes."""
        return {f'{node}/{service}': [] for node in NODES
                for service in ('list_parameters', 'get_parameters')}

    async def call_when_ready(self, kind, name, request):
        """Answer as a node of rclcpp: one unknown name, and there are no values."""
        node, _, service = name.rpartition('/')
        self.calls.append((node, service))
        if node in self.silent:
            await asyncio.get_running_loop().create_future()
        response = kind.Response()
        if kind is ListParameters:
            response.result.names = list(NODES[node])
        elif kind is GetParameters and set(request.names) <= set(NODES[node]):
            response.values = [Parameter('value', value=NODES[node][each]).get_parameter_value()
                               for each in request.names]
        return response


@pytest.fixture
def patience(monkeypatch):
    """Do not wait long."""
    monkeypatch.setattr(module, '_PATIENCE', 0.01)


def of(graph, **options):
    """Return the parameters of a graph."""
    return Parameters(graph, NamePatterns.globs('params_glob'), **options)


def test_each_node_is_asked_once_for_all_its_values():
    """Re-enacts parameter_interface.cpp, getNodeParameters."""
    graph = Graph()
    found = asyncio.run(of(graph).all_values())
    assert found == {'/arm:speed': 1.5, '/arm:name': 'six', '/base:wheels': 4}
    assert sorted(graph.calls) == sorted(
        (node, service) for node in NODES for service in ('list_parameters', 'get_parameters'))


def test_a_silent_node_loses_only_its_own_values(patience):
    """Re-enacts parameter_interface.cpp, getParams: the others are returned."""
    found = asyncio.run(of(Graph(silent={'/base'})).all_values())
    assert found == {'/arm:speed': 1.5, '/arm:name': 'six'}


@pytest.mark.parametrize('ignores', [True, False])
def test_a_silent_node_may_be_left_out_from_then_on(patience, ignores):
    """Re-enacts parameter_interface.cpp, getParams with UnresponsiveNodePolicy."""
    graph = Graph(silent={'/base'})

    async def read_twice():
        parameters = of(graph, ignores_silent=ignores)
        await parameters.all_values()
        graph.silent = ()
        return await parameters.all_values()

    assert ('/base:wheels' in asyncio.run(read_twice())) is not ignores


def test_named_values_are_read_by_node_and_unknown_names_are_left_out():
    """An unknown name, for which rclcpp returns no values at all, takes none with it."""
    graph = Graph()
    found = asyncio.run(of(graph).values(
        ['/arm:speed', '/arm:name', '/base:none', '/base:wheels', '/nobody:x', 'wrong']))
    assert found == {'/arm:speed': 1.5, '/arm:name': 'six', '/base:wheels': 4}
    assert graph.calls.count(('/arm', 'get_parameters')) == 1


def test_a_pattern_hides_values():
    """Of all parameters and of named ones."""
    parameters = Parameters(Graph(), NamePatterns.whitelist('param_whitelist', [r'/arm\.s.*']))
    assert asyncio.run(parameters.all_values()) == {'/arm:speed': 1.5}
    assert asyncio.run(parameters.values(['/arm:speed', '/arm:name'])) == {'/arm:speed': 1.5}
