# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects and worlds from files and texts: own YAML, SDF, URDF, MJCF, and simple shapes."""
