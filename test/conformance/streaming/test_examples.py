# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The examples that stream, run as a user runs them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

import pytest
from streaming_bench import ARM, Streamed
import yaml

statement = pytest.mark.statement
EXAMPLES = Path(__file__).parents[3] / 'examples'


@contextmanager
def started(
    arm: Streamed, name: str, *arguments: str, **streams: Any
) -> Iterator[subprocess.Popen[str]]:
    """Run an example in the domain of the arm; it is gone afterwards."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(arm.domain)}
    with subprocess.Popen([sys.executable, str(EXAMPLES / name), *arguments],
                          env=environment, text=True, **streams) as program:
        try:
            yield program
        finally:
            if program.poll() is None:
                program.kill()


@statement('FWD-9')
def test_policy(arm: Streamed) -> None:
    """It switches over, moves the arm in its wave, and gives it back."""
    before = arm.positions
    with started(arm, 'policy.py', '--controller', '/sunday/position_stream', '--instead-of', ARM,
                 '--seconds', '1.5', stderr=subprocess.PIPE) as program:
        arm.until(lambda: (arm.positions - before).min() > 0.05, 'all joints move', 60.0)
        _, text = program.communicate(timeout=60.0)
    assert (program.returncode, text) == (0, '')
    arm.go(before)  # the trajectory controller has the arm again


@statement('FWD-9')
def test_policy_with_an_unknown_controller(arm: Streamed) -> None:
    """It names the controllers that there are."""
    with started(arm, 'policy.py', '--controller', '/sunday/nobody',
                 stderr=subprocess.PIPE) as program:
        _, text = program.communicate(timeout=60.0)
    assert program.returncode == 1
    assert "no controller 'nobody'" in text
    assert 'position_stream' in text


@statement('SRV-23')
def test_joystick_parameters() -> None:
    """They are those that teleop_twist_joy declares, and stamp the twists."""
    text = (EXAMPLES / 'teleop_twist_joy.yaml').read_text(encoding='utf-8')
    content = yaml.safe_load(text)['teleop_twist_joy_node']['ros__parameters']
    axes = {'x', 'y', 'z'}
    turns = {'yaw', 'pitch', 'roll'}
    assert set(content) <= {
        'publish_stamped_twist', 'frame', 'require_enable_button', 'enable_button',
        'enable_turbo_button', 'inverted_reverse', 'axis_linear', 'scale_linear',
        'scale_linear_turbo', 'axis_angular', 'scale_angular', 'scale_angular_turbo'}
    assert content['publish_stamped_twist'] is True
    for key in ('axis_linear', 'scale_linear', 'scale_linear_turbo'):
        assert set(content[key]) <= axes
    for key in ('axis_angular', 'scale_angular', 'scale_angular_turbo'):
        assert set(content[key]) <= turns
    # Shares of servo's scale are between -1 and 1.
    scales = [content[key] for key in content if key.startswith('scale')]
    assert all(-1.0 <= value <= 1.0 for block in scales for value in block.values())
