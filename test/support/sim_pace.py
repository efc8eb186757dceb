# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated time that runs quicker than the wall clock, for tests that wait for motions."""


def faster(factor=2.0):
    """
    Return the argument of bringup that lets simulated time run by a factor.

    A simulation that is asked for more than a busy machine can do answers late: robots with many
    contacts get a smaller factor.
    """
    return f'overrides:={{simulation.real_time_factor: {factor:g}}}'
