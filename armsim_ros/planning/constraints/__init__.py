# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Constraints on joints and links, and by how much a state misses them."""
