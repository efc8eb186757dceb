# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tells what is wrong with a robot's files, and what each key does here."""
