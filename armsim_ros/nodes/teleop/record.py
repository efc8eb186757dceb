# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim teleop --record``: episodes of a task, moved by keys, sticks or a leader."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, ExitStack
from pathlib import Path
import time
from typing import Any

import numpy as np

from armsim_ros.arrays import Vector
from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.clients.task_over_ros import task_over_ros
from armsim_ros.data.collect import opened, Plan
from armsim_ros.data.episodes import EpisodeRunner, Source
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.teleop.commands import (
    Command,
    DROP,
    GAMEPAD_HELP,
    HAND,
    HAND_BUTTON,
    HELP,
    Keys,
    MARK,
    pressed,
    RECORD_HELP,
    stick_command,
)
from armsim_ros.nodes.teleop.devices import Ending, find_gamepad, Terminal, terminal
from armsim_ros.nodes.teleop.leader import Following, Leader
from armsim_ros.nodes.teleop.servo_link import ANGULAR, JOINT, LINEAR
from armsim_ros.tasks.base import TaskEnv
from armsim_ros.tasks.hand import HandModel

#: Over ROS a task does not observe pictures.
_OBSERVED = 'environment_state_agent_pos'
#: An episode that the user does not end lasts two minutes.
_MOST_STEPS = 2400
#: Between two reads of the keys while no episode runs [s].
_PERIOD = 0.02


#: Returns what a device requests for a step: a command, or joint -> position [rad or m].
Device = Callable[[], 'Command | Mapping[str, float] | None']


class DroppedError(ArmsimError):
    """The user drops the episode, or leaves."""


class Operator:
    """
    A policy that asks a person.

    :param screen: is read for the keys.
    :param ending: whether the user leaves.
    :param keys: take what is read.
    :param speed: share of the largest speeds.
    """

    arguments: Mapping[str, Any] = {}

    def __init__(self, screen: Terminal, ending: Ending, keys: Keys, speed: float) -> None:
        self._screen, self._ending, self._keys, self._speed = screen, ending, keys, speed
        self.task: TaskEnv
        self.device: Device
        #: Of the hand: 1 for open or on; a gamepad and a leader set it, too.
        self.level = 0.0
        self._steps = 0

    def reset(self) -> None:
        """
        Wait for the start of an episode.

        :raises DroppedError: the user leaves instead.
        """
        self._steps, self.level = 0, self.task.hand.level
        self._screen.show('space starts the episode')
        while MARK not in self._keys.press(self._screen.read(_PERIOD), time.monotonic()):
            if self._ending:
                raise DroppedError('left')
        self._screen.show('recording; space ends the episode, backspace drops it')

    def __call__(self, _observation: Any) -> Vector | None:
        """
        Return the next action, None at the end of the episode.

        :raises DroppedError: the user drops it, or leaves.
        """
        marks = self._keys.press(self._screen.read(0.0), time.monotonic())
        if self._ending or DROP in marks:
            raise DroppedError('dropped')
        if MARK in marks and self._steps:
            return None
        if marks.count(HAND) % 2:
            self.level = float(self.level < 0.5)
        self._steps += 1
        return self._action(self.device())

    def _action(self, requested: Command | Mapping[str, float] | None) -> Vector:
        task, step = self.task, self._speed * self.task.period
        if not isinstance(requested, Command):
            return task.command_of(requested or {}, self.level)
        if not requested.joints:
            twist = step * np.array(requested.twist) * ([LINEAR] * 3 + [ANGULAR] * 3)
            return task.command_by(twist[:3].tolist(), self.level, twist[3:].tolist())
        names = dict(enumerate(task.joints))
        goals = {names[place]: task.commanded[names[place]] + step * JOINT * share
                 for place, share in requested.joints.items() if place in names}
        return task.command_of(goals, self.level)


def record(options: argparse.Namespace, ros: Sequence[str], ending: Ending) -> int:
    """
    Record episodes until the user leaves.

    :returns: 0 after Ctrl-C.
    :raises ArmsimError: the task, the folder, the device or the simulation is not there.
    """
    env_id, folder = options.record
    source = Source(env_id, {'robot': options.robot, 'obs_type': _OBSERVED,
                             'max_episode_steps': _MOST_STEPS}, f'teleop {options.device}')
    with ExitStack() as stack:
        screen = stack.enter_context(terminal(ending, needs_keys=True))
        keys = Keys()
        operator = Operator(screen, ending, keys, options.speed)
        runner = EpisodeRunner(source, operator)
        stack.callback(runner.close)
        operator.task = runner.task
        data = opened(Plan(source, 1), Path(folder), runner)
        operator.device = _device(options, ros, operator, keys, stack)
        runner.env = stack.enter_context(task_over_ros(runner.env, options.robot, lockstep=False))
        helps = {'keyboard': HELP, 'gamepad': GAMEPAD_HELP}
        print(helps.get(options.device.partition(':')[0], '') + RECORD_HELP, flush=True)
        while not ending:
            seed = data.facts[-1]['seed'] + 1 if data.episodes else 0
            try:
                episode = runner.run(seed)
            except DroppedError:
                screen.show('' if ending else 'the episode is dropped\n')
                continue
            data.add(episode)
            outcome = 'success' if episode.facts['success'] else 'no success'
            screen.show(f'episode {data.episodes - 1}: {episode.length} frames, {outcome}\n')
        screen.show(f"{data.episodes} episodes are in '{folder}'")
    return ending.status


def _device(options: argparse.Namespace, ros: Sequence[str], operator: Operator, keys: Keys,
            stack: ExitStack) -> Device:
    """Return what is requested in each step."""
    name, _, place = options.device.partition(':')
    if name == 'keyboard':
        return lambda: keys.command(time.monotonic())
    if name == 'gamepad':
        gamepad = find_gamepad(
            stack.enter_context(RosClient('armsim_teleop', ros)), place, options.timeout)
        was = [False]

        def sticks() -> Command | None:
            axes, buttons = gamepad.read()
            now = pressed(buttons, HAND_BUTTON)
            if now and not was[0]:
                operator.level = float(operator.level < 0.5)
            was[0] = now
            return stick_command(axes, buttons)

        return sticks
    hand = HandModel.of(operator.task.cell)
    joints = hand.arm_joints(operator.task.cell.model)
    leader = stack.enter_context(closing(Leader(
        stack.enter_context(ClientNode(name='armsim_teleop')), place, joints, options.timeout)))
    following = Following({name: operator.task.cell.model.joints[name].limits for name in joints},
                          options.speed, approach=options.approach)

    def lead() -> Mapping[str, float] | None:
        goals = following.step(leader.positions, operator.task.commanded, operator.task.period)
        level = leader.level(hand)
        if following.engaged and level is not None:
            operator.level = level
        return goals

    return lead
