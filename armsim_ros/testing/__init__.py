# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Small clients and fixtures for tests of a running stack, ours or the original.

Nothing here sleeps: every wait is for a condition and has a deadline.
"""
