# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers that get commands as a stream: from a topic, or from a preceding controller."""
