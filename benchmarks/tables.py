# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables on the screen and between the marks of a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import os
from pathlib import Path


@dataclass(frozen=True)
class Table:
    """
    Figures with a headline.

    :param head: names of the columns.
    :param rows: cells as text.
    """

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    def print(self) -> None:
        """Print the table with its columns one below the other."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.head))]
        print(f'\n{self.title}')
        for first, *others in lines:
            rest = (cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True))
            print('  '.join([first.ljust(widths[0]), *rest]).rstrip())

    def markdown(self) -> list[str]:
        """Return the lines of the table for a page."""
        return [
            f'**{self.title}**', '', '| ' + ' | '.join(self.head) + ' |',
            '|' + '---|' * len(self.head),
            *('| ' + ' | '.join(row) + ' |' for row in self.rows), '',
        ]


def machine_load() -> str:
    """Return a sentence on what else the machine does."""
    averages = ', '.join(f'{value:.1f}' for value in os.getloadavg())
    return f'Load of the machine at the end (1, 5, 15 min): {averages}.'


def publish(page: str, name: str, table: Table, *remarks: str) -> None:
    """
    Print a table and remarks on it, and put them into a page where one is named.

    :param page: '' for none.
    :param name: of the page's section.
    """
    table.print()
    print(*remarks, sep='\n')
    if page:
        before = [line for remark in remarks for line in (remark, '')]
        replace_section(Path(page), name, [*before, *table.markdown()])


def replace_section(page: Path, name: str, lines: Sequence[str]) -> None:
    """Put lines between the marks ``name: begin`` and ``name: end`` of a page."""
    begin, end = f'<!-- {name}: begin -->', f'<!-- {name}: end -->'
    before, rest = page.read_text(encoding='utf-8').split(begin)
    after = rest.split(end)[1]
    page.write_text(before + begin + '\n' + '\n'.join(lines) + end + after, encoding='utf-8')
