# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From a start to a goal: planners, sampling, shortening."""
