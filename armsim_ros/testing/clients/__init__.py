# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small clients of running programs, one for each kind of endpoint, and relays that fail."""
