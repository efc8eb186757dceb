# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Hours of use, and messages that no client would send."""
