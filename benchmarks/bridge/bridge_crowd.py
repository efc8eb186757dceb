# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""200 clients that send nonsense: what another client, and the bridge's memory, notice of it."""

from __future__ import annotations

from itertools import pairwise
import time

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain
from benchmarks.bridge.bridge import publishing, Readers, running_bridge
from benchmarks.options import Options
from benchmarks.stack import DOMAINS, peer, percentile, resident_mib
from benchmarks.tables import machine_load, publish, Table

_CLIENTS, _HALF_OPEN, _ROUNDS = 200, 60, 4


def main(options: Options) -> None:
    """Print the longest gap of a client beside the crowd, and memory after each crowd."""
    rows = []
    with private_domain(DOMAINS) as domain, \
            running_bridge(domain, f'max_clients:={_CLIENTS + 50}') as (bridge, url), \
            publishing(domain, 'joints'), publishing(domain, 'picture'), \
            ClientNode(domain, 'benchmark') as client:
        readers = Readers(url, 'joints', 'none', 1)
        time.sleep(2.0)
        process = bridge.process.pid
        for number in range(_ROUNDS + 1):
            readers.arrivals.clear()
            if number:
                with peer('bridge.crowd', url, str(_CLIENTS), str(options.messages),
                          str(_HALF_OPEN), domain=domain) as crowd:
                    crowd.wait_for_line('done', 300.0)
            else:
                time.sleep(options.seconds)
            gaps = [1e3 * (after - before) for before, after in pairwise(list(readers.arrivals))]
            time.sleep(3.0)
            rows.append((f'crowd {number}' if number else 'before', str(len(gaps)),
                         f'{percentile(gaps, 0.99):.0f}', f'{max(gaps):.0f}',
                         f'{resident_mib(process):.1f}',
                         str(client.node.count_publishers('/seen'))))
        readers.close()
    publish(options.report, 'bridge crowd', Table(
        f'{_CLIENTS} clients with {options.messages} random frames, nesting bombs, pictures that '
        f'are not read and {_HALF_OPEN} half-open handshakes beside a client that reads at 50 Hz',
        ('', 'messages', 'gap p99 ms', 'longest ms', 'MiB', 'publishers'), rows), machine_load())
