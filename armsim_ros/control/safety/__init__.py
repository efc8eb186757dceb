# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Drives and safety of an arm: modes, stops, and how the joints come to rest."""
