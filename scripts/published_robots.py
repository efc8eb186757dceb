# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Try every MoveIt package in a folder of checkouts and print a table of how far each one gets.

    .venv/bin/python scripts/published_robots.py FOLDER [--words FILE] [--only TEXT] [--check]

A package is one with an SRDF. Words that a package needs (its xacro's arguments, a URDF of
another package) stand in a YAML file: name of the row -> {package: NAME, words: [...]}, where
``{NAME}`` in a word is the folder of the package NAME. A row with ``launch: [[...], [...]]`` is
started by its own launch files, with these words, one after the other.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
import re
import subprocess
import sys
import time
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import yaml

from armsim_ros.packages import packages_below

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from armsim_ros.testing.clients.client_node import ClientNode
    from armsim_ros.testing.programs.program import Program

ROOT = Path(__file__).resolve().parent.parent
SEARCH_DEPTH = 8
#: How long a robot may take [s]: until the first joint state, until it can be planned for.
READY_TIMEOUT = 90.0
MOVE_TIMEOUT = 60.0
COLUMNS = ('robot', 'check', 'first state', 'ready', 'moved', 'planned', 'pymoveit2', 'reason')


@dataclass
class Row:
    """How far one robot got."""

    robot: str
    commands: Sequence[Sequence[str]]
    check: str = ''
    first_state: str = ''
    ready: str = ''
    moved: str = ''
    planned: str = ''
    pymoveit2: str = ''
    reason: str = ''
    lines: list[str] = field(default_factory=list)

    def cells(self) -> tuple[str, ...]:
        """Return the texts of the columns."""
        return (self.robot, self.check, self.first_state, self.ready, self.moved, self.planned,
                self.pymoveit2, self.reason)


def main() -> int:
    """Try the packages; the status is 1 where one of them does not start."""
    options = _options()
    packages = packages_below(options.folder, SEARCH_DEPTH)
    rows = []
    print('| ' + ' | '.join(COLUMNS) + ' |')
    print('|' + '---|' * len(COLUMNS), flush=True)
    for name, commands in _robots(packages, options.words, options.folder):
        if options.only and not re.search(options.only, name):
            continue
        row = Row(name, commands)
        _check(row)
        if not options.check and row.check in ('0', '1'):
            _bring_up(row)
        rows.append(row)
        print('| ' + ' | '.join(row.cells()) + ' |', flush=True)
        if options.verbose:
            print('\n'.join(f'    {line}' for line in row.lines), flush=True)
    good = [row for row in rows if row.check in ('0', '1')
            and (options.check or (row.moved and row.planned))]
    print(f'\n{len(good)} of {len(rows)}')
    return 0 if len(good) == len(rows) else 1


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description='Try the MoveIt packages of a folder.')
    parser.add_argument('folder', type=Path, help='folder of checkouts')
    parser.add_argument('--words', type=Path, help='YAML file: row -> {package, words}')
    parser.add_argument('--only', default='', help='rows whose name this expression finds')
    parser.add_argument('--check', action='store_true', help='check_config alone, start nothing')
    parser.add_argument('--verbose', action='store_true', help='with the messages')
    options = parser.parse_args()
    options.folder = options.folder.resolve()
    return options


def _robots(packages: Mapping[str, Path], words_file: Path | None, folder: Path
            ) -> Iterator[tuple[str, list[list[str]]]]:
    """Yield name and commands of every robot: those of the file, then all other packages."""
    given = yaml.safe_load(words_file.read_text()) if words_file else {}
    seen = set()
    path = f'packages_path:={folder}'
    places = {key: str(value) for key, value in packages.items()}

    def filled(words: Sequence[str]) -> list[str]:
        return [re.sub(r'\{(\w+)\}', lambda found: places.get(found[1], found[0]), word)
                for word in words]

    for name, row in given.items():
        if 'launch' in row:
            yield name, [['launch', *filled(words), path] for words in row['launch']]
            continue
        package = row.get('package', name)
        seen.add(package)
        if package in packages:
            words = filled(row.get('words', ()))
            yield name, [['bringup', f'robot:={packages[package]}', *words, path]]
    for name, place in sorted(packages.items()):
        has_srdf = any(place.glob('config/*.srdf*')) or any(place.glob('srdf/*.srdf*'))
        if has_srdf and name not in seen:
            yield name, [['bringup', f'robot:={place}', path]]


def _check(row: Row) -> None:
    text = ''
    for program, *words in row.commands:
        check = ['launch', '-n'] if program == 'launch' else ['check_config']
        done = subprocess.run(
            [sys.executable, '-m', 'armsim_ros', *check, *words], cwd=ROOT, capture_output=True,
            text=True, check=False, timeout=300)
        row.check = max(row.check, str(done.returncode))
        text += done.stdout + done.stderr
    if done.returncode not in (0, 1):
        _, _, errors = text.partition('errors (')
        first = errors.splitlines()[1].strip() if errors else (text.strip().splitlines() or [''])[
            -1]
        row.reason = _short(first)
        row.lines = errors.splitlines()[:12] or text.splitlines()[-12:]


def _bring_up(row: Row) -> None:
    """Start the robot, move every active controller, plan and execute a named state."""
    from armsim_ros.testing.clients.client_node import ClientNode
    from armsim_ros.testing.clients.robot_user import READY
    from armsim_ros.testing.programs.domain import private_domain
    from armsim_ros.testing.programs.program import start_program

    with ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        client = stack.enter_context(ClientNode(domain, 'visitor'))
        begun = time.monotonic()
        programs: list[Program] = []
        try:
            from sensor_msgs.msg import JointState

            states = client.collect('/joint_states', JointState)
            for command in row.commands:
                programs.append(stack.enter_context(start_program(
                    command[0], domain, *command[1:])))
                if not row.first_state:
                    states.wait(1, READY_TIMEOUT)
                    row.first_state = f'{time.monotonic() - begun:.1f} s'
            programs[-1].wait_for_line(re.escape(READY), READY_TIMEOUT)
            row.ready = f'{time.monotonic() - begun:.1f} s'
            row.moved = _move(client)
            row.planned = _plan(client)
            row.pymoveit2 = _pymoveit2(client, row.planned)
        except AssertionError as error:
            row.reason = _short(str(error).splitlines()[0])
            row.lines = [line for one in programs for line in one.text.splitlines()[-15:]]
        for program in reversed(programs):
            with suppress(AssertionError):
                program.stop()


def _move(client: ClientNode) -> str:
    """Move each active trajectory controller a little and back; return how many moved."""
    from controller_manager_msgs.srv import ListControllers
    from sensor_msgs.msg import JointState

    from armsim_ros.testing.clients.trajectory_client import (
        SUCCEEDED,
        trajectory_message,
        TrajectoryClient,
    )

    states = client.collect('/joint_states', JointState)
    limits = _limits(client)
    moved, arms = 0, []
    deadline = time.monotonic() + MOVE_TIMEOUT
    while not arms and time.monotonic() < deadline:  # a launch file's spawners come later
        states.clear()
        states.wait(1)
        listed = client.call('/controller_manager/list_controllers', ListControllers)
        arms = [one for one in listed.controller if one.state == 'active'
                and one.type.endswith('JointTrajectoryController')]
    for one in arms:
        joints = list(dict.fromkeys(text.rpartition('/')[0] for text in one.claimed_interfaces))
        message = states.wait(1)[-1]
        now = dict(zip(message.name, message.position, strict=True))
        start = [now[joint] for joint in joints]
        there = [_near(now[joint], *limits.get(joint, (-1e3, 1e3))) for joint in joints]
        for goal in (there, start):
            sent = TrajectoryClient(client, f'/{one.name}').send(
                trajectory_message(joints, [(2.0, goal)]))
            outcome = sent.result(MOVE_TIMEOUT)
            assert outcome.status == SUCCEEDED, f'{one.name}: {outcome.error_string}'
            states.clear()
            message = states.wait(1)[-1]
            after = dict(zip(message.name, message.position, strict=True))
            worst = max(abs(after[joint] - value)
                        for joint, value in zip(joints, goal, strict=True))
            assert worst < 0.01, f'{one.name} is {worst:.3f} away from its goal'
        moved += 1
    assert moved, 'no trajectory controller is active'
    return f'{moved} of {len(arms)}'


def _near(value: float, lower: float, upper: float) -> float:
    """Return a position a little away from another one, within limits."""
    step = min(0.02, 0.2 * (upper - lower))
    return value + step if value + step < upper else value - step


def _limits(client: ClientNode) -> dict[str, tuple[float, float]]:
    found = {}
    for joint in _description(client).findall('joint'):
        limit = joint.find('limit')
        if limit is not None and limit.get('lower') is not None:
            found[joint.get('name')] = (float(limit.get('lower')), float(limit.get('upper', 0)))
    return found


def _description(client: ClientNode) -> Element:
    """Return the published URDF."""
    from std_msgs.msg import String

    return ElementTree.fromstring(client.latched('/robot_description', String).data)


def _plan(client: ClientNode) -> str:
    """Plan to and execute the first named state that can be; return its name."""
    from armsim_ros.testing.clients.move_group_client import MoveGroupClient, SUCCESS

    move_group = MoveGroupClient(client)
    reasons = []
    states = move_group.named_states()
    for (group, state), target in sorted(states.items(), key=lambda item: -len(item[1])):
        result = move_group.move(group, target)
        if result.error_code.val == SUCCESS:
            return f'{group}/{state}'
        reasons.append(f'{group}/{state}: {result.error_code.message}')
    assert not reasons, reasons[0]
    return 'the SRDF has no named state'


def _pymoveit2(client: ClientNode, state: str) -> str:
    """Move the first joint of a group through pymoveit2, where it is installed."""
    try:
        from pymoveit2 import MoveIt2
    except ImportError:
        return 'not installed'
    from armsim_ros.testing.clients.move_group_client import MoveGroupClient

    name, _, _ = state.partition('/')
    known = MoveGroupClient(client).named_states()
    goal = next((target for (group, _), target in known.items() if group == name), {})
    if not goal:
        return ''
    links = [link.get('name') for link in _description(client).findall('link')]
    arm = MoveIt2(client.node, list(goal), links[0], links[-1], name)
    assert arm.wait_for_joint_state(MOVE_TIMEOUT), 'pymoveit2 has seen no joint state'
    limits = _limits(client)
    first = next(iter(goal))
    target = {**goal, first: _near(goal[first], *limits.get(first, (-1e3, 1e3)))}
    arm.move_to_configuration(list(target.values()))
    assert arm.wait_until_executed(), 'pymoveit2 could not move the arm'
    return 'moved'


def _short(text: str) -> str:
    return text[:160].replace('|', '/')


if __name__ == '__main__':
    sys.exit(main())
