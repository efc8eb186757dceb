# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Addresses, ports and command lines of servers."""

from __future__ import annotations

from collections.abc import Sequence
import ipaddress
import logging
import socket

from armsim_ros.cli.arguments import split_ros_args, UsageError
from armsim_ros.errors import ArmsimError, nearest

#: Ports that are tried after the requested port.
NEXT_PORTS = 100


class ServingError(ArmsimError):
    """A port cannot be opened at this address."""


def is_loopback(host: str) -> bool:
    """Return whether an address is reached from this machine alone."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def shown_host(host: str) -> str:
    """Return an address as it is written in a URL; for all interfaces, the machine's name."""
    shown = f'[{host}]' if ':' in host else host
    return socket.gethostname() if shown in ('0.0.0.0', '[::]') else shown


def free_port(host: str, first: int, count: int = NEXT_PORTS) -> int:
    """
    Return the first port from the requested port on that is not in use; 0 stays 0.

    :param count: how many ports are tried.
    :raises ServingError: none is free, or the address is not of this machine.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, None, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise ServingError(f"host '{host}' is not known: {reason}") from None
    trouble: OSError | None = None
    for port in range(first, min(first + count, 65536)):
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((address[0], port))
                probe.listen(1)
            except OSError as error:
                trouble = error
                continue
            return port
    reason = trouble.strerror if trouble else 'there is no such port'
    if count == 1:
        raise ServingError(f'port {first} cannot be opened at {host}: {reason}')
    raise ServingError(f'no port from {first} on can be opened at {host}: {reason}')


def silent_logger(name: str) -> logging.Logger:
    """Return a logger for what strangers send; none of it is for the terminal."""
    logger = logging.getLogger(f'{name}.connections')
    logger.propagate = False
    logger.disabled = True
    return logger


def read_values(argv: Sequence[str], known: Sequence[str]
                ) -> tuple[dict[str, str], tuple[str, ...]]:
    """
    Read ``name:=value``, ``--name value`` and ``--name=value``; the last of several wins.

    :param known: the names that are allowed.
    :returns: the values, and the words for ROS.
    :raises UsageError: names the known arguments.
    """
    words, ros_args = split_ros_args(argv)
    values: dict[str, str] = {}
    rest = list(words)
    while rest:
        word = rest.pop(0)
        name, sign, text = word.partition(':=')
        if word.startswith('--'):
            name, sign, text = word[2:].partition('=')
            name = name.removesuffix(':')
            if not sign and rest:
                sign, text = '=', rest.pop(0)
        if name not in known:
            hint = nearest(name, known) or f"known: {', '.join(known)}"
            raise UsageError(f"unknown argument '{word}'; {hint}")
        if not sign or not text:
            raise UsageError(f"argument '{name}' needs a value: {name}:=VALUE")
        values[name] = text
    return values, ros_args
