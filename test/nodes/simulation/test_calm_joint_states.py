# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often joint states of an arm at rest come, by who reads them."""

from collections import deque
from itertools import pairwise

from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing.program import private_domain, start_program

TOPIC = '/joint_states'


class Steps:
    """
    The times between the stamps of the last messages.

    :param count: of the messages.
    """

    def __init__(self, client: ClientNode, count: int) -> None:
        self._states = client.collect(TOPIC, JointState, count)
        self._stamps: deque[int] = deque(maxlen=count)

    def wait_until_all_are(self, step: int) -> None:
        """Wait until each of the times is this [ns]."""
        def are(message: JointState) -> bool:
            self._stamps.append(ns_from_time(message.header.stamp))
            return len(self._stamps) == self._stamps.maxlen and {
                later - earlier for earlier, later in pairwise(self._stamps)} == {step}

        self._states.wait_for(are)


def test_a_client_gets_all_and_move_group_what_it_reads() -> None:
    """The Panda's 500 Hz for a client; 100 Hz where move_group alone subscribes."""
    with (
        private_domain() as domain,
        start_program('simulation', domain, 'robot:=panda'),
        ClientNode(domain, 'move_group') as calm,
    ):
        # The graph may know the name of a subscriber only when it is searched again, after 1 s.
        Steps(calm, 50).wait_until_all_are(10_000_000)
        with ClientNode(domain, 'recorder') as client:
            Steps(client, 50).wait_until_all_are(2_000_000)
