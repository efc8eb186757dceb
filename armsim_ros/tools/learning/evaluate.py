# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program evaluate."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict
import json
from pathlib import Path
import sys

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
        from armsim_ros.data.evaluate import evaluate, success_interval
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: pip install "
                            "'armsim_ros[gym,data]'") from None
    arguments = {'robot': options.robot, 'action': options.action}
    if options.obs_type:
        arguments['obs_type'] = options.obs_type
    found = []
    for outcome in evaluate(Source(options.env_id, arguments, options.policy), options.episodes,
                            options.seed):
        found.append(outcome)
        print(f'seed {outcome.seed}: {"success" if outcome.success else "no success"} after '
              f'{outcome.steps} steps', flush=True)
    low, high = success_interval(found)
    successes, count = sum(outcome.success for outcome in found), len(found)
    mean = sum(outcome.steps for outcome in found) / count
    print(f'{successes} of {count} episodes succeed: {100 * successes / count:.1f} % '
          f'(95 %: {100 * low:.1f} to {100 * high:.1f} %), {mean:.1f} steps on average')
    if options.report is not None:
        options.report.write_text(json.dumps({
            'env_id': options.env_id, 'policy': options.policy, **arguments,
            'success_rate': successes / count, 'interval': [low, high], 'mean_steps': mean,
            'episodes': [asdict(outcome) for outcome in found]}, indent=1) + '\n')
    return 0


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
    parser.add_argument('--report', type=Path, metavar='FILE', help='write all outcomes as JSON')
    return parser
