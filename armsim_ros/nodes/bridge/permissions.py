# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What clients may use, by the arguments of the bridge."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
import re

from armsim_ros.nodes.bridge.refusal import RefusalError
from armsim_ros.nodes.bridge.settings import BridgeSettings

#: Operations that change something, or may.
_CHANGING = {'publish', 'advertise', 'advertise_service', 'advertise_action', 'send_action_goal',
             'cancel_action_goal'}
#: Services that only read, by the last part of their name; in rosapi, all but these.
_READING = re.compile(r'(get|list|describe)_\w+')
_ROSAPI = '/rosapi/'
_ROSAPI_CHANGING = ('set_param', 'delete_param', 'set_parameters', 'set_parameters_atomically')


@dataclass(frozen=True)
class Permissions:
    """
    What clients may use; an empty list of patterns allows all names.

    :param read_only: nothing that changes or moves anything.
    """

    topics: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    read_only: bool = False

    @classmethod
    def of(cls, settings: BridgeSettings) -> Permissions:
        """Return what the arguments allow."""
        return cls(settings.topics_glob, settings.services_glob, settings.actions_glob,
                   settings.read_only)

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

        :param kind: topic, service or action.
        :param name: the full name.
        :raises RefusalError: it is not allowed.
        """
        patterns: tuple[str, ...] = getattr(self, f'{kind}s')
        if patterns and not any(fnmatchcase(name, pattern) for pattern in patterns):
            raise RefusalError(f'not allowed here: {kind}s_glob is [{", ".join(patterns)}]')
        if self.read_only and (op in _CHANGING or (op == 'call_service' and not _reads(name))):
            raise RefusalError('not allowed here: read_only')


def _reads(service: str) -> bool:
    if service.startswith(_ROSAPI):
        return service.removeprefix(_ROSAPI) not in _ROSAPI_CHANGING
    return _READING.fullmatch(service.rpartition('/')[2]) is not None
