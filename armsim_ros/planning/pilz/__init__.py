# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Point-to-point, linear and circular motions, as the Pilz planner makes them."""
