# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What launch files use of MoveIt's Python packages."""
