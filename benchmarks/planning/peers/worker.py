# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The process of one planner in a comparison: JSON lines in, JSON lines out.

The first line says which robot; every other one is a problem. It runs in the planner's own
environment, so it needs nothing but Python.
"""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import json
import os
import sys
import time
from typing import Any, Protocol


class Planner(Protocol):
    """What answers problems."""

    def prepare(self, problem: dict[str, Any]) -> None:
        """Make the scene; timed apart."""

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Return ``path``, or ``times`` and ``positions``, or a ``message``."""


def children_seconds() -> float:
    """Return the processor time [s] of the processes that this one has started and not ended."""
    total = 0
    for task in os.listdir('/proc/self/task'):
        with open(f'/proc/self/task/{task}/children', encoding='ascii') as file:
            children = file.read().split()
        for child in children:
            with contextlib.suppress(OSError):
                for thread in os.listdir(f'/proc/{child}/task'):
                    path = f'/proc/{child}/task/{thread}/schedstat'
                    with open(path, encoding='ascii') as file:
                        total += int(file.read().split()[0])
    return total * 1e-9


def processor_seconds() -> float:
    """Return the processor time [s] of this process and of those that it has started."""
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system + children_seconds()


def serve(make: Callable[[dict[str, Any]], Planner]) -> None:
    """
    Answer problems until the input ends.

    :param make: robot -> planner.
    """
    out = os.fdopen(os.dup(1), 'w', encoding='utf-8')
    os.dup2(2, 1)  # what libraries print must not be taken for an answer
    robot = json.loads(sys.stdin.readline())
    planner = make(robot)
    print(json.dumps({'ready': True}), file=out, flush=True)
    for line in sys.stdin:
        asked = json.loads(line)
        answer: dict[str, Any] = {'message': ''}
        began = processor_seconds()
        try:
            planner.prepare(asked['problem'])
            prepared, clock = processor_seconds(), time.monotonic()
            answer.update(planner.plan(asked['problem'], asked['seed'], asked['seconds']))
            answer['cpu'] = processor_seconds() - prepared
            answer['wall'] = time.monotonic() - clock
            answer['scene'] = prepared - began
        except Exception as error:  # noqa: BLE001  the comparison goes on
            answer = {'message': f'{type(error).__name__}: {error}', 'scene': 0.0, 'wall': 0.0,
                      'cpu': processor_seconds() - began}
        print(json.dumps(answer, default=lambda value: value.tolist()), file=out, flush=True)
