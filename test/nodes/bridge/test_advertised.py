# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services and actions that clients serve, without a middleware."""

import asyncio
from types import SimpleNamespace

from action_msgs.msg import GoalStatus
import pytest
from std_srvs.srv import SetBool
from tf2_msgs.action import LookupTransform

from armsim_ros.nodes.bridge import advertised
from armsim_ros.nodes.bridge.advertised import AdvertisedActions, AdvertisedServices
from armsim_ros.nodes.bridge.interfaces import RefusalError


class Link:
    """The part of a link that they use; both threads are the test's."""

    def __init__(self):
        self.loop = asyncio.get_running_loop()
        self.node, self.destroyed, self.callbacks = self, [], []

    async def run(self, work):
        """Do it now."""
        return work()

    def in_thread(self, work):
        """Do it now."""
        work()

    def schedule(self, work):
        """Do it soon."""
        self.loop.call_soon(work)

    def settle(self, waiting, value):
        """Let what waits go on."""
        if not waiting.done():
            waiting.set_result(value)

    def now(self):
        """Return a time."""
        return 1, 2

    def expand(self, name, *, service=False):
        """Return a full name."""
        return name

    async def load(self, name, group):
        """Return the type of these tests."""
        return {'srv': SetBool, 'action': LookupTransform}[group]

    def create_service(self, kind, name, callback, callback_group):
        """Keep what answers."""
        self.callbacks.append(callback)
        return name

    def destroy_service(self, service):
        """Note it."""
        self.destroyed.append(service)

    def get_logger(self):
        """Return what keeps silent."""
        return SimpleNamespace(warning=lambda _: None)


class Client:
    """A client that keeps what it is sent."""

    def __init__(self):
        self.is_open, self.sent = True, asyncio.Queue()

    def send(self, message):
        """Keep it."""
        self.sent.put_nowait(message)


class Goal:
    """A goal, and how it ended."""

    request = LookupTransform.Goal(target_frame='tool')
    is_cancel_requested = is_active = True

    def __init__(self):
        self.outcomes = []

    def __getattr__(self, name):
        return lambda *_: self.outcomes.append(name)


def test_a_service_belongs_to_its_client():
    """It answers by id; another client is refused, and one that leaves gives default values."""
    async def run():
        link, client = Link(), Client()
        services = AdvertisedServices(link, 0.0)
        await services.advertise(client, {'service': '/mine', 'type': 'std_srvs/SetBool'})
        with pytest.raises(RefusalError, match='another client serves it'):
            await services.advertise(Client(), {'service': '/mine', 'type': 'std_srvs/SetBool'})

        def call():
            return asyncio.ensure_future(
                link.callbacks[0](SetBool.Request(data=True), SetBool.Response()))

        first, second = call(), call()
        requests = [await client.sent.get(), await client.sent.get()]
        assert requests[0] == {'op': 'call_service', 'id': 'service_request:/mine:1',
                               'service': '/mine', 'args': {'data': True}}
        await services.respond(client, {'id': requests[1]['id'], 'values': {'message': 'done'}})
        assert (await second).message == 'done'
        with pytest.raises(RefusalError, match='no request'):
            await services.respond(Client(), {'id': requests[0]['id']})
        await services.drop(client)
        assert (await first, link.destroyed) == (SetBool.Response(), ['/mine'])

    asyncio.run(run())


@pytest.mark.parametrize(('answer', 'expected'), [
    ({'result': True, 'values': {'message': 'open'}}, 'open'),
    ({'result': False, 'values': {'message': 'the door is open'}}, 'the door is open'),
    ({'result': None, 'values': {'message': 'no result'}}, 'no result'),
    ({'result': False, 'values': {}}, ''), ({'result': False}, ''),
], ids=['success', 'failure', 'null', 'failure with nothing', 'failure alone'])
def test_a_response_has_the_values_of_its_client(answer, expected):
    """
    Whatever its result; roslibpy sends what the callback has returned, which may be nothing.

    Re-enacts rosbridge_suite's service_response.py, ServiceResponse.service_response.
    """
    async def run():
        link, client = Link(), Client()
        services = AdvertisedServices(link, 0.0)
        await services.advertise(client, {'service': '/mine', 'type': 'std_srvs/SetBool'})
        waiting = asyncio.ensure_future(
            link.callbacks[0](SetBool.Request(data=True), SetBool.Response()))
        await services.respond(client, {'id': (await client.sent.get())['id'], **answer})
        assert (await waiting).message == expected

    asyncio.run(run())


def test_a_client_that_does_not_answer_gives_default_values():
    """Once its time is over; what it says later is no answer any more."""
    async def run():
        link, client = Link(), Client()
        services = AdvertisedServices(link, 0.01)
        await services.advertise(client, {'service': '/mine', 'type': 'std_srvs/SetBool'})
        found = await link.callbacks[0](SetBool.Request(data=True), SetBool.Response())
        assert found == SetBool.Response()
        request = await client.sent.get()
        with pytest.raises(RefusalError, match='no request'):
            await services.respond(client, {'id': request['id']})

    asyncio.run(run())


@pytest.mark.parametrize(('answer', 'outcome'), [
    ({'status': GoalStatus.STATUS_SUCCEEDED, 'result': True}, 'succeed'),
    ({'status': GoalStatus.STATUS_CANCELED, 'result': True}, 'canceled'),
    ({'result': False}, 'abort'),
    (None, 'abort'),
], ids=['succeeded', 'canceled', 'failed', 'gone'])
def test_a_goal_ends_as_its_client_says(monkeypatch, answer, outcome):
    """With feedback before; without the client it is aborted."""
    made = []

    def server(*arguments, cancel_callback, **_):
        made.append((*arguments, cancel_callback))
        return SimpleNamespace(destroy=lambda: made.append('destroyed'))

    monkeypatch.setattr(advertised, 'ActionServer', server)
    monkeypatch.setattr(advertised, '_LAST_ANSWERS', 0.0)

    async def run():
        client, goal = Client(), Goal()
        actions = AdvertisedActions(Link())
        await actions.advertise(client, {'action': '/do', 'type': 'tf2_msgs/LookupTransform'})
        *_, execute, cancel = made[0]
        ended = asyncio.ensure_future(execute(goal))
        sent = await client.sent.get()
        assert (sent['op'], sent['action_type'], sent['args']['target_frame']) == (
            'send_action_goal', 'tf2_msgs/action/LookupTransform', 'tool')
        await actions.feedback(client, {'id': sent['id'], 'values': {}})
        cancel(goal)
        assert await client.sent.get() == {
            'op': 'cancel_action_goal', 'id': sent['id'], 'action': '/do'}
        if answer is None:
            await actions.drop(client)
            assert made[-1] == 'destroyed'
        else:
            await actions.result(client, {'id': sent['id'], **answer})
        assert isinstance(await ended, LookupTransform.Result)
        assert goal.outcomes == ['publish_feedback', outcome]

    asyncio.run(run())
