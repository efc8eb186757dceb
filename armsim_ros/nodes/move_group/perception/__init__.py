# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From clouds and depth images to the octomap of the planning scene."""
