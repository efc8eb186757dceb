# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The pace of stacks whose tests compare nothing with the wall's clock."""

#: How many seconds of simulated time pass in one of the wall's.
FACTOR = 2.5
#: A word for bringup.
FASTER = f'overrides:={{simulation.real_time_factor: {FACTOR}}}'
