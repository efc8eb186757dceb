# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program that brings hardware components of a running manager into a state."""
