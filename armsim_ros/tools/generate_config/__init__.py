# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Writes a first set of files for a robot that has only a URDF."""
