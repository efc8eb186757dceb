# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The pace of stacks whose tests compare nothing with the wall's clock."""


#: Of /clock and joint states: at the same rate they wake the simulation together.
RATE = 50


def pace(factor, rate=RATE):
    """
    Return a word for bringup: how many simulated seconds pass in one of the wall's.

    :param rate: of /clock, of simulated time [Hz]; other than the usual one also of the joint
        states of the default robots.
    """
    states = '' if rate == RATE else f', controllers.joint_state_controller.publish_rate: {rate}'
    return (f'overrides:={{simulation.real_time_factor: {factor}, '
            f'simulation.clock_rate: {rate}{states}}}')


FASTER = pace(2.5)
#: For robots that take the physics long, such as fingers with contacts.
LITTLE_FASTER = pace(1.5)
#: For clients of others, whose executors take milliseconds for each message: as many come in a
#: second of the wall's as at the usual pace.
FASTER_BUT_CALM = pace(2.5, 20)
