# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim teleop``: move a running arm by keyboard, gamepad or leader arm."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import closing, ExitStack
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.clients.simulated_time import PAUSED, SimulatedTime
from armsim_ros.errors import ArmsimError, extras_hint, ResourceError
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.teleop.commands import (
    GAMEPAD_HELP,
    HELP,
    Keys,
    PAUSE,
    SERVO_HELP,
    stick_command,
)
from armsim_ros.nodes.teleop.devices import (
    Ending,
    ending_by_signals,
    find_gamepad,
    paced,
    terminal,
)
from armsim_ros.nodes.teleop.leader import Following, Leader
from armsim_ros.nodes.teleop.servo_link import ServoLink
from armsim_ros.nodes.verbs.go import published_robot
from armsim_ros.nodes.verbs.terminal import parser, read, share, Words

#: Between two commands [s].
_PERIOD = 0.02
KEYBOARD, GAMEPAD, LEADER = 'keyboard', 'gamepad', 'leader'


def main(argv: Sequence[str] | None = None) -> int:
    """
    Move the arm until Ctrl-C.

    :returns: 0 after Ctrl-C, 1 where a device or the arm is gone, 143 after SIGTERM.
    :raises ArmsimError: there is no terminal, gamepad, leader, servo_node or controller.
    """
    options, ros = read(_words(), argv)
    device, _, place = options.device.partition(':')
    if options.record:
        return _record(options, ros)
    with ending_by_signals() as ending:
        if device != LEADER:
            return _stream(options, ros, ending, place if device == GAMEPAD else None)
        if ros:
            raise UsageError(f'--with {LEADER}:TOPIC takes no --ros-args')
        try:
            return _lead(options, place, ending)
        except AssertionError as error:  # of the client: no answer in time
            raise ArmsimError(str(error)) from None


def _stream(
    options: argparse.Namespace, ros: Sequence[str], ending: Ending, joystick: str | None
) -> int:
    """Send the commands of keys or sticks to servo_node."""
    keys = Keys()
    with ExitStack() as stack:
        screen = stack.enter_context(terminal(ending, needs_keys=joystick is None))
        client = stack.enter_context(RosClient('armsim_teleop', ros))
        simulated = SimulatedTime(client)
        gamepad = None if joystick is None else find_gamepad(client, joystick, options.timeout)
        robot = published_robot(client, options.timeout)
        link = ServoLink(
            client, options.servo, robot, options.frame, options.speed, options.timeout)
        stack.callback(link.halt)
        if simulated.paused():
            print(f'teleop: {PAUSED}', file=sys.stderr, flush=True)
        print((HELP if gamepad is None else GAMEPAD_HELP) + SERVO_HELP, flush=True)
        try:
            for now, pressed in paced(ending, _PERIOD, screen):
                if keys.press(pressed, now).count(PAUSE) % 2:
                    link.toggle_pause()
                link.send(keys.command(now) if gamepad is None else stick_command(*gamepad.read()))
                screen.show(link.status)
        except ArmsimError as error:
            print(f'teleop: {error}', file=sys.stderr)
            return 1
    return ending.status


def _lead(options: argparse.Namespace, topic: str, ending: Ending) -> int:
    """Have a forward controller follow the leader's joints."""
    # With it come the physics and Gymnasium, which keyboard and gamepad do not need.
    from armsim_ros.clients.streamed_arm import StreamedArm

    cell = load_cell(options.robot)
    with terminal(ending, needs_keys=False) as screen, \
            ClientNode(name='armsim_teleop') as client, \
            closing(StreamedArm(client, cell, controller=options.controller,
                                timeout=options.timeout)) as arm, \
            closing(Leader(client, topic, arm.joints, options.timeout)) as leader:
        following = Following({name: cell.model.joints[name].limits for name in arm.joints},
                              options.speed, approach=options.approach)
        at = {name: arm.positions[name] for name in arm.joints}
        try:
            for _ in paced(ending, _PERIOD, screen):
                goals = following.step(leader.positions, at, _PERIOD)
                if goals is not None:
                    at = arm.send(goals, leader.level(arm.hand) if following.engaged else None)
                screen.show(following.state)
        except ArmsimError as error:
            print(f'teleop: {error}', file=sys.stderr)
            return 1
    return ending.status


def _record(options: argparse.Namespace, ros: Sequence[str]) -> int:
    """Record episodes of a task."""
    try:
        from armsim_ros.nodes.teleop.record import record
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: "
                            + extras_hint('gym', 'data')) from None
    with ending_by_signals() as ending:
        return record(options, ros, ending)


def _words() -> Words:
    words = parser('teleop', 'Move a running arm by keyboard, gamepad or leader arm. Ctrl-C halts '
                   'the arm and leaves.', json_too=False)
    words.epilog = ('exit status: 0 after Ctrl-C, 1 where a device or the arm is gone, 2 where '
                    'something is missing at the start')
    words.add_argument('--with', dest='device', type=_device, required=True, metavar='DEVICE',
                       help='keyboard; gamepad: the topic /joy or /dev/input/js0, another device '
                       'as gamepad:/dev/input/js1; leader:TOPIC: joint states of a leader arm')
    words.add_argument('--speed', type=share, default=0.5, metavar='SHARE',
                       help="share of servo's scales, or of the joints' velocity limits "
                       '(%(default)s)')
    words.add_argument('--record', nargs=2, metavar=('ENV_ID', 'DIR'),
                       help='record episodes of a task, such as armsim/PickCube-v1, in a data '
                       'set; the simulation of the task is started for it')
    words.add_argument('--robot', default='sunday',
                       help='of --record and of a leader: its name or folder (%(default)s)')
    servo = words.add_argument_group('keyboard and gamepad')
    servo.add_argument('--frame', default='', help='link whose axes the keys and sticks mean '
                       '(the base of the planning group)')
    servo.add_argument('--servo', default='/servo_node', metavar='NODE',
                       help='name of servo_node (%(default)s)')
    leader = words.add_argument_group('leader')
    leader.add_argument('--controller', default='', metavar='NAME',
                        help='forward controller (the first that is loaded)')
    leader.add_argument('--approach', action='store_true',
                        help='go slowly to a leader that is farther away than 0.1 rad')
    return words


def _device(text: str) -> str:
    name, colon, place = text.partition(':')
    if (name == LEADER and place) or (name == GAMEPAD and bool(colon) == bool(place)) or (
            text == KEYBOARD):
        return text
    raise argparse.ArgumentTypeError(
        f"'{text}' is not a device; allowed: keyboard, gamepad, gamepad:/dev/input/js1, "
        'leader:TOPIC')
