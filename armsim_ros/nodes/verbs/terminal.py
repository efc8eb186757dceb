# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the small commands share: their words, their waiting, their output."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
import json
import math
import sys
import time
from typing import Any, NoReturn, TypeVar

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.clients.ros_client import NotServedError, RosClient
from armsim_ros.errors import ArmsimError

T = TypeVar('T')

#: How long a program that is asked for may take to appear [s].
PATIENCE = 5.0
_LOOK = 0.02
_HINT = "is the robot running ('armsim bringup'), with the same ROS_DOMAIN_ID?"


class Words(argparse.ArgumentParser):
    """A parser whose complaints are errors of this package."""

    def error(self, message: str) -> NoReturn:
        """Refuse the command line."""
        raise UsageError(f'{message}; see {self.prog} --help')


def parser(name: str, about: str, *, json_too: bool = True) -> Words:
    """Return the parser of a command."""
    words = Words(prog=f'armsim {name}', description=about)
    if json_too:
        words.add_argument('--json', action='store_true', help='print a JSON value')
    words.add_argument('--timeout', type=float, default=PATIENCE, metavar='SECONDS',
                       help=f'time to wait for the robot (default: {PATIENCE:g})')
    return words


def read(words: Words, argv: Sequence[str] | None) -> tuple[argparse.Namespace, tuple[str, ...]]:
    """Return the command's words and those for ROS."""
    own, ros = split_ros_args(sys.argv[1:] if argv is None else argv)
    return words.parse_args(own), ros


def share(text: str) -> float:
    """Return the number of an argument that is above 0, up to 1."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a share; allowed: above 0, up to 1")
    return value


def until(look: Callable[[], T | None], patience: float, what: str) -> T:
    """
    Look until there is something.

    :param what: is missing otherwise, as the subject of a sentence.
    :raises ArmsimError: there is nothing in time.
    """
    deadline = time.monotonic() + patience
    while True:
        found = look()
        if found is not None:
            return found
        if time.monotonic() > deadline:
            raise ArmsimError(f'{what} did not appear within {patience:g} s; {_HINT}')
        time.sleep(_LOOK)


def call(client: RosClient, kind: type[Any], name: str, request: Any, patience: float) -> Any:
    """
    Call a service that may not be there yet, and return its response.

    :raises ArmsimError: it does not appear or does not answer in time.
    """
    client.prepare(kind, name)
    until(lambda: client.serves(kind, name) or None, patience, f'service {name}')
    try:
        return wait(client.call(kind, name, request), PATIENCE, name)
    except (ArmsimError, NotServedError):
        # An answer is lost where the server had not found us yet; these may be asked twice.
        return wait(client.call(kind, name, request), PATIENCE, name)


def wait(future: Future[Any], patience: float, what: str) -> Any:
    """
    Return what a future becomes.

    :raises ArmsimError: not in time.
    """
    try:
        return future.result(patience)
    except (FutureTimeoutError, TimeoutError):
        raise ArmsimError(f'{what} did not answer within {patience:g} s') from None


def show(value: Any, as_json: bool, text: str) -> None:
    """Print a value as JSON, or its text for people."""
    print(json.dumps(_plain(value)) if as_json else text, flush=True)


def table(rows: Sequence[Sequence[str]]) -> str:
    """Return rows as aligned columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return '\n'.join('  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
                     .rstrip() for row in rows)


def _plain(value: Any) -> Any:
    """Return a value with null for numbers that JSON has no word for."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value
