# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers' nodes: a file per endpoint, named as its ROS name."""
