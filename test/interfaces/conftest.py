# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The interface packages that are installed, and what they are expected to be."""

import json
from pathlib import Path
import sys
import time

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor

HERE = Path(__file__).parent

# The helpers beside this file, and the modules of the build, which are not installed.
sys.path[:0] = [str(HERE), str(HERE.parent.parent / 'interfaces')]


def pytest_generate_tests(metafunc):
    """Run a test that takes ``package`` once for each interface package."""
    if 'package' in metafunc.fixturenames:
        metafunc.parametrize('package', sorted({name.split('/')[0] for name in _definitions()}))


def _definitions():
    return json.loads((HERE / 'definitions.json').read_text('utf-8'))


@pytest.fixture(scope='session')
def definitions():
    """Return fields, defaults and constants of every type, as Jazzy's releases have them."""
    return _definitions()


@pytest.fixture(scope='session')
def type_hashes():
    """Return the RIHS01 hash of every type, the generated ones too."""
    return json.loads((HERE / 'type_hashes.json').read_text('utf-8'))


@pytest.fixture(scope='session')
def source():
    """Return the folder of the definition files."""
    return HERE.parent.parent / 'interfaces'


@pytest.fixture
def context():
    """Yield an initialized ROS context of this test alone."""
    context = rclpy.Context()
    rclpy.init(context=context)
    yield context
    context.try_shutdown()


@pytest.fixture
def node(context):
    """Yield a node."""
    node = rclpy.create_node('interfaces_test', context=context)
    yield node
    node.destroy_node()


@pytest.fixture
def wait_until(context, node):
    """Yield a function that spins the node until a condition holds; 15 s at most."""
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)

    def wait(condition, what):
        deadline = time.monotonic() + 15.0
        while not condition():
            assert time.monotonic() < deadline, f'not in time: {what}'
            executor.spin_once(timeout_sec=0.1)

    yield wait
    executor.shutdown()
