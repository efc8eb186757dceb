# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Measurements, each a module with a ``main``; they print tables and assert nothing."""
