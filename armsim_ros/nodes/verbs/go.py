# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim go``: plan to a named state or to joint positions, and go there."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from concurrent.futures import TimeoutError as FutureTimeoutError
import math
import sys
from typing import Any

from action_msgs.msg import GoalStatus
from moveit_msgs.action import MoveGroup
from std_msgs.msg import String

from armsim_ros.cli.arguments import UsageError
from armsim_ros.clients.description import bounds, describe
from armsim_ros.clients.motion import code_text, plan_goal, seconds, SUCCESS
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.clients.simulated_time import PAUSED, SimulatedTime
from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.verbs.state import joint_states, SRDF
from armsim_ros.nodes.verbs.terminal import parser, read, share, show, table, until

_ACTION = '/move_action'
_DESCRIPTIONS = ('/robot_description', SRDF)


def main(argv: Sequence[str] | None = None) -> int:
    """
    Move the robot.

    :returns: 0 where it has arrived, 1 where planning or motion failed.
    :raises ArmsimError: the robot is not there, or knows no such state.
    """
    words = parser('go', 'plan and move to a named state of the SRDF, or to joint positions')
    words.add_argument('--list', action='store_true',
                       help='print the named states of each planning group, and move nothing')
    words.add_argument('target', nargs='*', metavar='STATE | JOINT=VALUE',
                       help='such as scan_food, or joint_1=0.5 joint_2=-30deg (rad or m '
                       'without deg); all other joints stay where they are')
    words.add_argument('--group', default='', help='planning group (default: a group that has it)')
    words.add_argument('--speed', type=share, default=1.0, metavar='SHARE',
                       help='share of the velocity limits, 0 to 1 (default: 1)')
    words.add_argument('--acceleration', type=share, default=1.0, metavar='SHARE',
                       help='share of the acceleration limits, 0 to 1 (default: 1)')
    words.add_argument('--plan-only', action='store_true', help='do not move')
    asked, ros = read(words, argv)
    with RosClient('armsim_go', ros) as client:
        client.prepare(MoveGroup, _ACTION, action=True)
        simulated = SimulatedTime(client)
        robot = published_robot(client, asked.timeout)
        if asked.list:
            _print_states(robot, asked.group, asked.json)
            return 0
        group, target = find_target(robot, asked.target, asked.group)
        if simulated.paused():
            print(f'go: {PAUSED}', file=sys.stderr, flush=True)
        target = {**_others(client, robot, group, target, asked.timeout, simulated), **target}
        until(lambda: client.serves(MoveGroup, _ACTION, action=True) or None, asked.timeout,
              f'action {_ACTION}')
        wrapped = _run(client, plan_goal(
            group, target, speed=asked.speed, acceleration=asked.acceleration,
            plan_only=asked.plan_only))
        value, text, status = _outcome(client, wrapped, group, target, asked.plan_only, simulated)
        others = _other_groups(robot, group, asked)
        if others and not status:
            text += f"; '{asked.target[0]}' is a state of {others}, too: --group"
    show(value, asked.json, text)
    return status


def published_robot(client: RosClient, patience: float) -> RobotModel:
    """
    Return the robot whose descriptions are published.

    :raises ArmsimError: they are not.
    """
    texts: dict[str, str] = {}
    topics = {name: client.poll(String, name, qos.DESCRIPTION) for name in _DESCRIPTIONS}

    def look() -> bool | None:
        for name, topic in topics.items():
            for message in topic.take():
                texts[name] = message.data
        return True if len(texts) == len(topics) else None

    until(look, patience, ' and '.join(_DESCRIPTIONS))
    return describe(*(texts[name] for name in _DESCRIPTIONS))


def find_target(robot: RobotModel, words: Sequence[str], group: str
                ) -> tuple[str, dict[str, float]]:
    """
    Return the group and the joint positions [rad or m] that are meant.

    :raises UsageError: there is no such state, joint or group; names the nearest.
    """
    groups = robot.semantic.groups
    if not words:
        raise UsageError('a target is missing: a named state, or JOINT=VALUE; '
                         f'known states: {_known(robot, group)}')
    if group and group not in groups:
        raise UsageError(f"there is no planning group '{group}'; allowed: {', '.join(groups)}")
    if len(words) == 1 and '=' not in words[0]:
        return _named_state(robot, words[0], group)
    target: dict[str, float] = {}
    for word in words:
        joint, _, text = word.partition('=')
        if joint not in robot.active_joints:
            hint = nearest(joint, robot.active_joints)
            raise UsageError(f"there is no movable joint '{joint}'; "
                             f"{hint or 'known: ' + ', '.join(robot.active_joints)}")
        target[joint] = _value(joint, text)
        lower, upper = bounds(robot.joints[joint])
        if robot.joints[joint].type.value != 'continuous' and not lower <= target[joint] <= upper:
            raise UsageError(f'{joint}={text} is outside of its limits; '
                             f'allowed: {_range(robot, joint, lower, upper)}')
    fitting = [name for name, candidate in groups.items()
               if set(target) <= set(candidate.active_joints)]
    chosen = group or min(fitting, key=lambda name: len(groups[name].active_joints), default='')
    if not chosen or not set(target) <= set(groups[chosen].active_joints):
        raise UsageError(f"no planning group has all of {', '.join(target)}")
    return chosen, target


def _named_state(robot: RobotModel, state: str, group: str) -> tuple[str, dict[str, float]]:
    states = robot.semantic.named_states
    for name in [group] if group else robot.semantic.groups:
        if state in states.get(name, {}):
            return name, dict(states[name][state])
    known = sorted({each for name in states if not group or name == group
                    for each in states[name]})
    hint = nearest(state, known)
    raise UsageError(f"there is no state '{state}'; known: {', '.join(known) or 'none'}"
                     f"{'; ' + hint if hint else ''}")


def _known(robot: RobotModel, group: str) -> str:
    """Return the names of all states, or of those of a group, as text."""
    return ', '.join(sorted({each for name, states in robot.semantic.named_states.items()
                             if not group or name == group for each in states})) or 'none'


def _print_states(robot: RobotModel, group: str, as_json: bool) -> None:
    states = {name: {state: dict(values) for state, values in found.items()}
              for name, found in robot.semantic.named_states.items()
              if not group or name == group}
    rows = [['group', 'state', 'joints'], *(
        [name, state, ' '.join(f'{joint}={value:g}' for joint, value in values.items())]
        for name, found in states.items() for state, values in found.items())]
    show(states, as_json, table(rows))


def _other_groups(robot: RobotModel, group: str, asked: argparse.Namespace) -> str:
    """Return the other groups that have the state, where none was named."""
    if asked.group or len(asked.target) > 1:
        return ''
    return ', '.join(name for name, states in robot.semantic.named_states.items()
                     if name != group and asked.target[0] in states)


def _range(robot: RobotModel, joint: str, lower: float, upper: float) -> str:
    if robot.joints[joint].type.value == 'prismatic':
        return f'{lower:.4g} to {upper:.4g} m'
    return (f'{lower:.4g} to {upper:.4g} rad, {math.degrees(lower):.4g}deg to '
            f'{math.degrees(upper):.4g}deg')


def _others(client: RosClient, robot: RobotModel, group: str, target: Mapping[str, float],
            patience: float, simulated: SimulatedTime) -> dict[str, float]:
    """Return the positions of the joints of a group without a goal [rad or m]."""
    rest = set(robot.group(group).active_joints) - set(target)
    return {each['name']: each['position'] for each in joint_states(client, patience, simulated)
            if each['name'] in rest} if rest else {}


def _run(client: RosClient, goal: Any) -> Any:
    run = client.goal(MoveGroup, _ACTION, goal)
    try:
        while True:
            try:
                wrapped = run.result.result(0.2)  # so that Ctrl-C is heard
                break
            except (FutureTimeoutError, TimeoutError):
                continue
    except KeyboardInterrupt:
        run.cancel()
        run.result.result(2.0)
        raise
    if wrapped is None:
        raise ArmsimError('move_group rejected the goal; its log has the reason')
    return wrapped


def _outcome(client: RosClient, wrapped: Any, group: str, target: Mapping[str, float],
             plan_only: bool, simulated: SimulatedTime) -> tuple[dict[str, Any], str, int]:
    result = wrapped.result
    good = result.error_code.val == SUCCESS and wrapped.status == GoalStatus.STATUS_SUCCEEDED
    points = result.planned_trajectory.joint_trajectory.points
    duration = seconds(points[-1].time_from_start) if points else 0.0
    value = {'group': group, 'success': good, 'code': result.error_code.val,
             'text': code_text(result.error_code), 'planning_time': result.planning_time,
             'duration': duration}
    if not good:
        return value, value['text'], 1
    text = f'{group}: planned in {result.planning_time:.2f} s, '
    if plan_only:
        return value, f'{text}would move for {duration:.2f} s', 0
    now = {each['name']: each['position'] for each in joint_states(client, 2.0, simulated)}
    error = max((abs(now[name] - goal) for name, goal in target.items() if name in now),
                default=math.nan)
    value['largest_error'] = error
    return value, f'{text}moved in {duration:.2f} s, largest joint error {1e3 * error:.2f} mrad', 0


def _value(joint: str, text: str) -> float:
    try:
        if text.endswith('deg'):
            value = math.radians(float(text[:-3]))
        else:
            value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{joint} is '{text}'; allowed: a number of rad or m, or of degrees: "
                         '30deg')
    return value
