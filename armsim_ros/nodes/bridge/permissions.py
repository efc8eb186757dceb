# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients of the bridge may use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import translate
import re

from armsim_ros.nodes.bridge.interfaces import RefusalError
from armsim_ros.nodes.bridge.settings import BridgeSettings

#: Operations that change something, or may.
_CHANGING = {'publish', 'advertise', 'advertise_service', 'advertise_action', 'send_action_goal',
             'cancel_action_goal'}
#: Services that only read, by the last part of their name; in rosapi, all but these.
_READING = re.compile(r'(get|list|describe)_\w+')
_ROSAPI = '/rosapi/'
_ROSAPI_CHANGING = ('set_param', 'delete_param', 'set_parameters', 'set_parameters_atomically')


@dataclass(frozen=True)
class NamePatterns:
    """
    Patterns of names; a name is allowed if it matches one of them as a whole.

    :param argument: which has the patterns, for refusals.
    :param texts: the patterns as they were given.
    :param expressions: the patterns.
    :param parameter_forms: how the full name of a parameter may be written, to be matched.
    """

    argument: str
    texts: tuple[str, ...]
    expressions: tuple[re.Pattern[str], ...]
    parameter_forms: tuple[str, ...]

    @classmethod
    def globs(cls, argument: str, texts: Sequence[str] = ()) -> NamePatterns:
        """Return globs as rosbridge_server has them; none allow all names."""
        return cls(argument, tuple(texts), tuple(re.compile(translate(text))
                                                 for text in texts or ('*',)),
                   ('{name}', '{node}:{name}'))

    @classmethod
    def whitelist(cls, argument: str, texts: Sequence[str]) -> NamePatterns:
        """
        Return regular expressions as foxglove_bridge has them; none allow no name.

        :raises ValueError: one is not a regular expression.
        """
        try:
            expressions = [re.compile(text, re.IGNORECASE | re.ASCII) for text in texts]
        except re.error as error:
            raise ValueError(
                f'{argument}: {error.pattern!r} is not a regular expression: {error}') from None
        return cls(argument, tuple(texts), tuple(expressions), ('{node}.{name}',))

    def allows(self, name: str) -> bool:
        """Return whether a name matches."""
        return any(expression.fullmatch(name) for expression in self.expressions)

    def allows_parameter(self, node: str, name: str) -> bool:
        """Return whether a parameter of a node matches."""
        return any(self.allows(form.format(node=node, name=name))
                   for form in self.parameter_forms)

    def refusal(self) -> RefusalError:
        """Return the error for a name that does not match."""
        return RefusalError(f'not allowed here: {self.argument} is [{", ".join(self.texts)}]')


@dataclass(frozen=True)
class Permissions:
    """
    What clients may use.

    :param client_topics: topics that clients may publish by Foxglove's protocol.
    :param read_only: nothing that changes or moves anything.
    """

    topics: NamePatterns
    services: NamePatterns
    actions: NamePatterns
    parameters: NamePatterns
    client_topics: NamePatterns
    read_only: bool = False

    @classmethod
    def of(cls, settings: BridgeSettings) -> Permissions:
        """Return what the arguments of the bridge allow."""
        topics = NamePatterns.globs('topics_glob', settings.topics_glob)
        return cls(topics, NamePatterns.globs('services_glob', settings.services_glob),
                   NamePatterns.globs('actions_glob', settings.actions_glob),
                   NamePatterns.globs('params_glob', settings.params_glob), topics,
                   settings.read_only)

    def matches(self, kind: str, name: str) -> bool:
        """
        Return whether a name matches the patterns.

        :param kind: topic, client_topic, service or action.
        :param name: the full name.
        """
        return self._patterns(kind).allows(name)

    def allows(self, op: str, kind: str, name: str) -> bool:
        """Return whether ``check`` accepts an operation on a name."""
        try:
            self.check(op, kind, name)
        except RefusalError:
            return False
        return True

    def check(self, op: str, kind: str, name: str) -> None:
        """
        Check an operation on a name.

        :param kind: topic, client_topic, service or action.
        :param name: the full name.
        :raises RefusalError: it is not allowed.
        """
        if not self.matches(kind, name):
            raise self._patterns(kind).refusal()
        if self.read_only and (op in _CHANGING or (op == 'call_service' and not _reads(name))):
            raise RefusalError('not allowed here: read_only')

    def _patterns(self, kind: str) -> NamePatterns:
        return {'topic': self.topics, 'client_topic': self.client_topics,
                'service': self.services, 'action': self.actions}[kind]


def _reads(service: str) -> bool:
    if service.startswith(_ROSAPI):
        return service.removeprefix(_ROSAPI) not in _ROSAPI_CHANGING
    return _READING.fullmatch(service.rpartition('/')[2]) is not None
