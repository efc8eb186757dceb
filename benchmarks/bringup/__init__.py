# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The whole stack as its users meet it: start, joint states, goals, page, tests."""
