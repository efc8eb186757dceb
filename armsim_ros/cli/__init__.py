# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The command line: which programs there are and which arguments they take."""
