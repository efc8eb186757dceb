# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Replacements of upstream programs with the same command lines: what launch files start."""
