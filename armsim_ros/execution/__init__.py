# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which controllers run a trajectory, what may start, and what stops it."""
