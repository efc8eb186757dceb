# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The pace of stacks whose tests compare nothing with the wall's clock."""


#: Of simulated time: at the rate of the joint states, both wake the simulation at once.
CLOCK_RATE = 50


def pace(factor, more=''):
    """Return a word for bringup: how many simulated seconds pass in one of the wall's."""
    return (f'overrides:={{simulation.real_time_factor: {factor}, '
            f'simulation.clock_rate: {CLOCK_RATE}{more}}}')


FASTER = pace(2.5)
#: For robots that take the physics long, such as fingers with contacts.
LITTLE_FASTER = pace(1.5)
