# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs of the original stack by their own command lines: what launch files start."""
