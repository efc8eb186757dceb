# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Answers that the middleware cannot deliver."""

from __future__ import annotations

import time
from typing import Any
import warnings

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.watching import log_lost_answers


@pytest.fixture
def node(ros_domain_id: int) -> Any:
    """Give a node that serves and asks."""
    with ClientNode(ros_domain_id, 'server') as client, warnings.catch_warnings():
        log_lost_answers()
        yield client.node


def test_every_lost_answer_is_logged_with_its_service(node: Any, capfd: Any) -> None:
    """
    A client whose reader never matches is named each time.

    rmw_fastrtps_shared_cpp/src/rmw_response.cpp: __rmw_send_response.
    """
    answered = []
    node.create_service(Trigger, '/deaf', lambda _, response: answered.append(1) or response)
    client = node.create_client(Trigger, '/deaf', qos_profile=QoSProfile(
        depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL))
    text, lost = '', 0
    while lost < 2:
        # Nothing tells that the server has found the client's writer: it will with time.
        client.call_async(Trigger.Request())
        asked, before = time.monotonic(), lost
        while time.monotonic() < asked + 1.0 or len(answered) > lost:
            assert time.monotonic() < asked + 30.0, 'an answer is neither delivered nor logged'
            text += capfd.readouterr().err
            lost = text.count("a client of '/deaf' gets no answer")
            if lost == len(answered) > before:
                break
