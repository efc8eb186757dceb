# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Physics beside bare MuJoCo, worlds that change, cameras, grasps."""
