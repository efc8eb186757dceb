# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulation costs: tables on the screen, and in a page with ``--report``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

from benchmarks.options import Options
from benchmarks.simulation.lockstep import lockstep_tables
from benchmarks.simulation.real_time import real_time_tables
from benchmarks.tables import machine_load, replace_section, Table

#: Each makes tables; a line for another kind of measurement is all that it takes here.
PARTS: tuple[Callable[[Options], Iterable[Table]], ...] = (lockstep_tables, real_time_tables)


def main(options: Options) -> None:
    """Print all tables; write them where ``--report`` says."""
    lines: list[str] = []
    for part in PARTS:
        for table in part(options):
            table.print()
            lines += table.markdown()
    if options.report:
        replace_section(Path(options.report), 'simulation', [machine_load(), '', *lines])
