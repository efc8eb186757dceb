# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs in processes and ROS domains of their own, and stacks that several tests share."""
