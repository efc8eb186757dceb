# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program copy: a robot's files in a folder of the user's own, to be changed."""
