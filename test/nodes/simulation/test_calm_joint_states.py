# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often joint states of an arm at rest come, by who reads them."""

from itertools import pairwise

from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing.program import private_domain, start_program

TOPIC = '/joint_states'


def steps(client: ClientNode, count: int) -> set[int]:
    """Return the times between the stamps of the last 50 of so many messages [ns]."""
    messages = client.collect(TOPIC, JointState, count).wait(count)[-50:]
    stamps = [ns_from_time(message.header.stamp) for message in messages]
    return {later - earlier for earlier, later in pairwise(stamps)}


def test_a_client_gets_all_and_move_group_what_it_reads() -> None:
    """The Panda's 500 Hz for a client; 100 Hz where move_group alone subscribes."""
    with (
        private_domain() as domain,
        start_program('simulation', domain, 'robot:=panda'),
        ClientNode(domain, 'move_group') as calm,
    ):
        # The graph may know the name of a subscriber only when it is searched again, after 1 s.
        assert steps(calm, 1200) == {10_000_000}
        with ClientNode(domain, 'recorder') as client:
            assert steps(client, 200) == {2_000_000}
