# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The ``ros2`` command for a Python environment with the ros-jazzy wheels."""
