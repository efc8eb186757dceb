# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Learned policies."""

from moveit.policies.policy import Policy

__all__ = ['Policy']
