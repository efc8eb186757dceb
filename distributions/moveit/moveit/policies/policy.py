# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.policies.policy``."""

from armsim_ros.moveit_py.devices import Policy

__all__ = ['Policy']
