# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""YAML text to values that know their place."""
