# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program list: the robots that bringup would find."""
