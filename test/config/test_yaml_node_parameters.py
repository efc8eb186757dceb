# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which parameters of a file are a node's, by rcl's rules for node names."""

from armsim_ros.config.yaml_node import parameters_of_node
from armsim_ros.config.yaml_source import parse_yaml

FILE = """
/left/arm:
  ros__parameters: {gains.x.p: 2.0}
/**:
  ros__parameters: {gains: {x: {p: 1.0, d: 0.5}}}
  /*/arm:
    ros__parameters: {joints: [x]}
/right/arm:
  ros__parameters: {joints: [y]}
"""


def test_parameters_of_a_node():
    """Wildcards come first, so that what names the node wins; dots mean depth."""
    block = parameters_of_node(parse_yaml(FILE, 'f'), 'arm', '/left')
    assert block.plain() == {'gains': {'x': {'p': 2.0, 'd': 0.5}}, 'joints': ['x']}
    assert parameters_of_node(parse_yaml('a: {b: 1}', 'f'), 'arm', '/left') is None
