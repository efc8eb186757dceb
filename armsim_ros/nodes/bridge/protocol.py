# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The operations of rosbridge v2: their fields, what is allowed, what answers a failure."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
import traceback
from typing import Any

from action_msgs.msg import GoalStatus

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.nodes.bridge.advertised import AdvertisedActions, AdvertisedServices
from armsim_ros.nodes.bridge.calls import Goals, ServiceCalls
from armsim_ros.nodes.bridge.client import Client, Handler
from armsim_ros.nodes.bridge.frames import parse, SMALLEST_FRAGMENT
from armsim_ros.nodes.bridge.incoming import aside
from armsim_ros.nodes.bridge.interfaces import Level, RefusalError
from armsim_ros.nodes.bridge.link import BridgeLink
from armsim_ros.nodes.bridge.permissions import Permissions
from armsim_ros.nodes.bridge.publishers import Publishers
from armsim_ros.nodes.bridge.topics import Topics

_KINDS = {
    'string': (str,), 'number': (int, float), 'integer': (int,), 'boolean': (bool,),
    'string or integer': (str, int), 'object': (dict,), 'list or object': (dict, list),
    'anything': (object,),
}
_OPTIONAL = {'id': 'string or integer'}
_TEXTS = {'compression': 'string', 'fragment_size': 'integer'}
#: Operation -> its required fields, and its optional fields.
FIELDS: Mapping[str, tuple[dict[str, str], dict[str, str]]] = {
    'advertise': ({'topic': 'string', 'type': 'string'},
                  {'latch': 'boolean', 'queue_size': 'integer'}),
    'unadvertise': ({'topic': 'string'}, {}),
    'publish': ({'topic': 'string'}, {
        'msg': 'object', 'latch': 'boolean', 'queue_size': 'integer'}),
    'subscribe': ({'topic': 'string'}, {
        'type': 'string', 'throttle_rate': 'number', 'queue_length': 'integer', **_TEXTS}),
    'unsubscribe': ({'topic': 'string'}, {}),
    'call_service': ({'service': 'string'}, {
        'args': 'list or object', 'type': 'string', 'timeout': 'number', **_TEXTS}),
    'advertise_service': ({'service': 'string', 'type': 'string'}, {}),
    'unadvertise_service': ({'service': 'string'}, {}),
    'service_response': ({}, {'service': 'string', 'values': 'list or object',
                              'result': 'boolean'}),
    'send_action_goal': ({'action': 'string', 'action_type': 'string'}, {
        'args': 'list or object', 'feedback': 'boolean', **_TEXTS}),
    'cancel_action_goal': ({'action': 'string'}, {}),
    'advertise_action': ({'action': 'string', 'type': 'string'}, {}),
    'unadvertise_action': ({'action': 'string'}, {}),
    'action_feedback': ({}, {'action': 'string', 'values': 'list or object'}),
    'action_result': ({}, {'action': 'string', 'values': 'list or object',
                           'result': 'boolean', 'status': 'integer'}),
    'fragment': ({'id': 'string or integer', 'data': 'string', 'num': 'integer',
                  'total': 'integer'}, {}),
    'set_level': ({}, {'level': 'string'}),
    'status': ({}, {'id': 'anything'}),
    'auth': ({}, {'id': 'anything'}),
}


class Protocol:
    """Hands each message of a client to the part that serves it."""

    def __init__(
        self, link: BridgeLink, permissions: Permissions, topics: Topics, publishers: Publishers,
        calls: ServiceCalls, services: AdvertisedServices, goals: Goals,
        actions: AdvertisedActions,
    ) -> None:
        self._link, self._permissions = link, permissions
        self._topics, self._publishers, self._goals = topics, publishers, goals
        self._services, self._actions = services, actions
        self._handlers: dict[str, Handler] = {
            'advertise': publishers.advertise, 'unadvertise': publishers.unadvertise,
            'publish': publishers.publish,
            'subscribe': topics.subscribe, 'unsubscribe': topics.unsubscribe,
            'call_service': calls.call,
            'advertise_service': services.advertise, 'unadvertise_service': services.unadvertise,
            'service_response': services.respond,
            'send_action_goal': goals.send, 'cancel_action_goal': goals.cancel,
            'advertise_action': actions.advertise, 'unadvertise_action': actions.unadvertise,
            'action_feedback': actions.feedback, 'action_result': actions.result,
            'fragment': self._fragment, 'set_level': _set_level, 'status': _ignore,
            'auth': _ignore,
        }

    async def receive(self, client: Client, frame: str | bytes) -> None:
        """Serve a frame of a client; whatever it holds, the client hears of a failure."""
        try:
            message = await aside(len(frame), parse, frame)
        except RefusalError as error:
            client.report(error.level, str(error))
            return
        await self.serve(client, message)

    async def serve(self, client: Client, message: dict[str, Any]) -> None:
        """Serve a message; what may take long is served beside the next ones."""
        work = self._serve(client, message)
        if message.get('op') == 'call_service':
            client.start(work)
        elif message.get('op') == 'send_action_goal':
            self._goals.start(work)
            await asyncio.sleep(0)  # it is known before the client's next message cancels it
        else:
            await work

    async def _serve(self, client: Client, message: dict[str, Any]) -> None:
        op = message.get('op')
        try:
            op = check_fields(message)
            self._check_permission(op, message)
            await self._handlers[op](client, message)
        except ArmsimError as error:
            level = getattr(error, 'level', Level.ERROR)
            _answer_failure(client, op, message, str(error), level)
        except Exception as error:  # noqa: BLE001 - no message may end a connection
            self._link.node.get_logger().error(
                f'{op} failed inside the program; please report this:\n{traceback.format_exc()}')
            text = f'failed inside the bridge: {type(error).__name__}: {error}'
            _answer_failure(client, op, message, text, Level.ERROR)

    async def drop(self, client: Client) -> None:
        """End what a client has left."""
        client.close()
        self._topics.drop(client)
        self._publishers.drop(client)
        self._goals.drop(client)
        await self._services.drop(client)
        await self._actions.drop(client)

    def _check_permission(self, op: str, message: dict[str, Any]) -> None:
        for kind in ('topic', 'service', 'action'):
            if kind in FIELDS[op][0]:
                name = self._link.expand(message[kind], service=kind == 'service')
                self._permissions.check(op, kind, name)

    async def _fragment(self, client: Client, message: dict[str, Any]) -> None:
        text = client.fragments.add(
            message['id'], message['data'], message['num'], message['total'],
            self._link.loop.time())
        if text is not None:
            whole = await aside(len(text), parse, text)
            if whole.get('op') == 'fragment':
                raise RefusalError('a fragment of fragments')
            await self.serve(client, whole)


def check_fields(message: dict[str, Any]) -> str:
    """
    Check the fields of a message and return its operation.

    An optional field that is null counts as missing.

    :raises RefusalError: a field is missing or of the wrong kind.
    """
    op = message.get('op')
    if not isinstance(op, str) or op not in FIELDS:
        hint = f'; {nearest(op, tuple(FIELDS))}' if isinstance(op, str) else ''
        raise RefusalError(f'op must be one of {", ".join(FIELDS)}{hint.rstrip("; ")}')
    required, optional = FIELDS[op]
    for name, kind in required.items():
        if name not in message:
            raise RefusalError(f'{name} is missing: {kind}')
    for name, kind in (*required.items(), *optional.items(), *_OPTIONAL.items()):
        value = message.get(name)
        if value is None:
            if name in required:
                raise RefusalError(f'{name} is null; it must be: {kind}')
            continue
        fits = isinstance(value, _KINDS[kind])
        if isinstance(value, bool) and kind not in ('boolean', 'anything'):
            fits = False
        if not fits and not (name == 'id' and 'id' in optional):
            raise RefusalError(f'{name} must be: {kind}; it is a JSON {_json_kind(value)}')
    size = message.get('fragment_size')
    if size and size < SMALLEST_FRAGMENT:
        raise RefusalError(f'fragment_size is {size}; the smallest is {SMALLEST_FRAGMENT}')
    return op


def _json_kind(value: Any) -> str:
    names = {bool: 'boolean', str: 'string', int: 'number', float: 'number', list: 'list',
             dict: 'object'}
    return names.get(type(value), 'null')


def _answer_failure(client: Client, op: Any, message: dict[str, Any], text: str, level: Level
                    ) -> None:
    """Inform a client of a failure: by the answer it waits for, else by a status message."""
    target = next((message[name] for name in ('topic', 'service', 'action')
                   if isinstance(message.get(name), str)), '')
    key = message.get('id')
    whole = f'{target[:200]}: {text}' if target else text
    answer: dict[str, Any] | None = None
    if op == 'call_service':
        answer = {'op': 'service_response', 'service': target, 'values': whole, 'result': False}
    elif op == 'send_action_goal':
        answer = {'op': 'action_result', 'action': target, 'values': whole,
                  'status': GoalStatus.STATUS_UNKNOWN, 'result': False}
    if answer is None:
        known = f'{op} ' if isinstance(op, str) and op in FIELDS else ''
        separator = '' if target or not known else ': '
        client.report(level, f'{known.rstrip()}{separator or " " if known else ""}{whole}', key)
    else:
        client.send(answer, key)


async def _set_level(client: Client, message: dict[str, Any]) -> None:
    name = message.get('level', 'error')
    names = [level.name.lower() for level in Level]
    if name not in names:
        raise RefusalError(f"level is '{name[:100]}'; allowed: {', '.join(names)}")
    client.level = Level[name.upper()]


async def _ignore(_client: Client, _message: dict[str, Any]) -> None:
    """Take what needs no answer."""
