# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.core.controller_manager``."""

from armsim_ros.moveit_py.answers import ExecutionStatus

__all__ = ['ExecutionStatus']
