# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Plans, inverse kinematics and timing: quality and processor time, beside those of peers."""
