# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services that make runs repeatable and comparable: sync, digest, dump."""
