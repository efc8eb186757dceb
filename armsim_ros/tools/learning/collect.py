# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program collect."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import signal
import sys
from types import FrameType
from typing import Any

from armsim_ros.errors import ArmsimError, ConfigError, extras_hint, ResourceError

#: Kinds of observations, and of actions; the tasks check them, too.
_OBS_TYPES = ('state', 'environment_state_agent_pos', 'pixels', 'pixels_agent_pos')
_ACTIONS = ('position', 'velocity', 'twist')


class _TerminatedError(BaseException):
    """SIGTERM; not an error that a policy's code may catch."""


def main(argv: Sequence[str] | None = None) -> int:
    """
    Collect episodes into a data set.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 when the set is complete; 130 or 143 after a signal, 1 after a failure, 2 for
        arguments that are wrong.
    """
    options = _parser().parse_args(sys.argv[1:] if argv is None else argv)
    try:
        from armsim_ros.data import collect
        from armsim_ros.data.dataset import DataSet
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: "
                            + extras_hint('gym', 'data')) from None
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
        collected = collect(_plan(options), options.folder, count)
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


def _parser() -> argparse.ArgumentParser:
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
