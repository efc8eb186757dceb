# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What all programs that open a port share: access rules, ports, limits, arguments."""
