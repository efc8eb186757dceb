# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim teleop`` in a terminal, as a user runs it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest
from sensor_msgs.msg import JointState, Joy
from streaming_bench import ARM, JOINTS, MANAGER, PLACE, Streamed
from teleop_terminal import Teleop

from armsim_ros.clients.controller_manager import ControllerManagerClient

statement = pytest.mark.statement


@statement('SRV-23')
def test_keys_move_the_tip_and_turn_joints(arm: Streamed) -> None:
    """Each as long as it is held; Ctrl-C ends it without a traceback."""
    with closing(Teleop(arm.domain, '--with', 'keyboard', '--speed', '1')) as teleop:
        arm.until(lambda: 'move the tip along x, y, z' in teleop.text, 'the help is printed')
        for key in 'wsadqelu6':
            before = arm.positions
            deadline = time.monotonic() + 60.0
            while np.abs(arm.positions - before).max() < 0.05:
                assert time.monotonic() < deadline, f'{key!r} moves nothing: {teleop.text}'
                teleop.press(key)
            arm.rest()
        assert teleop.end() == 0
        assert 'Traceback' not in teleop.text
        assert 'no command type is chosen' not in teleop.text


@statement('SRV-23')
def test_in_a_singularity_the_terminal_names_a_free_joint(arm: Streamed) -> None:
    """Where a key cannot move the tip."""
    arm.go([0.0] * 6)
    with closing(Teleop(arm.domain, '--with', 'keyboard')) as teleop:

        def shown() -> bool:
            teleop.press('w')
            return "free: turn 'joint_3'" in teleop.text

        arm.until(shown, 'the terminal names a free joint')
        assert teleop.end(signal.SIGTERM) == 128 + signal.SIGTERM


def test_a_signal_halts_the_arm_while_a_key_is_held(arm: Streamed) -> None:
    """Servo is paused then; the next start resumes it."""
    for _ in range(2):
        before = arm.positions
        with closing(Teleop(arm.domain, '--with', 'keyboard', '--speed', '1')) as teleop:

            def moves(before: np.ndarray = before, teleop: Teleop = teleop) -> bool:
                teleop.press('6')
                return bool(np.abs(arm.positions - before).max() > 0.05)

            arm.until(moves, 'the joint turns')
            assert teleop.end() == 0
        arm.rest()


def test_a_gamepad_moves_the_arm_by_its_topic(arm: Streamed) -> None:
    """Where messages cease, the arm comes to rest."""
    before = arm.positions
    message = Joy(axes=[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, -1.0], buttons=[0, 0, 0, 0, 1])
    with closing(Teleop(arm.domain, '--with', 'gamepad')) as teleop:
        with repeated(arm, Joy, '/joy', lambda: message):
            arm.until(lambda: arm.positions[5] < before[5] - 0.1, 'joint_6 turns')
        arm.rest()
        assert teleop.end() == 0


@contextmanager
def repeated(
    arm: Streamed, kind: type, topic: str, message: Callable[[], Any]
) -> Iterator[None]:
    """Publish messages until the context ends."""
    stop = threading.Event()
    with arm.publisher(kind, topic) as publisher:

        def publish() -> None:
            while not stop.wait(0.02):
                publisher.publish(message())

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()


@contextmanager
def leader(arm: Streamed) -> Iterator[list[float]]:
    """Publish the joints of a leader, in another order, until the context ends."""
    positions = [*PLACE]
    with repeated(arm, JointState, '/leader/joint_states', lambda: JointState(
            name=['gripper', *reversed(JOINTS)], position=[0.0, *reversed(positions)])):
        yield positions


def test_the_arm_follows_a_leader_from_near(arm: Streamed) -> None:
    """Not before; with a speed limit; and holds when the leader is silent."""
    with closing(Teleop(arm.domain, '--with', 'leader:/leader/joint_states')) as teleop:
        with leader(arm) as positions:
            positions[0] += 0.4
            arm.until(lambda: "'joint_1' is more than 0.1 rad" in teleop.text, 'it is refused')
            assert arm.positions[0] == pytest.approx(PLACE[0], abs=5e-3)
            positions[0] = PLACE[0] + 0.05
            arm.until(lambda: 'follows the leader' in teleop.text, 'it follows')
            positions[0], positions[5] = 0.5, -0.5
            arm.until(lambda: np.abs(arm.positions - positions).max() < 5e-3, 'it is there')
        arm.until(lambda: 'the leader is silent' in teleop.text, 'the silence is noticed')
        assert teleop.end() == 0
        assert 'Traceback' not in teleop.text
    states = ControllerManagerClient(arm.client, MANAGER).states()
    assert (states[ARM], states['position_stream']) == ('active', 'inactive')
    arm.rest()
    assert np.abs(arm.positions - positions).max() < 5e-3


def test_the_arm_approaches_a_leader_that_is_far_away(arm: Streamed) -> None:
    """Slowly, then it follows."""
    options = ('--with', 'leader:/leader/joint_states', '--approach')
    with closing(Teleop(arm.domain, *options)) as teleop, leader(arm) as positions:
        positions[0] += 0.4
        arm.until(lambda: 'the arm approaches' in teleop.text, 'it approaches')
        arm.until(lambda: 'follows the leader' in teleop.text, 'it follows')
        arm.until(lambda: abs(arm.positions[0] - positions[0]) < 5e-3, 'it is there')
        assert teleop.end() == 0


@pytest.mark.parametrize(('arguments', 'text'), [
    (('keyboard', '--servo', '/nowhere', '--timeout', '4'), "no servo_node '/nowhere'"),
    (('leader:/nowhere', '--timeout', '1'), "no message on '/nowhere' within 1 s"),
    (('leader:/sunday/joint_states', '--controller', 'velocity_stream'),
     "'velocity_stream' does not forward"),
])
def test_what_is_missing_is_named(
    arm: Streamed, arguments: tuple[str, ...], text: str
) -> None:
    """With status 2, and without a traceback."""
    with closing(Teleop(arm.domain, '--with', *arguments)) as teleop:
        assert teleop.wait() == 2
        assert text in teleop.text
        assert 'Traceback' not in teleop.text
