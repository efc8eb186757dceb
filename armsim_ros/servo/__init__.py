# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Streaming: from twists, joint jogs and poses to joint commands, cycle by cycle."""
