# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Build of ROS interface packages without CMake: generators from PyPI wheels, then a compiler."""
