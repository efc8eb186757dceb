# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page's functions, a part per file; each handles the commands of its section of the panel."""
