# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The names of ``moveit.utils``."""

from armsim_ros.moveit_py.utils import create_params_file_from_dict, get_launch_params_filepaths

__all__ = ['create_params_file_from_dict', 'get_launch_params_filepaths']
