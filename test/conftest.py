# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Gives every test process a ROS graph of its own, before anything can import rclpy."""

import os

import pytest

from armsim_ros.cli.environment import announce_often, FASTDDS_PROFILES

#: Domain ids up to 101 keep Fast DDS below the ephemeral ports of Linux.
_FIRST_DOMAIN, _LAST_DOMAIN = 40, 99


def pytest_configure(config):
    """Choose the domain; a ROS_DOMAIN_ID that the caller set is kept."""
    domain = _FIRST_DOMAIN + os.getpid() % (_LAST_DOMAIN - _FIRST_DOMAIN + 1)
    os.environ.setdefault('ROS_DOMAIN_ID', str(domain))
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    for name in ('RMW_IMPLEMENTATION', 'ROS_STATIC_PEERS', 'ROS_LOCALHOST_ONLY',
                 'ROS_NAMESPACE', *FASTDDS_PROFILES):
        os.environ.pop(name, None)
    announce_often()


@pytest.fixture(scope='session')
def ros_domain_id():
    """Return the domain that this test process and its children use."""
    return int(os.environ['ROS_DOMAIN_ID'])
