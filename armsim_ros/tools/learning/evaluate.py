# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program evaluate."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack, nullcontext
import json
from pathlib import Path
import sys
from typing import Any

from armsim_ros.errors import ResourceError


def main(argv: Sequence[str] | None = None) -> int:
    """
    Evaluate a policy and print how often it succeeds.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    options = _parser().parse_args(sys.argv[1:] if argv is None else argv)
    try:
        from armsim_ros.data.episodes import Source
        from armsim_ros.data.evaluate import deviations, evaluate, success_interval
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: pip install "
                            "'armsim_ros[gym,data]'") from None
    arguments = {'robot': options.robot, 'action': options.action}
    if options.obs_type:
        arguments['obs_type'] = options.obs_type
    source = Source(options.env_id, arguments, options.policy)
    local = list(evaluate(source, options.episodes, options.seed)) if options.over == 'ros' else []
    found, apart, timing = [], [], None
    with ExitStack() as stack:
        place: Any = nullcontext
        if options.over == 'ros':
            from armsim_ros.clients.task_over_ros import task_over_ros

            def place(env: Any) -> Any:
                nonlocal timing
                started = stack.enter_context(task_over_ros(
                    env, options.robot, lockstep=options.mode == 'lockstep'))
                timing = started.arm.timing
                return nullcontext(started)

        for outcome in evaluate(source, options.episodes, options.seed, place):
            found.append(outcome)
            line = (f'seed {outcome.seed}: {"success" if outcome.success else "no success"} after '
                    f'{outcome.steps} steps')
            if local:
                apart.append(deviations(local[len(found) - 1], outcome))
                line += f', joints {apart[-1].max():.1e} from the local run'
            print(line, flush=True)
    report = {'env_id': options.env_id, 'policy': options.policy, **arguments,
              **_rate('', found, success_interval),
              'episodes': [outcome.facts() for outcome in found]}
    if local:
        report |= {'over': 'ros', 'mode': options.mode,
                   'local': _rate('locally ', local, success_interval),
                   **_gap(apart, timing)}
    if options.report is not None:
        options.report.write_text(json.dumps(report, indent=1) + '\n')
    return 0


def _rate(place: str, found: Sequence[Any], interval: Any) -> dict[str, Any]:
    """Print and return how often a policy succeeds."""
    low, high = interval(found)
    successes, count = sum(outcome.success for outcome in found), len(found)
    mean = sum(outcome.steps for outcome in found) / count
    print(f'{place}{successes} of {count} episodes succeed: {100 * successes / count:.1f} % '
          f'(95 %: {100 * low:.1f} to {100 * high:.1f} %), {mean:.1f} steps on average')
    return {'success_rate': successes / count, 'interval': [low, high], 'mean_steps': mean}


def _gap(apart: Sequence[Any], timing: Any) -> dict[str, Any]:
    """Print and return how far runs over ROS are from the local runs, and how late commands."""
    import numpy as np

    ways = np.concatenate([episode.max(axis=1) for episode in apart])
    gap = {'deviation_p95': float(np.quantile(ways, 0.95)), 'deviation_max': float(ways.max())}
    print(f"joints from the local run: 95 % of the steps within {gap['deviation_p95']:.1e}, "
          f"largest {gap['deviation_max']:.1e} rad or m")
    if timing.latencies:
        middle, most = np.quantile(timing.latencies, (0.5, 0.95)).tolist()
        gap |= {'latency_p50': middle, 'latency_p95': most, 'late_steps': timing.late}
        print(f'from observation to command: median {1e3 * middle:.1f} ms, 95 % within '
              f'{1e3 * most:.1f} ms; {timing.late} of {len(timing.latencies)} steps late')
    return gap


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='evaluate',
        description='Run a policy in episodes of a task, and print how often it succeeds.',
        epilog='exit status: 0, 1 where the policy fails, 2 for wrong arguments')
    parser.add_argument('env_id', metavar='ENV_ID', help='such as armsim/PickCube-v1')
    parser.add_argument('--policy', required=True, metavar='POLICY',
                        help='expert, random, MODULE:CALLABLE, which gets an observation and '
                             "returns an action, or a folder pretrained_model of LeRobot's")
    parser.add_argument('--episodes', type=int, default=50, metavar='N',
                        help='how many (%(default)s)')
    parser.add_argument('--seed', type=int, default=0, metavar='S',
                        help='of the first episode; each next has the next seed (%(default)s)')
    parser.add_argument('--robot', default='sunday', help='its name or folder (%(default)s)')
    parser.add_argument('--obs-type', default='',
                        help="what is observed (state, or what LeRobot's policy was trained with)")
    parser.add_argument('--action', default='position', help='what an action is (%(default)s)')
    parser.add_argument('--over', choices=('local', 'ros'), default='local',
                        help='where the arm is: in this process, or in a simulation that is '
                             'started, observed and moved over ROS (%(default)s)')
    parser.add_argument('--mode', choices=('realtime', 'lockstep'), default='realtime',
                        help='of --over ros, as of bringup (%(default)s)')
    parser.add_argument('--report', type=Path, metavar='FILE', help='write all outcomes as JSON')
    return parser
