# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
What the page costs: its server without a session and with one, and the control tick beside it.

The session reads both of a tab's websockets in a process of its own and draws nothing, so that
the figures are those of the server. Where there is a Chromium it says how long a page takes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
import re
import time

from armsim_ros.testing.page_user import (
    chromium_path,
    launch_chromium,
    PageUser,
    printed_address,
    robot_is_seen,
)
from armsim_ros.testing.program import Program
from benchmarks.bringup import page_session
from benchmarks.controllers.control_thread import goals_without_pause
from benchmarks.options import Options
from benchmarks.simulation.real_time import Phase, phase_tables, watched
from benchmarks.stack import median, peer, running_stack, Stack
from benchmarks.tables import machine_load, replace_section, Table

#: Until a page has nothing more to do for a robot that has come [s].
SETTLE = 5.0
#: How often the control tick is watched without and with a session.
TURNS = 3


def main(options: Options) -> None:
    """Print the tables; write them where ``--report`` says."""
    lines: list[str] = []
    for table in _tables(options):
        table.print()
        lines += table.markdown()
    if options.report:
        replace_section(Path(options.report), 'page', [machine_load(), '', *lines])


def _tables(options: Options) -> Iterator[Table]:
    phases: list[Phase] = []
    traffic: list[tuple[str, ...]] = []
    robot = f'robot:={options.robot}'
    with running_stack(robot) as stack:
        phases += _rest_and_motion(stack, options, 'without a page')
    with running_stack(robot, 'web:=true') as stack:
        address = printed_address(stack.program.wait_for_line('page: http', 60.0))
        time.sleep(SETTLE)
        phases += _rest_and_motion(stack, options, 'page, no session')
        for name, work in (('at rest', None), ('moving', goals_without_pause)):
            with _session(stack, address) as session:
                with work(stack, options.robot) if work else nullcontext():
                    phases.append(watched(f'one session, {name}', [stack], options))
                session.stop()
            found = dict(re.findall(r'(\S+)=([\d.]+)', session.output[-1]))
            traffic.append((name, found['kB/s'], found['messages/s']))
        yield from phase_tables(phases, 'The page')
        yield _lateness_table(stack, address, options)
        yield Table('The page: what one session is sent',
                    ('robot', 'kB/s', 'messages a second'), traffic)
        if chromium_path() is not None:
            yield _load_table(address, options.runs)


def _rest_and_motion(stack: Stack, options: Options, name: str) -> Iterator[Phase]:
    yield watched(f'{name}, at rest', [stack], options)
    with goals_without_pause(stack, options.robot):
        yield watched(f'{name}, moving', [stack], options)


def _session(stack: Stack, address: str) -> AbstractContextManager[Program]:
    return peer('bringup.page_session', address, domain=stack.domain, settled=page_session.SETTLED)


def _lateness_table(stack: Stack, address: str, options: Options) -> Table:
    """Watch the moving robot by turns without and with a session: other load meets both."""
    rows: list[list[float]] = []
    with goals_without_pause(stack, options.robot):
        for _ in range(TURNS):
            alone = watched('without a session', [stack], options).kept
            with _session(stack, address):
                seen = watched('with a session', [stack], options).kept
            rows.append([float(text) for text in (*alone[:2], *seen[:2])])
    medians = [median(list(column)) for column in zip(*rows, strict=True)]
    return Table(
        'The page: how late the control tick is while the robot moves, by turns',
        ('turn', 'without a session p50 us', 'p99 us', 'with a session p50 us', 'p99 us'),
        [(name, *(f'{value:.0f}' for value in row)) for name, row in (
            *((str(number), row) for number, row in enumerate(rows, 1)), ('median', medians))])


def _load_table(address: str, runs: int) -> Table:
    """Load the page in a new window each time; from the request to what is seen."""
    from playwright.sync_api import sync_playwright

    times: dict[str, list[float]] = {'panel ready': [], 'robot seen': []}
    with sync_playwright() as programs:
        browser = launch_chromium(programs)
        for _ in range(runs):
            window = browser.new_context(viewport={'width': 800, 'height': 520})
            window.set_default_timeout(60_000)
            user, begun = PageUser(window.new_page(), address), time.monotonic()
            user.open()
            times['panel ready'].append(time.monotonic() - begun)
            user.wait_for_picture(robot_is_seen)
            times['robot seen'].append(time.monotonic() - begun)
            window.close()
        browser.close()
    return Table(
        f'The page: loading it in Chromium without a graphics card, {runs} times',
        ('until', 'median s', 'longest s'),
        [(name, f'{median(each):.2f}', f'{max(each):.2f}') for name, each in times.items()])
