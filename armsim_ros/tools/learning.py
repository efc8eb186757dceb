# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The programs of robot learning: collect, evaluate, dataset and replay."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, ExitStack, nullcontext
import json
from pathlib import Path
import signal
import sys
from types import FrameType
from typing import Any

from armsim_ros.errors import ArmsimError, ConfigError, extras_hint, ResourceError


@contextmanager
def _needing_extras() -> Iterator[None]:
    """Turn the lack of a package into a user's error with the extras that have it."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: "
                            + extras_hint('gym', 'data')) from None


#: Kinds of observations, and of actions; the tasks check them, too.
_OBS_TYPES = ('state', 'environment_state_agent_pos', 'pixels', 'pixels_agent_pos')
_ACTIONS = ('position', 'velocity', 'twist')


class _TerminatedError(BaseException):
    """SIGTERM; not an error that a policy's code may catch."""


def collect(argv: Sequence[str] | None = None) -> int:
    """
    Collect episodes into a data set.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when the set is complete; 130 or 143 after a signal, 1 after a failure, 2 for
        arguments that are wrong.
    """
    options = _collect_parser().parse_args(sys.argv[1:] if argv is None else argv)
    with _needing_extras():
        from armsim_ros.data import collect as collect_episodes
        from armsim_ros.data.dataset import DataSet
    done = [0]

    def count(data: DataSet) -> None:
        if data.episodes == done[0] == 0 or data.episodes != done[0]:
            done[0] = data.episodes
            if data.dropped and not options.quiet:
                print(f'dropped {data.dropped}')
                data.dropped = ''
            if data.episodes and not options.quiet and sys.stdout.isatty():
                print(f'\r{data.episodes} of {options.episodes} episodes', end='', flush=True)

    usual = signal.signal(signal.SIGTERM, _terminate)
    reason, status = '', 0
    try:
        collected = collect_episodes(_plan(options), options.folder, count)
    except ConfigError:
        raise
    except KeyboardInterrupt:
        reason, status = 'interrupted', 128 + signal.SIGINT
    except _TerminatedError:
        reason, status = 'terminated', 128 + signal.SIGTERM
    except (ArmsimError, OSError) as error:
        reason, status = str(error), 1
    finally:
        signal.signal(signal.SIGTERM, usual)
    if status:
        print(f'collect: {reason}\n{done[0]} of {options.episodes} episodes are in '
              f"'{options.folder}'; the same command goes on there", file=sys.stderr)
        return status
    print(f'{collected.episodes} episodes, {collected.frames} frames, '
          f'{collected.successes} successes')
    return 0


def _plan(options: argparse.Namespace) -> Any:
    from armsim_ros.data import Plan
    from armsim_ros.data.episodes import Source

    given = {
        'robot': options.robot, 'obs_type': options.obs_type, 'cameras': options.cameras,
        'image_size': options.image_size, 'action': options.action, 'period': options.period,
        'randomize': options.randomize, 'max_episode_steps': options.max_episode_steps}
    arguments = {name: value for name, value in given.items() if value is not None}
    return Plan(Source(options.env_id, arguments, options.policy), options.episodes, options.seed,
                options.only_successes, options.workers)


def _terminate(_number: int, _frame: FrameType | None) -> None:
    raise _TerminatedError


def _workers(text: str) -> int | str:
    return text if text == 'ray' else int(text)


def _collect_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='collect',
        description='Collect episodes of a task as a data set in the layout v3.0 of LeRobot. '
                    'Each finished episode stays, whatever happens; the same command completes '
                    'a set that was interrupted.',
        epilog='exit status: 0 complete, 130 or 143 after a signal, 1 after a failure, 2 for '
               'wrong arguments')
    parser.add_argument('env_id', metavar='ENV_ID', help='such as armsim/PickCube-v1')
    parser.add_argument('folder', type=Path, metavar='DIR', help='of the data set')
    parser.add_argument('--episodes', type=int, required=True, metavar='N',
                        help='how many the set shall have')
    parser.add_argument('--seed', type=int, default=0, metavar='S',
                        help='of the first episode; each next has the next seed (%(default)s)')
    parser.add_argument('--policy', default='expert', metavar='POLICY',
                        help='expert, random, or MODULE:CALLABLE, which gets an observation and '
                             'returns an action (%(default)s)')
    parser.add_argument('--only-successes', action='store_true',
                        help='leave out episodes without success')
    parser.add_argument('--workers', type=_workers, default=1, metavar='W',
                        help='processes, or ray for a Ray cluster (%(default)s)')
    parser.add_argument('--robot', default='sunday', help='its name or folder (%(default)s)')
    parser.add_argument('--obs-type', default='pixels_agent_pos', choices=_OBS_TYPES,
                        help='what is observed (%(default)s)')
    parser.add_argument('--cameras', nargs='+', metavar='NAME', help='front, side, top (front)')
    parser.add_argument('--image-size', nargs=2, type=int, metavar=('H', 'W'),
                        help='of the pictures [pixels] (96 96)')
    parser.add_argument('--action', choices=_ACTIONS, help='what an action is (position)')
    parser.add_argument('--period', type=float, metavar='S', help='of a frame [s] (0.05)')
    parser.add_argument('--randomize', choices=('default', 'none'),
                        help='what differs between episodes (default)')
    parser.add_argument('--max-episode-steps', type=int, metavar='N',
                        help='frames after which an episode ends')
    parser.add_argument('--quiet', action='store_true', help='print only the result')
    return parser


def evaluate(argv: Sequence[str] | None = None) -> int:
    """
    Evaluate a policy and print how often it succeeds.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    options = _evaluate_parser().parse_args(sys.argv[1:] if argv is None else argv)
    with _needing_extras():
        from armsim_ros.data.episodes import Source
        from armsim_ros.data.evaluate import deviations, success_interval
        from armsim_ros.data.evaluate import evaluate as outcomes
    arguments = {'robot': options.robot, 'action': options.action}
    if options.obs_type:
        arguments['obs_type'] = options.obs_type
    source = Source(options.env_id, arguments, options.policy)
    local = list(outcomes(source, options.episodes, options.seed)) if options.over == 'ros' else []
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

        for outcome in outcomes(source, options.episodes, options.seed, place):
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


def _evaluate_parser() -> argparse.ArgumentParser:
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


def dataset(argv: Sequence[str] | None = None) -> int:
    """
    Write a data set of recordings.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    options = _dataset_parser().parse_args(sys.argv[1:] if argv is None else argv)
    with _needing_extras():
        from armsim_ros.data.recordings import convert
        from armsim_ros.data.topic_map import topic_map
    *recordings, folder = options.paths
    if not recordings:
        _dataset_parser().error('name at least one recording and the folder of the data set')
    data = convert(recordings, folder, topic_map(options.map), allow_gaps=options.allow_gaps)
    print(f'{data.episodes} episodes, {data.frames} frames')
    return 0


def _dataset_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='dataset',
        description='Write recordings of topics (MCAP, as of rosbag2) as a data set in the '
                    'layout v3.0 of LeRobot.',
        epilog='exit status: 0, or 2 where recordings and map do not fit')
    parser.add_argument('paths', type=Path, nargs='+', metavar='RECORDING ... DIR',
                        help='MCAP files, then the folder of the data set')
    parser.add_argument('--map', type=Path, required=True, metavar='FILE',
                        help='YAML file: which topics become which features')
    parser.add_argument('--allow-gaps', action='store_true',
                        help='keep the last value of topics that are silent')
    return parser


def replay(argv: Sequence[str] | None = None) -> int:
    """
    Run the actions of a data set again.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 where all episodes go as before, else 1.
    """
    options = _replay_parser().parse_args(sys.argv[1:] if argv is None else argv)
    with _needing_extras():
        from armsim_ros.data.collect import other_versions
        from armsim_ros.data.collect import replay as replayed
    for line in other_versions(options.folder):
        print(line)
    same = True
    chosen = None if options.episode is None else [options.episode]
    for episode in replayed(options.folder, chosen):
        same &= episode.same
        outcome = 'the same' if episode.same else 'not the same'
        ending = '' if episode.success else ', another ending'
        print(f'episode {episode.number}: {outcome}, states differ by at most '
              f'{episode.deviation:.1e}{ending}', flush=True)
    return 0 if same else 1


def _replay_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='replay',
        description='Run the actions of a data set of armsim collect again, and report whether '
                    'states and success are the same.',
        epilog='exit status: 0 the same, 1 not the same, 2 no such data set')
    parser.add_argument('folder', type=Path, metavar='DIR', help='of the data set')
    parser.add_argument('--episode', type=int, metavar='K', help='only this episode')
    return parser
