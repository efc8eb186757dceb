# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which command holds: types, stamps, age, and what is told of the others."""

import pytest
from servo_streams import jog, twist

from armsim_ros.servo.commands import (
    CommandInbox,
    CommandType,
    Finding,
    finite_vector,
    ServoStatus,
    weightiest,
)

NOW = 100_000_000_000
TIMEOUT = 100_000_000


@pytest.fixture
def inbox():
    """Return an inbox that follows twists."""
    made = CommandInbox(TIMEOUT)
    made.choose(CommandType.TWIST)
    return made


def send(inbox, command=None, stamp=NOW, now=NOW):
    """Have a command arrive."""
    command = command or twist((1, 0, 0))
    inbox.receive(command.type, lambda: command, stamp, now)
    return command


def test_a_command_lives_for_the_timeout(inbox):
    """It holds until it is as old as the timeout, and no longer."""
    command = send(inbox)
    assert inbox.command(NOW + TIMEOUT - 1) is command
    assert inbox.command(NOW + TIMEOUT) is None


def test_no_stamp_counts_from_the_arrival(inbox):
    """A stamp of 0 stands for the time of arrival."""
    command = send(inbox, stamp=0)
    assert inbox.command(NOW + TIMEOUT - 1) is command


def test_a_stamp_ahead_lets_nothing_live_longer(inbox):
    """The age runs from the arrival at the latest."""
    send(inbox, stamp=NOW + 400_000_000)
    assert inbox.command(NOW + TIMEOUT) is None


@pytest.mark.parametrize(
    ('offset', 'words'), [(-3_000_000_000, '3.000 s behind'), (600_000_000, '0.600 s ahead of')]
)
def test_another_clock(inbox, offset, words):
    """A stamp of another clock is refused with the offset and what to set."""
    send(inbox, stamp=NOW + offset)
    assert inbox.command(NOW) is None
    complaint = inbox.complaint(NOW)
    assert words in complaint
    assert 'clock' in complaint
    assert 'use_sim_time' in complaint


def test_type_not_chosen():
    """Without a type nothing holds, and the service is named."""
    inbox = CommandInbox(TIMEOUT)
    send(inbox)
    assert inbox.command(NOW) is None
    assert 'switch_command_type' in inbox.complaint(NOW)


def test_topic_chooses():
    """After a start the first command chooses the type, and the others are refused."""
    inbox = CommandInbox(TIMEOUT)
    inbox.topic_chooses = True
    command = send(inbox)
    send(inbox, jog(joint_1=1.0))
    assert inbox.command(NOW) is command
    send(inbox, jog(joint_1=1.0), NOW + TIMEOUT, NOW + TIMEOUT)
    assert 'JOINT_JOG' in inbox.complaint(NOW + TIMEOUT)


@pytest.mark.parametrize('kind', ['type', 'stamp'])
def test_a_stream_that_is_followed_keeps_its_status(inbox, kind):
    """
    Beside fresh commands one of another type, or with a stale stamp, changes nothing.

    Upstream: servo_node.cpp, servoLoop and processTwistCommand.
    """
    command = send(inbox)
    if kind == 'type':
        send(inbox, jog(joint_1=1.0))
    else:
        send(inbox, stamp=NOW - 3 * TIMEOUT)
    assert inbox.command(NOW) is command
    assert inbox.complaint(NOW) == ''


def test_another_type_alone_is_reported(inbox):
    """Where no command is followed the service is named."""
    send(inbox, jog(joint_1=1.0))
    assert inbox.command(NOW) is None
    assert 'TWIST is chosen' in inbox.complaint(NOW)


def test_garbage_ends_the_command(inbox):
    """What makes no sense ends the motion, names the field, and is forgotten at the next one."""
    send(inbox)
    inbox.receive(
        CommandType.TWIST, lambda: finite_vector('twist.linear', [float('nan')] * 3), NOW, NOW
    )
    assert inbox.command(NOW) is None
    assert inbox.complaint(NOW) == 'twist.linear holds nan'
    command = send(inbox)
    assert inbox.command(NOW) is command
    assert inbox.complaint(NOW) == ''


def test_a_complaint_ends(inbox):
    """It is told for a while only."""
    inbox.complain('something', NOW)
    assert inbox.complaint(NOW + 200_000_000) == 'something'
    assert inbox.complaint(NOW + 300_000_000) == ''


def test_another_type_forgets(inbox):
    """A command does not outlive its type."""
    send(inbox)
    inbox.choose(CommandType.POSE)
    assert inbox.command(NOW) is None


@pytest.mark.parametrize(('codes', 'reported'), [
    ((1, 4), 4), ((4, 6), 6), ((2, 6), 6), ((5, 6), 5), ((-1, 5), -1)])
def test_of_several_findings_the_status_has_the_weightiest(codes, reported):
    """Re-enacts servo.cpp, getNextJointState: each of these checks overrules those before it."""
    assert weightiest(Finding(ServoStatus(code)) for code in codes).code == reported
