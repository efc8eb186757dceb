# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What tf2_monitor computes of the messages."""

import pytest

from armsim_ros.nodes.upstream.tf2_monitor import main
from armsim_ros.nodes.upstream.transform_delays import TransformDelays

FRAME = 'Frame: {}, published by <no authority available>, Average Delay: {}, Max Delay: {}'


@pytest.fixture
def delays() -> TransformDelays:
    """Return the delays of two messages, half a second apart."""
    delays = TransformDelays()
    delays.add([('tool', 9.9), ('camera', 9.5)], 10.0)
    delays.add([('tool', 10.2)], 10.5)
    return delays


def test_frames_are_sorted(delays: TransformDelays) -> None:
    """tf2_ros/src/tf2_monitor.cpp: outputFrameInfo, in the order of a map."""
    assert delays.frame_lines(None) == [
        FRAME.format('camera', '0.5', '0.5'), FRAME.format('tool', '0.2', '0.3')]


def test_only_the_frames_of_a_chain_are_listed(delays: TransformDelays) -> None:
    """tf2_ros/src/tf2_monitor.cpp: spin."""
    assert delays.frame_lines(['base', 'tool']) == [FRAME.format('tool', '0.2', '0.3')]


def test_the_rate_counts_messages(delays: TransformDelays) -> None:
    """tf2_ros/src/tf2_monitor.cpp: their number over the time from the first to the last."""
    assert delays.broadcaster_lines() == [
        'Node: <no authority available> 4 Hz, Average Delay: 0.3 Max Delay: 0.3']


def test_stamps_in_the_future_are_no_delay(delays: TransformDelays) -> None:
    """tf2_ros/src/tf2_monitor.cpp: the largest delay starts at 0."""
    delays.add([('early', 12.0)], 11.0)
    assert delays.frame_lines(['early']) == [FRAME.format('early', '-1', '0')]


def test_without_messages_there_are_no_lines() -> None:
    """Neither frames nor broadcasters."""
    assert TransformDelays().frame_lines(None) == TransformDelays().broadcaster_lines() == []


def test_a_single_frame_is_not_enough(capfd: pytest.CaptureFixture[str]) -> None:
    """tf2_ros/src/tf2_monitor.cpp: main logs the usage and returns -1."""
    assert main(['base']) == 255
    assert 'TF_Monitor: usage: tf2_monitor framea frameb' in capfd.readouterr().err
