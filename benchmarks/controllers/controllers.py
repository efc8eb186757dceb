# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the controllers cost and how quickly they answer; see the modules for each table."""

from __future__ import annotations

from benchmarks.controllers import action_latency, control_thread, update_cost
from benchmarks.options import Options


def main(options: Options) -> None:
    """Print the tables of update cost, latencies, processor share and lateness."""
    for part in (update_cost, action_latency, control_thread):
        print(f'-- {part.__name__.rpartition(".")[2]}', flush=True)
        part.main(options)
