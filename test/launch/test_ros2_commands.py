# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch files that execute the ros2 command."""

import os
import sys

from armsim_ros.testing.program import Program

FILE = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=['ros2', 'pkg', 'prefix', 'std_msgs'], name='prefix'),
        ExecuteProcess(cmd=['ros2 interface package std_srvs'], name='shell', shell=True)])
"""


def test_ros2_is_found_in_an_environment_that_is_not_active(write):
    """PATH of the caller has no ros2; that of the environment runs, also in a shell."""
    environment = {**os.environ, 'PATH': '/usr/bin:/bin'}
    with Program.module('armsim_ros', 'launch', str(write(FILE)), environment=environment
                        ) as program:
        assert program.wait(60.0) == 0
        assert f'[prefix-1] {sys.prefix}\n' in program.text
        assert '[shell-2] std_srvs/srv/Trigger\n' in program.text
