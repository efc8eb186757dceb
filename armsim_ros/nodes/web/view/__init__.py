# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page shows as plain values: triangles, curves, forms. Neither ROS nor a browser."""
