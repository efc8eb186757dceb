# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""MuJoCo's model of robot and world, its state, and what touches in it."""
