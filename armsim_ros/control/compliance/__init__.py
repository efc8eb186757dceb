# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that command efforts so that an arm yields like a spring."""
