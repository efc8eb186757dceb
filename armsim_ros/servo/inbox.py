# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which command holds now: types, stamps, age; and what was wrong with the others."""

from __future__ import annotations

from collections.abc import Callable
import math

from armsim_ros.servo.commands import Command, CommandType, InvalidCommandError

FARTHEST_AHEAD_NS = 500_000_000
"""A stamp farther in the future comes from another clock [ns]."""
COMPLAINT_NS = 250_000_000
"""How long an error is reported [ns]."""

_SERVICE = '~/switch_command_type'
_NUMBERS = ', '.join(f'{kind.value} for {kind.name}' for kind in CommandType)


class CommandInbox:
    """
    Keeps the newest command that may be followed, and why others may not.

    :param timeout_ns: a command this old moves nothing any more [ns].
    """

    def __init__(self, timeout_ns: int) -> None:
        """Start without command and without a chosen type."""
        self.timeout_ns = timeout_ns
        self.type: CommandType | None = None
        #: Whether the first command chooses the type.
        self.topic_chooses = False
        #: Whether the last command has become too old; not where it was refused or forgotten.
        self.ceased = False
        self._command: Command | None = None
        self._expires_ns = 0
        self._complaint = ''
        self._complaint_ns = 0

    def choose(self, kind: CommandType) -> None:
        """Follow commands of this type from now on."""
        if kind is not self.type:
            self._command = None
        self.type = kind
        self._complaint = ''

    def forget(self) -> None:
        """Follow only commands that come from now on."""
        self._command = None
        self._complaint = ''
        self.ceased = False

    def receive(
        self, kind: CommandType, read: Callable[[], Command], stamp_ns: int, now_ns: int
    ) -> None:
        """
        Take a command.

        :param read: makes it; InvalidCommandError names the wrong field.
        :param stamp_ns: 0 is now.
        """
        refusal = self._refusal(kind, stamp_ns, now_ns)
        if refusal:
            if self.command(now_ns) is None:  # else a stream is followed, and the status is its
                self.complain(refusal, now_ns)
            return
        try:
            command = read()
        except InvalidCommandError as error:
            self._command = None
            self.complain(str(error), now_ns)
            return
        self._command = command
        self._complaint = ''
        self.ceased = False
        # A stamp ahead of us must not let the command live longer.
        self._expires_ns = min(stamp_ns or now_ns, now_ns) + self.timeout_ns

    def complain(self, text: str, now_ns: int) -> None:
        """Report a finding for a while."""
        self.ceased = False
        self._complaint, self._complaint_ns = text, now_ns

    def reject(self, text: str, now_ns: int) -> None:
        """Drop the command that holds, and report why."""
        self._command = None
        self.complain(text, now_ns)

    def command(self, now_ns: int) -> Command | None:
        """Return the command to follow, None where there is none or it is too old."""
        if self._command is not None and now_ns >= self._expires_ns:
            self._command = None
            self.ceased = True
        return self._command

    def left(self, now_ns: int) -> float:
        """Return how long the command still holds [s]; infinite where there is none."""
        return math.inf if self._command is None else (self._expires_ns - now_ns) * 1e-9

    @property
    def silent(self) -> bool:
        """Whether there is no command, and nothing to report."""
        return self._command is None and not self._complaint

    def complaint(self, now_ns: int) -> str:
        """Return what was wrong with a command of late, '' where nothing was."""
        if self._complaint and not 0 <= now_ns - self._complaint_ns < COMPLAINT_NS:
            self._complaint = ''
        return self._complaint

    def _refusal(self, kind: CommandType, stamp_ns: int, now_ns: int) -> str:
        if self.type is None and self.topic_chooses:
            self.type = kind
        if self.type is None:
            return f'no command type is chosen; call {_SERVICE} with {_NUMBERS}'
        if kind is not self.type:
            return (
                f'a {kind.name} command came and {self.type.name} is chosen; call {_SERVICE} '
                f'with {kind.value}'
            )
        if stamp_ns:
            behind = now_ns - stamp_ns
            if behind > self.timeout_ns or -behind > FARTHEST_AHEAD_NS:
                side = 'behind' if behind > 0 else 'ahead of'
                return (
                    f'header.stamp is {abs(behind) * 1e-9:.3f} s {side} the clock of servo_node; '
                    'set use_sim_time alike on both sides, or send stamp 0'
                )
        return ''
