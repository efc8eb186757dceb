# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Texts of launch files that are known only when they run."""
