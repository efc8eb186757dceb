# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How often joint states of an arm at rest come, by who reads them."""

from itertools import pairwise

from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing.program import private_domain, start_program

TOPIC = '/joint_states'


def steps(client: ClientNode) -> list[int]:
    """Return the times between the stamps of 200 messages [ns]; the first may be of before."""
    messages = client.collect(TOPIC, JointState, 400).wait(200)
    stamps = [ns_from_time(message.header.stamp) for message in messages]
    return [later - earlier for earlier, later in pairwise(stamps)]


def test_a_client_gets_all_and_move_group_what_it_reads() -> None:
    """The Panda's 500 Hz for a client; 100 Hz where move_group alone subscribes."""
    with (
        private_domain() as domain,
        start_program('simulation', domain, 'robot:=panda'),
        ClientNode(domain, 'move_group') as calm,
    ):
        assert set(steps(calm)[50:]) == {10_000_000}
        with ClientNode(domain, 'recorder') as client:
            assert min(steps(client)) == 2_000_000
            assert set(steps(client)[-50:]) == {2_000_000}
