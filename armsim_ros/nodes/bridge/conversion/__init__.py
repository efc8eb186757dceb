# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""ROS messages as JSON and CBOR, and back; compiled once per type."""
