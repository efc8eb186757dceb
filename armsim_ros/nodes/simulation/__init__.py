# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation program: physics, controllers and their manager, joint states, /clock, /tf."""
