# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Data sets from recordings of topics."""
