# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program teleop: a running arm moved by keyboard, gamepad or leader arm."""
