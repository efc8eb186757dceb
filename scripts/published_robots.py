# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Try every MoveIt package in a folder of checkouts and print a table of how far each one gets.

    .venv/bin/python scripts/published_robots.py FOLDER [--words FILE] [--only TEXT] [--check]

A package is one with an SRDF. A robot has to hold its pose, to start in a valid state, to reach
its named states, and to open and close its grippers. Words that a package needs (its xacro's
arguments, a URDF of another package) stand in a YAML file: name of the row ->
{package: NAME, words: [...]}, where ``{NAME}`` in a word is the folder of the package NAME. A row
with ``launch: [[...], [...]]`` is started by its own launch files, with these words, one after the
other; ``namespace`` is that of its controllers, ``move_group`` that of move_group (null where it
has none).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, ExitStack, nullcontext, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
import re
import subprocess
import sys
import time
from typing import Any, TYPE_CHECKING
from xml.etree import ElementTree

import yaml

from armsim_ros.packages import packages_below

if TYPE_CHECKING:
    from controller_manager_msgs.msg import ControllerState

    from armsim_ros.clients.client_node import ClientNode
    from armsim_ros.testing.program import Program

ROOT = Path(__file__).resolve().parent.parent
SEARCH_DEPTH = 8
#: How long a robot may take [s]: until the first joint state, until it can be planned for.
READY_TIMEOUT = 90.0
#: How long the next command waits for the first joint state [s].
NEXT_COMMAND = 10.0
MOVE_TIMEOUT = 60.0
MOST_STATES = 6
#: What counts as at rest, as arrived, as a step of a gripper's finger [rad or m].
TOLERANCE = 0.005
HOLD_TIME = 3.0
#: At rest: no joint moves by more in an interval [rad or m], [s]; how often that is checked.
STILL, REST_INTERVAL, REST_CHECKS = 1e-4, 0.2, 20
COLUMNS = ('robot', 'check', 'first state', 'ready', 'held', 'start state', 'controllers moved',
           'named states', 'gripper', 'reason')


@dataclass(frozen=True)
class Robot:
    """A running robot: the client, and the namespaces of controllers and move_group."""

    client: ClientNode
    namespace: str
    move_group: str

    def positions(self) -> dict[str, float]:
        """Return the joints' positions [rad or m]."""
        from sensor_msgs.msg import JointState

        topic = f'{self.namespace}/joint_states'
        with closing(self.client.collect(topic, JointState)) as states:
            message = states.wait(1, MOVE_TIMEOUT)[-1]
        return dict(zip(message.name, message.position, strict=True))

    def positions_at_rest(self) -> dict[str, float]:
        """Return the positions once the joints have stopped: a goal tolerance may be wide."""
        now = self.positions()
        for _ in range(REST_CHECKS):
            time.sleep(REST_INTERVAL)
            before, now = now, self.positions()
            if all(abs(now[joint] - value) < STILL for joint, value in before.items()):
                break
        return now

    def active_controllers(self, kind: str) -> list[ControllerState]:
        """Return the active controllers whose type ends so."""
        from controller_manager_msgs.srv import ListControllers

        listed = self.client.call(
            f'{self.namespace}/controller_manager/list_controllers', ListControllers)
        return [one for one in listed.controller
                if one.state == 'active' and one.type.endswith(kind)]

    def limits(self) -> dict[str, tuple[float, float]]:
        """Return the limits in the published URDF."""
        from std_msgs.msg import String

        text = self.client.latched(f'{self.namespace}/robot_description', String).data
        return {
            joint.attrib['name']: (float(limit.attrib['lower']), float(limit.get('upper', 0)))
            for joint in ElementTree.fromstring(text).findall('joint')
            if (limit := joint.find('limit')) is not None and 'lower' in limit.attrib}


@dataclass
class Row:
    """How far one robot got."""

    robot: str
    commands: Sequence[Sequence[str]]
    namespace: str = ''
    move_group: str | None = ''
    check: str = ''
    first_state: str = ''
    ready: str = ''
    held: str = ''
    start: str = ''
    moved: str = ''
    planned: str = ''
    gripper: str = ''
    reason: str = ''
    lines: list[str] = field(default_factory=list)

    def cells(self) -> tuple[str, ...]:
        """Return the texts of the columns."""
        return (self.robot, self.check, self.first_state, self.ready, self.held, self.start,
                self.moved, self.planned, self.gripper, self.reason)


def main() -> int:
    """Try the packages; the status is 1 where one of them does not start."""
    options = _options()
    packages = packages_below(options.folder, SEARCH_DEPTH)
    rows = []
    print('| ' + ' | '.join(COLUMNS) + ' |')
    print('|' + '---|' * len(COLUMNS), flush=True)
    for row in _robots(packages, options.words, options.folder):
        if options.only and not re.search(options.only, row.robot):
            continue
        _check(row)
        if not options.check and row.check in ('0', '1'):
            _bring_up(row)
        rows.append(row)
        print('| ' + ' | '.join(row.cells()) + ' |', flush=True)
        if options.verbose:
            print('\n'.join(f'    {line}' for line in row.lines), flush=True)
    good = [row for row in rows if row.check in ('0', '1') and (options.check or not row.reason)]
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


def _robots(packages: Mapping[str, Path], words_file: Path | None, folder: Path) -> Iterator[Row]:
    """Yield the row of every robot, yet empty: those of the file, then all other packages."""
    given = yaml.safe_load(words_file.read_text()) if words_file else {}
    seen = set()
    path = f'packages_path:={folder}'
    places = {key: str(value) for key, value in packages.items()}

    def filled(words: Sequence[str]) -> list[str]:
        return [re.sub(r'\{(\w+)\}', lambda found: places.get(found[1], found[0]), word)
                for word in words]

    for name, row in given.items():
        if 'launch' in row:
            yield Row(name, [['launch', *filled(words), path] for words in row['launch']],
                      row.get('namespace', ''), row.get('move_group', ''))
            continue
        package = row.get('package', name)
        seen.add(package)
        if package in packages:
            words = filled(row.get('words', ()))
            yield Row(name, [['bringup', f'robot:={packages[package]}', *words, path]])
    for name, place in sorted(packages.items()):
        has_srdf = any(place.glob('config/*.srdf*')) or any(place.glob('srdf/*.srdf*'))
        if has_srdf and name not in seen:
            yield Row(name, [['bringup', f'robot:={place}', path]])


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
    from armsim_ros.clients.client_node import ClientNode
    from armsim_ros.testing.program import private_domain, start_program
    from armsim_ros.testing.robot_user import READY

    with ExitStack() as stack:
        domain = stack.enter_context(private_domain())
        client = stack.enter_context(ClientNode(domain, 'visitor'))
        begun = time.monotonic()
        programs: list[Program] = []
        try:
            from sensor_msgs.msg import JointState

            states = client.collect(f'{row.namespace}/joint_states', JointState)
            for number, command in enumerate(row.commands, 1):
                programs.append(stack.enter_context(start_program(
                    command[0], domain, *command[1:])))
                last = number == len(row.commands)
                # The joint state broadcaster may be the next command's.
                with nullcontext() if last else suppress(AssertionError):
                    states.wait(1, READY_TIMEOUT if last else NEXT_COMMAND)
                    row.first_state = row.first_state or f'{time.monotonic() - begun:.1f} s'
            checks = {'held': _hold, 'moved': _move, 'gripper': _grip}
            if row.move_group is not None:
                programs[-1].wait_for_line(re.escape(READY), READY_TIMEOUT)
                row.ready = f'{time.monotonic() - begun:.1f} s'
                checks = {'held': _hold, 'start': _start, 'moved': _move, 'planned': _plan,
                          'gripper': _grip}
            robot = Robot(client, row.namespace, row.move_group or '')
            for column, check in checks.items():
                try:
                    setattr(row, column, check(robot))
                except AssertionError as error:
                    setattr(row, column, 'no')
                    row.reason += _short(f'{column}: {str(error).splitlines()[0]}; ')
        except AssertionError as error:
            row.reason = _short(str(error).splitlines()[0])
        row.lines = [line for one in programs for line in one.text.splitlines()]
        for program in reversed(programs):
            with suppress(AssertionError):
                program.stop()


def _move(robot: Robot) -> str:
    """Move each active trajectory controller a little and back; return how many moved."""
    from armsim_ros.clients.trajectory import SUCCEEDED, trajectory_message, TrajectoryClient

    limits = robot.limits()
    arms: list[ControllerState] = []
    deadline = time.monotonic() + MOVE_TIMEOUT
    while not arms and time.monotonic() < deadline:  # a launch file's spawners come later
        robot.positions()
        arms = robot.active_controllers('JointTrajectoryController')
    for one in arms:
        joints = list(dict.fromkeys(text.rpartition('/')[0] for text in one.claimed_interfaces))
        now = robot.positions()
        start = [now[joint] for joint in joints]
        there = [_near(now[joint], *limits.get(joint, (-1e3, 1e3))) for joint in joints]
        for goal in (there, start):
            sent = TrajectoryClient(robot.client, f'{robot.namespace}/{one.name}').send(
                trajectory_message(joints, [(2.0, goal)]))
            outcome = sent.result(MOVE_TIMEOUT)
            assert outcome.status == SUCCEEDED, f'{one.name}: {outcome.error_string}'
            after = robot.positions()
            worst = max(abs(after[joint] - value)
                        for joint, value in zip(joints, goal, strict=True))
            assert worst < 0.01, f'{one.name} is {worst:.3f} away from its goal'
    assert arms, 'no trajectory controller is active'
    return f'{len(arms)} of {len(arms)}'


def _near(value: float, lower: float, upper: float) -> float:
    """Return a position a little away from another one, within limits."""
    step = min(0.02, 0.2 * (upper - lower))
    return value + step if value + step < upper else value - step


def _hold(robot: Robot) -> str:
    """Watch the joints at rest; return how far any of them moves."""
    from sensor_msgs.msg import JointState

    start = robot.positions()
    states = robot.client.collect(f'{robot.namespace}/joint_states', JointState)
    deadline = time.monotonic() + HOLD_TIME
    time.sleep(HOLD_TIME)
    worst, joint = max((abs(position - start.get(name, position)), name)
                       for message in states.wait(1, deadline - time.monotonic() + MOVE_TIMEOUT)
                       for name, position in zip(message.name, message.position, strict=True))
    assert worst < TOLERANCE, f'{joint} moves by {1e3 * worst:.1f} mrad or mm at rest'
    return f'{1e3 * worst:.2f}'


def _start(robot: Robot) -> str:
    """Return whether move_group takes the state that the robot starts in."""
    from moveit_msgs.srv import GetStateValidity

    request = GetStateValidity.Request()
    request.robot_state.is_diff = True
    answer = robot.client.call(
        f'{robot.move_group}/check_state_validity', GetStateValidity, request)
    pairs = sorted({f'{one.contact_body_1} and {one.contact_body_2}' for one in answer.contacts})
    return 'valid' if answer.valid else f'touches: {", ".join(pairs[:3])}'


def _plan(robot: Robot) -> str:
    """Plan to and execute every named state; return how many are reached, and how closely."""
    from armsim_ros.clients.motion import SUCCESS
    from armsim_ros.clients.move_group import MoveGroupClient

    move_group = MoveGroupClient(robot.client, robot.move_group)
    states = move_group.named_states()
    reached, worst, reasons = 0, 0.0, []
    for (group, state), target in list(states.items())[:MOST_STATES]:
        result = move_group.move(group, target)
        if result.error_code.val != SUCCESS:
            reasons.append(f'{group}/{state}: {result.error_code.message}')
            continue
        now = robot.positions_at_rest()
        error, joint = max((abs(now.get(name, value) - value), name)
                           for name, value in target.items())
        worst = max(worst, error)
        if error < TOLERANCE:
            reached += 1
        else:
            reasons.append(f'{group}/{state}: {joint} is {1e3 * error:.1f} mrad or mm away')
    if not states:
        return 'none in the SRDF'
    text = f'{reached} of {min(len(states), MOST_STATES)}, {1e3 * worst:.2f}'
    assert not reasons, f'{text}; ' + '; '.join(reasons)
    return text


def _grip(robot: Robot) -> str:
    """Open and close every active gripper controller; return how many follow."""
    from control_msgs.action import GripperCommand, ParallelGripperCommand
    from control_msgs.msg import GripperCommand as GripperCommandMessage
    from sensor_msgs.msg import JointState

    from armsim_ros.clients.action_client import PatientActionClient

    client, limits = robot.client, robot.limits()
    grippers = robot.active_controllers('GripperActionController')
    for one in grippers:
        joint = one.claimed_interfaces[0].rpartition('/')[0]
        parallel = one.type.startswith('parallel')
        action = ParallelGripperCommand if parallel else GripperCommand
        gripper = PatientActionClient(
            client.node, action, f'{robot.namespace}/{one.name}/gripper_cmd')
        lower, upper = limits.get(joint, (0.0, 0.5))
        assert gripper.wait_for_server(MOVE_TIMEOUT), f'{one.name} has no action server'
        for position in (upper, lower):
            goal: Any
            if parallel:
                goal = ParallelGripperCommand.Goal(
                    command=JointState(name=[joint], position=[position]))
            else:
                goal = GripperCommand.Goal(
                    command=GripperCommandMessage(position=position, max_effort=100.0))
            sent = client.in_executor(partial(gripper.send_goal_async, goal))
            handle = client.result(sent, MOVE_TIMEOUT)
            assert handle.accepted, f'{one.name} rejected {position:g}'
            ended = client.result(client.in_executor(handle.get_result_async), MOVE_TIMEOUT)
            error = abs(robot.positions_at_rest()[joint] - position)
            assert error < TOLERANCE, (
                f'{one.name}: {joint} is {1e3 * error:.1f} mrad or mm away from {position:g} '
                f'(status {ended.status}, stalled: {ended.result.stalled})')
    return f'{len(grippers)} of {len(grippers)}' if grippers else ''


def _short(text: str) -> str:
    return text[:300].replace('|', '/')


if __name__ == '__main__':
    sys.exit(main())
