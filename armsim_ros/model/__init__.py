# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot: kinematic tree, geometry, limits, planning groups."""
