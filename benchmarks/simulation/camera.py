# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What pictures cost the control loop and planning; in a page with ``--report``."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
import time

from armsim_ros.clients.move_group import MoveGroupClient
from benchmarks.controllers.control_thread import goals_without_pause
from benchmarks.options import Options
from benchmarks.simulation.picture_listener import PICTURE
from benchmarks.simulation.real_time import Phase, phase_tables, watched
from benchmarks.stack import median, peer, percentile, running_stack, Stack
from benchmarks.tables import machine_load, replace_section, Table

#: Colour and depth, 640x480 [Hz].
RATE = 15
CAMERA = ('camera:=true', f'overrides:={{simulation.cameras.camera.rate: {RATE}}}')
PLANS = ('phase', 'plans', 'planning p50 ms', 'p95 ms', 'messages a second')
PATIENCE = 120.0


def main(options: Options) -> None:
    """Print the tables; write them where ``--report`` says."""
    phases, plans = [], []
    for name, words, seen in (
        ('without a camera', (), False),
        ('no subscriber', CAMERA, False),
        (f'colour and depth at {RATE} Hz', CAMERA, True),
    ):
        with running_stack('robot:=sunday', *words) as stack, ExitStack() as opened:
            if words:
                stack.program.wait_for_line('cameras: camera; drawn by', PATIENCE)
            printed: list[str] = []
            if seen:
                listener = opened.enter_context(
                    peer('simulation.picture_listener', domain=stack.domain))
                listener.wait_for_line(PICTURE, PATIENCE)
                printed = listener.output
            phase, row = moving_and_planning(name, stack, options, printed)
        phases.append(phase)
        plans.append(row)
    lines: list[str] = []
    tables = (*phase_tables(phases, 'The camera'), Table('The camera: planning', PLANS, plans))
    for table in tables:
        table.print()
        lines += table.markdown()
    if options.report:
        replace_section(Path(options.report), 'camera', [machine_load(), '', *lines])


def moving_and_planning(
    name: str, stack: Stack, options: Options, printed: list[str]
) -> tuple[Phase, tuple[str, ...]]:
    """
    Watch a stack that moves, then one that plans.

    :param printed: gets a line for each message, which are counted.
    """
    began, before = time.monotonic(), len(printed)
    with goals_without_pause(stack, 'sunday'):
        phase = watched(f'{name}, moving', [stack], options)
    times = _planning_times(stack, options.runs)
    rate = (len(printed) - before) / (time.monotonic() - began)
    return phase, (name, str(len(times)), f'{median(times):.1f}', f'{percentile(times, 0.95):.1f}',
                   f'{rate:.1f}')


def _planning_times(stack: Stack, rounds: int) -> list[float]:
    """Return how long plans to all named states take, from goal to result [ms]."""
    planner, times = MoveGroupClient(stack.client), []
    states = planner.named_states()
    for _ in range(rounds):
        for (group, _), target in states.items():
            began = time.monotonic()
            planner.plan(group, target)
            times.append(1000.0 * (time.monotonic() - began))
    return times

