# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From points that a sensor measures to occupied cells."""
