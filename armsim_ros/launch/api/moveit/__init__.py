# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The parts of MoveIt's Python packages that launch files use."""
