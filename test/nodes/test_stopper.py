# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Requests to stop, and the event that follows them."""

import queue
import time

from action_msgs.srv import CancelGoal
import pytest
from std_msgs.msg import String

from armsim_ros.clients.motion import Stopper
from armsim_ros.clients.node import SpinningNode
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.testing.program import private_domain

ACTION = '/slow/follow_joint_trajectory'


@pytest.mark.parametrize('answers', [True, False])
def test_the_event_follows_the_answers_unless_they_keep_it_waiting(answers):
    """A goal that it would end first is counted; an action that is silent does not stop a stop."""
    log, release = queue.Queue(), queue.Queue()

    def cancel(_request, response):
        log.put('asked')
        if not answers:
            release.get()
        log.put('answered')
        return response

    with private_domain() as domain, SpinningNode('server', domain=domain) as server, \
            SpinningNode('listener', domain=domain) as listener, \
            RosClient('stopper', domain=domain) as client:
        kept = [
            server.in_thread(lambda: server.node.create_service(
                CancelGoal, f'{ACTION}/_action/cancel_goal', cancel)),
            listener.in_thread(lambda: listener.node.create_subscription(
                String, '/trajectory_execution_event', lambda message: log.put(message.data), 10))]
        stopper = Stopper(client)
        client.prepare(CancelGoal, f'{ACTION}/_action/cancel_goal')
        deadline = time.monotonic() + 20.0
        while not stopper.hears(ACTION) or not client.in_thread(
                stopper._publisher.get_subscription_count).result():
            assert time.monotonic() < deadline
        (answer,) = stopper.stop([ACTION])
        order = [log.get(timeout=10.0) for _ in range(3 if answers else 2)]
        assert order == (['asked', 'answered', 'stop'] if answers else ['asked', 'stop'])
        release.put(None)
        assert answer.result(10.0) is not None
        assert all(kept)
