# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Foxglove: topics, parameters and, where it is allowed, commands."""
