# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""rosapi: services with which clients explore the graph."""
