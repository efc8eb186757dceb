# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Trajectories: taken or refused, sampled, monitored, brought to their end."""
