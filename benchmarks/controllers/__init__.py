# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The control tick: its lateness, its cost, the latency of actions."""
