# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tests of move_group's second planner: it comes when a request takes long, and goes with it."""

from contextlib import suppress
from pathlib import Path
import shutil
import time

from armsim_ros.resources import find_robot

SUCCESS = 1


def second_planners(domain):
    """Return the second planners' processes in a ROS domain."""
    found = []
    for process in Path('/proc').glob('[0-9]*'):
        with suppress(OSError):
            environment = (process / 'environ').read_bytes().split(b'\0')
            command = (process / 'cmdline').read_bytes()
            if f'ROS_DOMAIN_ID={domain}'.encode() in environment and b'second_planner' in command:
                found.append(process.name)
    return found


def test_it_is_started_once_and_ends_with_move_group(another_stack, tmp_path):
    """Requests that take longer than the delay share a process, and leave none behind."""
    robot = tmp_path / 'mine'
    shutil.copytree(find_robot('sunday'), robot)
    with (robot / 'ompl_planning.yaml').open('a', encoding='utf-8') as file:
        file.write('\nsecond_attempt_delay: 1.0e-6\n')
    with another_stack(f'config:={robot}') as stack:
        domain = stack.client.node.context.get_domain_id()
        assert second_planners(domain) == []
        for state in ('scan_food', 'home', 'scan_food'):
            result = stack.wait(stack.send_move(state)).result
            assert result.error_code.val == SUCCESS, result.error_code.message
        assert len(second_planners(domain)) == 1
    deadline = time.monotonic() + 20.0
    while second_planners(domain) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert second_planners(domain) == []
