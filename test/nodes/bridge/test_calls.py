# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Time limits of calls, and goals before they are sent, without a middleware."""

import asyncio
from concurrent.futures import Future
import json
from types import SimpleNamespace
from unittest.mock import Mock

from action_msgs.msg import GoalStatus
import pytest
from std_srvs.srv import Trigger
from tf2_msgs.action import LookupTransform

from armsim_ros.nodes.bridge.calls import Goals, ServiceCalls
from armsim_ros.nodes.bridge.client import Client
from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.protocol import Protocol
from armsim_ros.nodes.bridge.settings import BridgeSettings


async def next_answer(client):
    """Return the next answer of a client as an object."""
    await asyncio.wait_for(client.outbox.wait(), 10.0)
    frame = b''.join(await client.outbox.take())
    return json.loads(frame[frame.index(b'{"'):])


def make_client():
    """Return a client."""
    return Client('', 1 << 20, 30.0, list)


class Link:
    """The part of a link that calls and goals use; a server appears when the test wants it."""

    def __init__(self):
        self.appeared, self.sent, self.runs = asyncio.Event(), [], []

    def now(self):
        """Return a time."""
        return 1, 2

    def expand(self, name, *, service=False):
        """Return a full name."""
        return name

    async def load(self, name, group):
        """Return the type of these tests."""
        return LookupTransform

    async def wait_for_action(self, kind, name):
        """Wait for the server."""
        await self.appeared.wait()

    def goal(self, kind, action, request, feedback):
        """Note the goal, which succeeds at once."""
        self.sent.append(request)
        run = SimpleNamespace(result=Future())
        run.result.set_result(SimpleNamespace(
            status=GoalStatus.STATUS_SUCCEEDED, result=kind.Result()))
        return run


@pytest.mark.parametrize(('timeout', 'default', 'is_answered'), [
    (None, 0.01, False), (None, 0.0, True), (0.01, 0.0, False), (0, 0.01, True), (-1, 0.01, True)])
def test_a_timeout_that_is_not_positive_is_none(timeout, default, is_answered):
    """The default holds only where a call names none, as roslib documents it."""
    async def run():
        gate, client = asyncio.Event(), make_client()

        async def respond(_):
            asyncio.get_running_loop().call_later(0.1, gate.set)
            await gate.wait()
            return Trigger.Response(message='done')

        calls = ServiceCalls(Link(), {'/slow': (Trigger, respond)}, default)
        work = calls.call(client, {'op': 'call_service', 'service': '/slow', 'timeout': timeout})
        if is_answered:
            await work
            assert (await next_answer(client))['values']['message'] == 'done'
        else:
            with pytest.raises(RefusalError, match='no answer within'):
                await work

    asyncio.run(run())


@pytest.mark.parametrize('is_canceled', [True, False])
def test_a_goal_can_be_canceled_while_its_server_is_waited_for(is_canceled):
    """With the client's next message; the goal is not sent then."""
    async def run():
        link, client = Link(), make_client()
        protocol = Protocol(link, Permissions.of(BridgeSettings()), *(Mock() for _ in range(4)),
                            Goals(link, False), Mock())
        goal = {'action': '/look', 'id': 'first'}
        await protocol.receive(client, json.dumps({
            'op': 'send_action_goal', 'action_type': 'tf2_msgs/LookupTransform', **goal}))
        if is_canceled:
            await protocol.receive(client, json.dumps({'op': 'cancel_action_goal', **goal}))
        link.appeared.set()
        answer = await next_answer(client)
        status = GoalStatus.STATUS_CANCELED if is_canceled else GoalStatus.STATUS_SUCCEEDED
        assert (answer['op'], answer['id'], answer['status'], answer['result']) == (
            'action_result', 'first', status, True)
        assert len(link.sent) == (not is_canceled)

    asyncio.run(run())
