# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Launch files that run: what is printed, what ends them, exit statuses. No ROS is needed."""

import os
import re
import signal
import sys
from textwrap import dedent

import pytest

from armsim_ros.testing.program import Program

HEAD = """
import asyncio

from launch import LaunchDescription
from launch.actions import *
from launch.event_handlers import OnExecutionComplete, OnProcessExit
from launch.events import Shutdown as ShutdownEvent
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ENDS = []


async def end(context):
    await asyncio.sleep(0.5)
    await context.emit_event(ShutdownEvent(reason='the coroutine has ended'))


def sh(script, name, **more):
    return ExecuteProcess(cmd=['sh', '-c', script], name=name, **more)


def generate_launch_description():
    return LaunchDescription([
"""
FOREVER = "trap 'echo stopped; exit 0' INT; echo ready; while true; do sleep 0.05; done"
STUBBORN = "trap '' INT TERM; echo ready; while true; do sleep 0.05; done"


@pytest.fixture
def launch(write):
    """Return a function that starts armsim launch with these entities."""
    running = []

    def start(entities):
        lines = '\n'.join(f'        {line}' for line in dedent(entities).strip().splitlines())
        path = write(f'{HEAD.strip()}\n{lines}\n    ])\n')
        program = Program.module('armsim_ros', 'launch', str(path), environment=dict(os.environ))
        running.append(program)
        return program

    yield start
    for program in running:
        program.__exit__(None, None, None)


def test_all_that_ends_well_is_status_0(launch):
    """P40: lines carry name and number; the launch ends when all have ended, with 0."""
    program = launch("""
        first := sh('echo one; echo two >&2', 'first'),
        RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[sh('echo next', 'b')])),
    """)
    assert program.wait(40.0) == 0
    lines = program.text.splitlines()
    assert '[first-1] one' in lines
    assert '[first-1] two' in lines
    assert lines.index('[b-2] next') > lines.index('[first-1] one')
    assert any(line.startswith('[INFO] [first-1]: process has finished cleanly [pid')
               for line in lines)


def test_ctrl_c_ends_all_with_status_0(launch):
    """P40: SIGINT goes to all once; the status is 0 and nothing is left."""
    program = launch(f"sh({FOREVER!r}, 'a'), sh({FOREVER!r}, 'b'),")
    program.wait_for_line(r'\[a-1\] ready')
    program.wait_for_line(r'\[b-2\] ready')
    program.signal(signal.SIGINT)
    assert program.wait(20.0) == 0
    assert program.text.count('stopped') == 2
    assert '[WARNING] [launch]: user interrupted with ctrl-c (SIGINT)' in program.text


def test_a_process_that_does_not_obey_is_killed(launch):
    """P40: SIGTERM and SIGKILL follow after the times that the file gives."""
    program = launch(f"sh({STUBBORN!r}, 'a', sigterm_timeout='0.3', sigkill_timeout='0.3'),")
    program.wait_for_line(r'ready')
    program.signal(signal.SIGINT)
    assert program.wait(20.0) == 0
    assert "sending 'SIGTERM'" in program.text
    assert "sending 'SIGKILL'" in program.text


def test_a_required_process_that_fails_ends_the_launch_with_1(launch):
    """P40: on_exit=Shutdown() of a process that failed ends the others; the status is 1."""
    program = launch(f"sh({FOREVER!r}, 'stays'), sh('sleep 0.5; exit 3', 'r', "
                     "on_exit=[Shutdown()]),")
    assert program.wait(40.0) == 1
    assert '[ERROR] [r-2]: process has died [pid' in program.text
    assert 'exit code 3' in program.text
    assert '[stays-1] stopped' in program.text


def test_a_required_process_that_ends_well_is_status_0(launch):
    """P40: on_exit=Shutdown() of a process that ended well is a good end."""
    program = launch(f"sh({FOREVER!r}, 'stays'), sh('sleep 0.5', 'r', on_exit=[Shutdown()]),")
    assert program.wait(40.0) == 0
    assert '[stays-1] stopped' in program.text


def test_a_process_that_dies_leaves_the_others(launch):
    """P40: without on_exit a process that died is only reported."""
    program = launch("sh('exit 4', 'dies'), sh('sleep 0.5; echo still', 'lives'),")
    assert program.wait(40.0) == 0
    assert 'exit code 4' in program.text
    assert '[lives-2] still' in program.text


def test_a_mistake_starts_nothing(launch):
    """P40: a mistake anywhere in the file is status 2, and no process was started."""
    program = launch("sh('echo started', 'a'), sh(LaunchConfiguration('none'), 'b'),")
    assert program.wait(40.0) == 2
    assert "launch configuration 'none' does not exist" in program.text
    assert 'started' not in program.text
    assert 'Traceback' not in program.text


def test_a_process_that_respawns(launch):
    """P36 respawn: a process that has ended is started again, until the launch ends."""
    program = launch("""
        again := sh('echo once', 'again', respawn=True, respawn_delay=0.05),
        RegisterEventHandler(OnProcessExit(target_action=again, on_exit=lambda event, context: (
            ENDS.append(1) or ([Shutdown(reason='enough')] if len(ENDS) == 3 else None)))),
    """)
    assert program.wait(30.0) == 0
    assert program.text.count('[again-1] once') >= 3


def test_a_process_that_respawns_is_complete_after_its_last_end(launch):
    """launch/actions/execute_local.py, __execute_process: its future is done without respawn."""
    program = launch("""
        RegisterEventHandler(OnExecutionComplete(
            target_action=(respawned := sh('echo once', 'again', respawn=True,
                                           respawn_max_retries=2)),
            on_completion=[sh('echo done', 'b')])),
        respawned,
    """)
    assert program.wait(40.0) == 0
    assert program.text.count('[again-1] once') == 3
    assert program.text.count('] done') == 1
    assert program.text.index('] done') > program.text.rindex('[again-1] once')


def test_a_coroutine_may_end_the_launch(launch):
    """launch/actions/opaque_coroutine.py: an event that it emits is handled at once."""
    program = launch(f"""
        sh({FOREVER!r}, 'a'),
        OpaqueCoroutine(coroutine=end),
    """)
    assert program.wait(20.0) == 0


def test_a_timer_starts_a_process_later(launch):
    """P36 TimerAction: what it holds comes after its time, and the launch waits for it."""
    program = launch("""
        TimerAction(period=0.3, actions=[sh('echo late', 'b')]), sh('echo early', 'a'),
    """)
    assert program.wait(40.0) == 0
    assert program.text.index('early') < program.text.index('late')


def test_what_is_not_installed_does_not_stop_the_rest(launch):
    """P39: it is named, its exit handlers fire, its on_exit=Shutdown does not."""
    program = launch("""
        absent := Node(package='no_one', executable='driver', on_exit=[Shutdown()]),
        RegisterEventHandler(OnProcessExit(target_action=absent, on_exit=[
            sh('sleep 0.3; echo after', 'b')])),
    """)
    assert program.wait(40.0) == 0
    assert 'unknown: no_one/driver is not installed and not started' in program.text
    assert '[b-2] after' in program.text


@pytest.mark.parametrize('ends', ['Shutdown()', "EmitEvent(event=ShutdownEvent(reason='gone'))"])
def test_a_window_that_is_not_there_does_not_end_the_launch(launch, ends):
    """What ends a launch with its window leaves it running where the window is not installed."""
    program = launch(f"""
        window := Node(package='no_one', executable='rviz2'),
        RegisterEventHandler(OnProcessExit(target_action=window, on_exit=[
            sh('echo on', 'next'), {ends}])),
        sh({FOREVER!r}, 'work'),
    """)
    program.wait_for_line(r'\[work-\d\] ready')
    program.wait_for_line(r'\[next-\d\] on')
    program.wait_for_line(r'\[next-\d\]: process has finished cleanly')
    assert program.stop(20.0) == 0
    assert '[work-2] stopped' in program.text


def test_lost_controllers_are_named_again_at_the_end_of_the_start(launch):
    """What should have loaded controllers and did not is named once more, with file and line."""
    program = launch(f"""
        Node(package='no_one', executable='controller_spawner', arguments=['arm']),
        Node(package='no_one', executable='driver'),
        ExecuteProcess(cmd=['false', 'ros2', 'control', 'load_controller', 'x'], name='f'),
        sh("sleep 0.5; echo 'You can start planning now!'; " + {FOREVER!r}, 'work'),
    """)
    program.wait_for_line(r'controllers may be missing')
    program.wait_for_line(r'it\.launch\.py:\d+: false has failed with status 1')
    program.stop(20.0)
    text = program.text.partition('You can start planning now!')[2]
    assert re.search(r'it\.launch\.py:\d+: no_one/controller_spawner is not installed', text)
    assert 'driver' not in text


def test_a_launch_without_a_controller_manager_says_so(launch):
    """Controllers that nothing in the launch could load: another launch file has their manager."""
    program = launch("""
        ExecuteProcess(cmd=['false', 'ros2', 'control', 'load_controller', 'x']),
    """)
    program.wait(40.0)
    assert re.search(r'controllers may be missing.*starts no controller manager', program.text)


def test_no_word_of_controllers_where_none_is_lost(launch):
    """A launch whose commands did what they say ends its start without a further line."""
    program = launch("""
        ExecuteProcess(cmd=['true', 'ros2', 'control', 'load_controller', 'x']),
        Node(package='no_one', executable='driver'),
    """)
    assert program.wait(40.0) == 0
    assert 'controllers may be missing' not in program.text


def test_a_robot_in_sdf_alone_ends_the_launch(launch, workspace):
    """A launch whose robot cannot be simulated ends with an error and does not wait for ever."""
    (workspace / 'arm.sdf').write_text('<sdf><plugin name="gz_ros2_control::A"/></sdf>')
    program = launch(f"""
        sh({FOREVER!r}, 'waits'),
        Node(package='ros_gz_sim', executable='create', arguments=[
            '-file', {str(workspace / 'arm.sdf')!r}]),
    """)
    assert program.wait(40.0) == 1
    assert re.search(r'it\.launch\.py:\d+: .*arm\.sdf is an SDF, which is not simulated',
                     program.text)


SERVER = """
import rclpy
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('server')


def answer(request, response):
    response.message = 'it was called'
    return response


node.create_service(Trigger, 'home', answer)
rclpy.spin(node)
"""


def test_ros2_service_call_is_found(launch, workspace, monkeypatch):
    """A launch file calls a service by the ros2 command, whose folder is not on PATH."""
    monkeypatch.setenv('PATH', os.defpath)
    (workspace / 'server.py').write_text(SERVER)
    program = launch(f"""
        ExecuteProcess(cmd=[{sys.executable!r}, {str(workspace / 'server.py')!r}], name='server'),
        ExecuteProcess(cmd=['ros2', 'service', 'call', '/home', 'std_srvs/srv/Trigger', '{{}}'],
                       name='call', on_exit=[Shutdown()]),
    """)
    program.wait(40.0)
    assert re.search(r'\[call-2\] .*it was called', program.text), program.text
    assert '[call-2]: process has finished cleanly' in program.text
