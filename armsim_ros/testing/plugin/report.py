# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The end of a test: its limit of wall time, and artifacts of a failed test."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import re
import signal
import threading
from typing import Any, TYPE_CHECKING

import pytest

from armsim_ros.errors import ArmsimError

if TYPE_CHECKING:
    from armsim_ros.testing.arms.arm import Arm


#: The arm of a test.
ARM: pytest.StashKey[Arm] = pytest.StashKey()
#: Events that the section shows; the recording has more.
SHOWN_EVENTS = 12


@contextmanager
def users_errors_reported() -> Iterator[None]:
    """End a test with the sentence of a user's error, without a traceback of ours."""
    __tracebackhide__ = True
    try:
        yield
    except (ArmsimError, pytest.UsageError) as error:
        reason = str(error)
    else:
        return
    pytest.fail(reason, pytrace=False)


def on_failure(
    item: pytest.Item, report: pytest.TestReport, arm: Arm, *, seed: int, folder: str, keep: bool
) -> None:
    """
    Add a section on the arm to the report of a failed test, and write its artifacts.

    :param folder: where artifacts go; relative ones lie beside the ini file.
    :param keep: write them for a test that passed, too.
    """
    if not (report.failed or keep):
        return
    place = item.config.rootpath / folder / _file_name(item.nodeid)
    facts = {'robot': arm.name, 'seed': str(seed)}
    lines = []
    try:
        facts['digest'] = arm.digest()
        facts['simulated time'] = f'{arm.time:.3f} s'
        lines.append(f'state: {arm.summary()}')
        lines += [f'event: {event}' for event in arm.event_lines()[-SHOWN_EVENTS:]]
    except AssertionError as silence:  # the programs of a stack that ended answer nothing
        lines.append(f'state: unknown, {silence}')
    lines[:0] = [f'{key}: {value}' for key, value in facts.items() if value]
    for kind, path in _artifacts(arm, place):
        lines.append(f'{kind}: {path}')
        facts[kind] = str(path)
    lines.append(f'again: python -m pytest "{item.nodeid}" --armsim-seed={seed}')
    if report.failed:
        report.sections.append(('armsim', '\n'.join(lines)))
        item.user_properties.extend((f'armsim {key}', value) for key, value in facts.items())


def _artifacts(arm: Arm, place: Path) -> list[tuple[str, Path | str]]:
    """Write what the arm has to show; a disk that is full spoils no report."""
    try:
        return list(arm.save_artifacts(place))
    except OSError as error:
        return [('artifacts', f'not written: {error}')]


def _file_name(nodeid: str) -> str:
    return re.sub(r'[^\w.-]+', '_', nodeid).strip('_')[-150:]


@contextmanager
def wall_time_limit(seconds: float, arm: Arm) -> Iterator[None]:
    """
    Raise an AssertionError with the arm's state in the test when the time is over.

    Works in the main thread, where tests run. An alarm that was set elsewhere, such as
    pytest-timeout, is left alone and replaces this limit.

    :param seconds: [s].
    """
    if (threading.current_thread() is not threading.main_thread()
            or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL):
        yield
        return

    def end(*_: Any) -> None:
        raise AssertionError(
            f'the test took more than {seconds:g} s of wall time; {arm.summary()}')

    signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
