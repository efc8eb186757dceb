# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ROS domains that no other test on this machine uses at the same time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
import tempfile

DOMAINS = range(30, 40)
"""Low, so that all ports of a domain lie below the ephemeral ones of Linux."""


def domain_range(text: str) -> range:
    """
    Return the domain ids of a text such as ``30-39``.

    :raises ValueError: it is no such text.
    """
    first, _, last = text.partition('-')
    return range(int(first), int(last or first) + 1)


@contextmanager
def private_domain(domains: range | None = None) -> Iterator[int]:
    """
    Lease a ROS domain id for the time of the context.

    The lease is a lock on a file in the temporary folder; it ends with the process at the latest.

    :param domains: the ids to choose from; where not given, those of the environment's
        ``ARMSIM_TEST_DOMAINS=30-39``, else the usual ones.
    :raises RuntimeError: all are in use.
    """
    limits = os.environ.get('ARMSIM_TEST_DOMAINS')
    if domains is None:
        domains = domain_range(limits) if limits else DOMAINS
    folder = Path(tempfile.gettempdir())
    start = os.getpid() % len(domains)
    for domain in (*domains[start:], *domains[:start]):
        path = folder / f'armsim_ros_domain_{domain}.lock'
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except PermissionError:
            continue  # another user's
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            continue
        try:
            yield domain
        finally:
            os.close(descriptor)
        return
    raise RuntimeError(f'all ROS domains of {domains} are in use by other tests')


def ros_environment(domain: int) -> dict[str, str]:
    """Return this process' environment, changed so that ROS stays on this machine and domain."""
    return {
        **os.environ,
        'ROS_DOMAIN_ID': str(domain),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'PYTHONUNBUFFERED': '1',
    }
