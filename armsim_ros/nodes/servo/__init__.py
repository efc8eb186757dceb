# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The servo_node program: streams of commands in, joint commands out."""
