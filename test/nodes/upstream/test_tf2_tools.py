# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs of tf2_ros and tf2_tools, with a transform of another process."""

from collections.abc import Iterator
import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest
from tf2_msgs.msg import TFMessage

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.testing.program import private_domain, Program, ros_environment, start_program

TURNED = """At time 0.0
- Translation: [1.000, 2.000, -3.000]
- Rotation: in Quaternion [0.000, 0.000, 0.247, 0.969]
- Rotation: in RPY (radian) [0.000, -0.000, 0.500]
- Rotation: in RPY (degree) [0.000, -0.000, 28.648]
- Matrix:
  0.878 -0.479  0.000  1.000
  0.479  0.878  0.000  2.000
  0.000  0.000  1.000 -3.000
  0.000  0.000  0.000  1.000
"""
RUN = (sys.executable, '-m', 'armsim_ros', 'run')
PATIENCE = 60.0


@pytest.fixture(scope='module')
def domain() -> Iterator[int]:
    """Return a domain in which a process publishes a static transform."""
    with private_domain() as domain, start_program(
            'original', domain, 'static_transform_publisher',
            '1', '2', '-3', '0.5', '0', '0', 'base', 'tool'):
        yield domain


def started(domain: int, *words: str) -> Program:
    """Start a program as ``ros2 run`` does."""
    return Program(words, environment=ros_environment(domain), name=words[-1])


def test_the_transform_is_in_read_only_parameters(domain: int) -> None:
    """tf2_ros/src/static_transform_broadcaster_node.cpp: StaticTransformBroadcasterNode."""
    with ClientNode(domain, 'user') as client:
        client.latched('/tf_static', TFMessage, PATIENCE)
        (node,) = {one.node_name for one in client.node.get_publishers_info_by_topic('/tf_static')}
        assert node.startswith('static_transform_publisher_')
        parameters = ParameterClient(client, f'/{node}')
        assert parameters.get('translation.z') == -3.0
        assert parameters.get('child_frame_id') == 'tool'
        assert parameters.describe('rotation.w').read_only


def test_tf2_echo_prints_the_transform_until_ctrl_c(domain: int) -> None:
    """tf2_ros/src/tf2_echo.cpp: main, from the first waiting line to the status."""
    with started(domain, *RUN, 'tf2_ros', 'tf2_echo', 'base', 'tool', '20') as echo:
        echo.wait_for_line('Waiting for transform base ->  tool: Invalid frame ID "base" passed '
                           'to canTransform argument target_frame - frame does not exist')
        for _ in range(2):
            echo.wait_for_line('^At time ', PATIENCE, after=len(echo.text.splitlines()))
        os.killpg(echo.process.pid, signal.SIGINT)  # as a terminal
        assert echo.wait(PATIENCE) == 0
        assert TURNED in echo.text
        assert 'Traceback' not in echo.text


def test_tf2_echo_ends_by_ctrl_c_while_it_waits(domain: int) -> None:
    """A frame that never appears is named again and again; the status is 0."""
    with started(domain, *RUN, 'tf2_ros', 'tf2_echo', 'base', 'absent', '20') as echo:
        missing = 'Invalid frame ID "absent" passed to canTransform argument source_frame'
        echo.wait_for_line(missing, PATIENCE)
        os.killpg(echo.process.pid, signal.SIGINT)
        assert echo.wait(PATIENCE) == 0
        assert 'Traceback' not in echo.text
        assert 'At time' not in echo.text


def test_tf2_monitor_prints_chain_and_delays(domain: int) -> None:
    """tf2_ros/src/tf2_monitor.cpp: TFMonitor::spin."""
    with started(domain, *RUN, 'tf2_ros', 'tf2_monitor', 'base', 'tool') as monitor:
        for line in ('^Gathering data on base -> tool for 10 seconds...$',
                     '^RESULTS: for base to tool$', '^Chain is: base -> tool$',
                     r'^Net delay     avg = \S+: max = \S+$', '^Frames:$',
                     r'^Frame: tool, published by <no authority available>, '
                     r'Average Delay: \S+, Max Delay: \S+$',
                     r'^Node: <no authority available> \S+ Hz, '
                     r'Average Delay: \S+ Max Delay: \S+$'):
            monitor.wait_for_line(line, PATIENCE)
        os.killpg(monitor.process.pid, signal.SIGINT)
        assert monitor.wait(PATIENCE) == 0
        assert 'Traceback' not in monitor.text


def view_frames(domain: int, folder: Path, path: str) -> subprocess.CompletedProcess[str]:
    """Run view_frames in a folder, with a PATH."""
    return subprocess.run(
        [*RUN, 'tf2_tools', 'view_frames', '-t', '3', '-o', 'tree'], cwd=folder, text=True,
        env={**ros_environment(domain), 'PATH': path}, capture_output=True, check=False,
        timeout=PATIENCE)


def test_view_frames_without_graphviz(domain: int, tmp_path: Path) -> None:
    """The graph is written, and one line has the command that draws it."""
    done = view_frames(domain, tmp_path, str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert '"base" -> "tool"[label=' in (tmp_path / 'tree.gv').read_text()
    assert not (tmp_path / 'tree.pdf').exists()
    (line,) = [line for line in done.stderr.splitlines() if 'Graphviz' in line]
    assert line.endswith('dot -Tpdf tree.gv -o tree.pdf')


def test_view_frames_calls_dot(domain: int, tmp_path: Path) -> None:
    """tf2_tools/tf2_tools/view_frames.py: main."""
    (tmp_path / 'dot').write_text('#!/bin/sh\necho "$1 $2" > "$4"\n')
    (tmp_path / 'dot').chmod(0o755)
    done = view_frames(domain, tmp_path, str(tmp_path))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / 'tree.pdf').read_text() == '-Tpdf tree.gv\n'
    assert 'Graphviz' not in done.stderr


def test_an_interrupted_view_frames_writes_nothing(domain: int, tmp_path: Path) -> None:
    """The status is that of an interrupt, without a traceback."""
    output = str(tmp_path / 'tree')
    words = (*RUN, 'tf2_tools', 'view_frames', '-t', '600', '-o', output)
    with started(domain, *words) as viewer:
        viewer.wait_for_line('Listening to tf data for 600.0 seconds...', PATIENCE)
        os.killpg(viewer.process.pid, signal.SIGINT)
        assert viewer.wait(PATIENCE) == 130
        assert 'Traceback' not in viewer.text
        assert not list(tmp_path.iterdir())
