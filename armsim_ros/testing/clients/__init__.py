# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Small clients of running programs, a client for each kind of endpoint, and relays that fail."""
