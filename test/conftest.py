# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gives every test process a ROS graph of its own, before anything can import rclpy."""

from contextlib import ExitStack
import os
from pathlib import Path

import pytest

from armsim_ros.cli.environment import announce_often, FASTDDS_PROFILES

#: Domain ids up to 101 keep Fast DDS below the ephemeral ports of Linux.
_FIRST_DOMAIN, _LAST_DOMAIN = 40, 99


#: Folder -> what its tests share.
_SHARED = pytest.StashKey()


def pytest_configure(config):
    """Choose the domain; a ROS_DOMAIN_ID that the caller set is kept."""
    domain = _FIRST_DOMAIN + os.getpid() % (_LAST_DOMAIN - _FIRST_DOMAIN + 1)
    os.environ.setdefault('ROS_DOMAIN_ID', str(domain))
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    for name in ('RMW_IMPLEMENTATION', 'ROS_STATIC_PEERS', 'ROS_LOCALHOST_ONLY',
                 'ROS_NAMESPACE', *FASTDDS_PROFILES):
        os.environ.pop(name, None)
    announce_often()
    config.stash[_SHARED] = {}


@pytest.fixture(scope='session')
def ros_domain_id():
    """Return the domain that this test process and its children use."""
    return int(os.environ['ROS_DOMAIN_ID'])


@pytest.fixture(scope='session')
def until_folder_ends(request):
    """
    Return a function that enters a context and leaves it after the last test of a folder.

    A running stack takes half a core, also from the tests of other folders.
    """
    shared = request.config.stash[_SHARED]

    def enter(context, folder):
        return shared.setdefault(Path(folder), ExitStack()).enter_context(context)

    return enter


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """Leave what the tests of a folder shared where the next test is of another one."""
    shared = item.config.stash[_SHARED]
    for folder in list(shared):
        if nextitem is None or not nextitem.path.is_relative_to(folder):
            shared.pop(folder).close()
