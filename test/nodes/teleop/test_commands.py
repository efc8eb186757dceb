# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What keys and sticks request."""

import pytest

from armsim_ros.nodes.teleop.commands import (
    Command,
    DROP,
    HELD,
    Keys,
    MARK,
    MOVES,
    PAUSE,
    stick_command,
    TURNS,
)


@pytest.mark.parametrize(('key', 'twist'), [
    *((key, (*way, 0, 0, 0)) for key, way in MOVES.items()),
    *((key, (0, 0, 0, *axis)) for key, axis in TURNS.items())])
def test_a_letter_moves_or_turns_the_tip(key, twist):
    """Along or about an axis, both ways, at full share."""
    keys = Keys()
    assert keys.press(key, 5.0) == ''
    assert keys.command(5.0) == Command(twist)


def test_no_two_keys_are_the_same():
    """Each key has a single meaning."""
    names = [*MOVES, *TURNS, *'123456789', 'r', 'g', PAUSE, MARK, DROP]
    assert len(set(names)) == len(names)


def test_a_digit_turns_a_joint_and_r_reverses_it():
    """The digits count from 1, the places from 0."""
    keys = Keys()
    keys.press('3', 0.0)
    assert keys.command(0.0) == Command(joints={2: 1.0})
    keys.press('r3', 0.1)
    assert keys.command(0.1) == Command(joints={2: -1.0})
    keys.press('rr9', 0.2)
    assert keys.command(0.2) == Command(joints={8: -1.0})


def test_a_key_counts_until_it_is_not_repeated():
    """And again with each repetition."""
    keys = Keys()
    assert keys.command(0.0) is None
    keys.press('w', 1.0)
    keys.press('', 1.0 + 0.9 * HELD)
    assert keys.command(1.0 + 0.9 * HELD) is not None
    keys.press('', 1.0 + 1.1 * HELD)
    assert keys.command(1.0 + 1.1 * HELD) is None


def test_only_the_last_key_moves():
    """What was typed ahead must not move anything later; space and unknown keys stop."""
    keys = Keys()
    assert keys.press('wwwwa', 0.0) == ''
    assert keys.command(0.0) == Command((0, 1, 0, 0, 0, 0))
    assert keys.press('w ', 0.0) == MARK
    assert keys.command(0.0) is None
    keys.press('wx', 0.0)
    assert keys.command(0.0) is None


def test_arrow_keys_are_not_the_letters_of_their_sequences():
    """Their sequences end in letters, and with a tilde."""
    keys = Keys()
    assert keys.press('\x1b[A\x1bOs\x1b[3~', 0.0) == ''
    assert keys.command(0.0) is None


def test_both_backspaces_drop():
    """Terminals send either."""
    assert Keys().press('\x7fp\b', 0.0) == DROP + PAUSE + DROP


def test_sticks_at_rest_request_nothing():
    """Neither does noise within the deadband, nor a message without axes."""
    assert stick_command([0.05, -0.09, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0] * 11) is None
    assert stick_command([], []) is None


def test_sticks_move_the_tip():
    """Left stick in x and y, right stick in z and yaw, pad in roll and pitch; triggers nothing."""
    axes = [0.2, 0.3, -1.0, 0.4, 0.5, -1.0, -1.0, 1.5]
    assert stick_command(axes, [0] * 11) == Command((0.3, 0.2, 0.5, -1.0, 1.0, 0.4))
    assert stick_command([0.2, 0.3], []) == Command((0.3, 0.2, 0, 0, 0, 0))


def test_with_button_4_they_turn_joints():
    """Axes at rest name no joint."""
    axes = [0.2, 0.0, -1.0, 0.4, 0.0, -1.0, 0.0, -1.0]
    assert stick_command(axes, [0, 0, 0, 0, 1]) == Command(joints={0: 0.2, 2: 0.4, 5: -1.0})
