# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The Python interface of MoveIt, moveit_py, over the library; imported as ``moveit``."""
