# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small commands over the public interfaces of a running robot, for a terminal and for scripts."""
