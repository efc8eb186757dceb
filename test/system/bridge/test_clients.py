# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients that others wrote, as they are installed, move the arm through the bridge."""

from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import subprocess
import sys

import pytest

from armsim_ros.testing.program import private_domain, start_program

EXAMPLES = Path(__file__).parents[3] / 'examples'
#: For an example [s].
PATIENCE = 120
#: Where packages of node and an environment with ros-mcp may be, since neither is a package of
#: Python's index that fits beside the others.
NODE_MODULES, AGENT_ENVIRONMENT = 'ARMSIM_TEST_NODE_MODULES', 'ARMSIM_TEST_ROS_MCP'


@pytest.fixture(scope='module')
def ports():
    """Run the default robot with a bridge, and return name of a protocol -> its port."""
    foxglove = ['foxglove:=control', 'foxglove_port:=0'] if find_spec('foxglove') else []
    with private_domain() as domain, start_program('bringup', domain) as stack, \
            start_program('bridge', domain, 'port:=0', *foxglove) as bridge:
        names = ('rosbridge', 'foxglove')[:2 if foxglove else 1]
        lines = [bridge.wait_for_line(f'{name}: ws', 30) for name in names]
        stack.wait_for_line('You can start planning now!', 60)
        yield {name: line.rpartition(':')[2].strip()
               for name, line in zip(names, lines, strict=True)}


@pytest.fixture
def port(ports):
    """Return the port of rosbridge."""
    return ports['rosbridge']


def run(words, port, **options):
    """Run an example to its end."""
    done = subprocess.run([*words, port], capture_output=True, text=True, timeout=PATIENCE,
                          **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_roslibpy(port):
    """A goal of move_group with its feedback and result, and topics."""
    if find_spec('roslibpy') is None:
        pytest.skip('roslibpy is not installed')
    text = run([sys.executable, EXAMPLES / 'bridge_roslibpy.py'], port)
    assert 'status SUCCEEDED, error code 1' in text


def test_foxglove(ports):
    """A trajectory as JSON to the controller, and serialized joint states."""
    if 'foxglove' not in ports:
        pytest.skip('foxglove-sdk is not installed')
    text = run([sys.executable, EXAMPLES / 'bridge_foxglove.py'], ports['foxglove'])
    assert 'mrad from the target' in text


def test_compas_fab(port):
    """Kinematics and a plan of move_group, executed by the controller."""
    if find_spec('compas_fab') is None:
        pytest.skip('compas_fab is not installed')
    text = run([sys.executable, EXAMPLES / 'bridge_compas_fab.py'], port)
    assert 'status SUCCEEDED' in text


def test_roslib(port, tmp_path):
    """Each encoding, raw types, a service of its own, a goal."""
    node, modules = shutil.which('node'), os.environ.get(NODE_MODULES, '')
    if node is None or not Path(modules, 'roslib').is_dir():
        pytest.skip(f'no node, or no roslib in the folder of ${NODE_MODULES}')
    (tmp_path / 'node_modules').symlink_to(modules)
    shutil.copy(EXAMPLES / 'bridge_roslib.mjs', tmp_path)
    text = run([node, tmp_path / 'bridge_roslib.mjs'], port)
    assert 'a service answers from JavaScript' in text


def test_ros_mcp(port):
    """The tools that a language model uses: explore, move, verify."""
    folder = Path(os.environ.get(AGENT_ENVIRONMENT) or 'none', 'bin')
    if not (folder / 'ros-mcp').is_file():
        pytest.skip(f'no environment with ros-mcp in ${AGENT_ENVIRONMENT}')
    path = f'{folder}{os.pathsep}{os.environ["PATH"]}'
    text = run([folder / 'python', EXAMPLES / 'bridge_agent.py'], port,
               env={**os.environ, 'PATH': path, 'PYTHONPATH': ''})
    assert 'mrad from the target' in text
