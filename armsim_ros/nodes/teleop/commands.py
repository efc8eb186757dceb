# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What keys and sticks request; without ROS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
import re

Twist = tuple[float, float, float, float, float, float]

#: Key -> direction in which it moves the tip.
MOVES = {'w': (1, 0, 0), 's': (-1, 0, 0), 'a': (0, 1, 0), 'd': (0, -1, 0),
         'q': (0, 0, 1), 'e': (0, 0, -1)}
#: Key -> axis about which it turns the tip.
TURNS = {'l': (1, 0, 0), 'j': (-1, 0, 0), 'i': (0, 1, 0), 'k': (0, -1, 0),
         'u': (0, 0, 1), 'o': (0, 0, -1)}
HAND, PAUSE, REVERSE, MARK, DROP = 'g', 'p', 'r', ' ', '\x7f'
HELP = """\
w s  a d  q e   move the tip along x, y, z, forwards and backwards
l j  i k  u o   turn the tip about x, y, z
1 to 9          turn that joint; r reverses the direction
"""
GAMEPAD_HELP = """\
left stick      move the tip along x (up, down) and y
right stick     move the tip along z (up, down), turn it about z
pad             turn the tip about x (left, right) and y
button 4 held   the six axes turn joints 1 to 6
"""
SERVO_HELP = """\
space           stop
p               pause servo_node, or resume
Ctrl-C          leave
"""
RECORD_HELP = """\
g               open or close the gripper, switch the cup on or off
space           start an episode; end it and keep it
backspace       drop the episode
Ctrl-C          leave
"""
#: A key counts as held for so long: terminals repeat a held key more often than that [s].
HELD = 0.25
#: Axes deflected less are at rest.
DEADBAND = 0.1
#: A button that makes the sticks turn joints, and the button of the hand.
JOINTS_BUTTON, HAND_BUTTON = 4, 0
#: Axis of a gamepad -> place in a twist: the sticks, then the directional pad. Axes 2 and 5 are
#: triggers.
_AXES = {1: 0, 0: 1, 4: 2, 6: 3, 7: 4, 3: 5}
_JOINT_AXES = (0, 1, 3, 4, 6, 7)
_SEQUENCE = re.compile(r'\x1b(\[[0-9;]*|O)[A-Za-z~]')


@dataclass(frozen=True)
class Command:
    """
    A motion of the tip or of joints; shares of the speed, -1 to 1.

    :param twist: linear and angular.
    :param joints: place of a joint in the group -> its share; a twist is 0 then.
    """

    twist: Twist = (0.0,) * 6
    joints: Mapping[int, float] = field(default_factory=dict)


class Keys:
    """What is requested by the keys of a terminal, which reports no releases."""

    def __init__(self) -> None:
        self._held, self._pressed, self._direction = '', -math.inf, 1.0

    def press(self, text: str, now: float) -> str:
        """
        Take what the terminal has given.

        Only the last key counts: those of a moment ago must not move anything later.

        :param now: time [s].
        :returns: the keys that do not move, such as ``MARK``.
        """
        keys = _SEQUENCE.sub('', text).replace('\b', DROP)
        if keys.count(REVERSE) % 2:
            self._direction = -self._direction
        if keys:
            self._held, self._pressed = keys[-1], now
        return ''.join(key for key in keys if key in (HAND, PAUSE, MARK, DROP))

    def command(self, now: float) -> Command | None:
        """Return what the held key requests, None where no key is held."""
        key = self._held
        if now - self._pressed > HELD:
            return None
        if key in MOVES or key in TURNS:
            linear, angular = MOVES.get(key, (0, 0, 0)), TURNS.get(key, (0, 0, 0))
            x, y, z, roll, pitch, yaw = map(float, (*linear, *angular))
            return Command((x, y, z, roll, pitch, yaw))
        if '1' <= key <= '9':
            return Command(joints={int(key) - 1: self._direction})
        return None


def stick_command(axes: Sequence[float], buttons: Sequence[int]) -> Command | None:
    """
    Return what a gamepad requests, None where all is at rest.

    :param axes: as in ``sensor_msgs/Joy``: left and up are positive.
    :param buttons: 1 for each that is pressed.
    """
    def share(axis: int) -> float:
        value = axes[axis] if axis < len(axes) else 0.0
        return max(-1.0, min(1.0, value)) if abs(value) >= DEADBAND else 0.0

    if not any(share(axis) for axis in _AXES):
        return None
    if pressed(buttons, JOINTS_BUTTON):
        return Command(joints={place: share(axis) for place, axis in enumerate(_JOINT_AXES)
                               if share(axis)})
    twist = [0.0] * 6
    for axis, place in _AXES.items():
        twist[place] = share(axis)
    x, y, z, roll, pitch, yaw = twist
    return Command((x, y, z, roll, pitch, yaw))


def pressed(buttons: Sequence[int], button: int) -> bool:
    """Return whether a button is pressed."""
    return button < len(buttons) and bool(buttons[button])
