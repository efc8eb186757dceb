# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Fixtures that run the real programs on a private domain."""

from armsim_ros.testing.fixtures import client, ros_domain  # noqa: F401
