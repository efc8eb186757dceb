# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the Python environment of the source tree, stage by stage."""
