# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments and text of tf2_echo."""

from math import sqrt

import pytest
from stamped_transforms import stamped

from armsim_ros.nodes.upstream.tf2_echo import format_transform, main


@pytest.mark.parametrize(('rate', 'status'), [('fast', 2), ('1.0foo', 3), ('', 2)])
def test_a_rate_that_is_no_number(
    capsys: pytest.CaptureFixture[str], rate: str, status: int
) -> None:
    """tf2_ros/src/tf2_echo.cpp: main, std::stof."""
    assert main(['base', 'tool', rate]) == status
    out, err = capsys.readouterr()
    assert (out, err) == (
        '', f"Failed to convert rate argument '{rate}' to a floating-point number\n")


@pytest.mark.parametrize('rate', ['0', '-1', 'nan'])
def test_a_rate_that_is_not_positive(capsys: pytest.CaptureFixture[str], rate: str) -> None:
    """Upstream aborts with the same words, from rclcpp::Rate."""
    assert main(['base', 'tool', rate]) == 2
    assert capsys.readouterr().err == 'rate must be greater than 0\n'


@pytest.mark.parametrize('words', [[], ['base'], ['base', 'tool', '1', '2'], ['--help']])
def test_a_wrong_number_of_words(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    """tf2_ros/src/tf2_echo.cpp: main prints the usage on standard output; the status is 1."""
    assert main([*words, '--ros-args', '-r', 'a:=b']) == 1
    assert capsys.readouterr().out.startswith(
        'Usage: tf2_echo source_frame target_frame [echo_rate]\n\n')


def test_the_stamp_is_seconds_and_nanoseconds() -> None:
    """tf2_ros/src/tf2_echo.cpp does not pad the nanoseconds; a script may have adapted to it."""
    assert format_transform(stamped('base', 'tool', 12_000_000_345)).startswith('At time 12.345\n')


@pytest.mark.parametrize(('rotation', 'radian', 'degree'), [
    ((0.5, 0.5, 0.5, 0.5), '[1.571, -0.000, 1.571]', '[90.000, -0.000, 90.000]'),
    ((0.0, sqrt(0.5), 0.0, sqrt(0.5)), '[0.000, 1.571, 0.000]', '[0.000, 90.000, 0.000]'),
    ((0.0, -sqrt(0.5), 0.0, sqrt(0.5)), '[0.000, -1.571, 0.000]', '[0.000, -90.000, 0.000]'),
    ((0.5, 0.5, -0.5, 0.5), '[0.000, 1.571, 0.000]', '[0.000, 90.000, 0.000]')])
def test_angles(rotation: tuple[float, ...], radian: str, degree: str) -> None:
    """tf2/LinearMath/Matrix3x3.h: getEulerYPR, with yaw 0 where pitch is a right angle."""
    lines = format_transform(stamped('base', 'tool', 1.0, (0, 0, 0), rotation)).splitlines()
    assert lines[3:5] == [f'- Rotation: in RPY (radian) {radian}',
                          f'- Rotation: in RPY (degree) {degree}']
