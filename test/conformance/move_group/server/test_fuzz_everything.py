# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Random messages to every service, topic and action that the graph shows.

``--fuzz N`` sends ten times N; many more come from ``python -m benchmarks fuzz``.
"""

from __future__ import annotations

from typing import Any

import pytest

from armsim_ros.clients.client_node import ClientNode
from benchmarks.endurance.fuzz import Fuzz

DEFAULT = 15


@pytest.mark.statement('ERR-2', 'SCN-2a')
def test_every_endpoint_withstands_anything(
    pytestconfig: pytest.Config, own_arm: Any, own_server: Any
) -> None:
    """Requests are answered, refused edits change nothing, the arm stands, and all works on."""
    arm, server = own_arm, own_server
    names = (arm.group, arm.frame, arm.tip, *arm.group_joints[:3], 'ompl', 'RRTConnect', 'LIN')
    with ClientNode(server.domain, 'fuzz') as client:
        fuzz = Fuzz(client, arm.joint_states.topic, names, namespace=server.namespace,
                    left_out=tuple(ClientNode.names))
        fuzz.run(10 * int(pytestconfig.getoption('fuzz', None) or DEFAULT))
    assert not fuzz.faults
    assert fuzz.sent['refused edits']
    assert fuzz.sent['goals accepted']
    assert arm.move(arm.near(0.05)).code == 'SUCCESS'
    if server.program is not None:
        assert 'Traceback' not in server.program.text
        assert 'please report' not in server.program.text
        assert server.program.process.poll() is None
