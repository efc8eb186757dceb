# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The files of a user, read into checked, frozen values."""
