# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that deactivates and unloads controllers of a running manager."""
