# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing of sensor messages: see point_cloud2."""
