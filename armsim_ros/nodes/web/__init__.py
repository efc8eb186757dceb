# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page: see a robot and drive it in a browser. A plain client of public interfaces."""
