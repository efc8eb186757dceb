# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that answer at once: kinematics, validity, the description."""
