# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MoveIt's Python interface, answered by armsim_ros."""

from moveit import core, planning
from moveit.core import *  # noqa: F403
from moveit.planning import *  # noqa: F403
from moveit.utils import get_launch_params_filepaths

__all__ = ['get_launch_params_filepaths']
__all__ += core.__all__
__all__ += planning.__all__
