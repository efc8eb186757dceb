# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Tables and plots of a comparison of planners."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.tables import machine_load, replace_section

if TYPE_CHECKING:
    from benchmarks.planning.planning import Record

OURS = 'armsim_ros'
_HEAD = ('planner', 'solved', 'exact', 'motion exact', 'CPU ms median', 'p95', 'scene ms',
         'path rad', 'lasts s', 'CPU ratio', 'path ratio', 'time ratio')


def print_tables(records: Sequence[Record]) -> None:
    """Print a table a robot, and one a scene."""
    for title, part in _parts(records):
        print(f'\n{title}')
        rows = [_HEAD, *_rows(part)]
        widths = [max(len(row[k]) for row in rows) for k in range(len(_HEAD))]
        for row in rows:
            print('  '.join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)))


def write_report(records: Sequence[Record], page: Path) -> None:
    """Put the tables between the marks of a page, and the plots beside it."""
    lines = [machine_load(), '']
    for title, part in _parts(records):
        lines += [f'**{title}**', '', '| ' + ' | '.join(_HEAD) + ' |',
                  '|' + '---|' * len(_HEAD)]
        lines += ['| ' + ' | '.join(row) + ' |' for row in _rows(part)]
        lines.append('')
    folder = page.parent / 'images'
    folder.mkdir(parents=True, exist_ok=True)
    for robot in _unique(record.robot for record in records):
        name = f'planning_{robot}.svg'
        _plot([record for record in records if record.robot == robot], robot, folder / name)
        lines += [f'![Processor time of all planners, {robot}](images/{name})', '']
    replace_section(page, 'planning', lines)


def _parts(records: Sequence[Record]) -> Iterable[tuple[str, list[Record]]]:
    for robot in _unique(record.robot for record in records):
        part = [record for record in records if record.robot == robot]
        yield f'{robot}, all problems', part
        for scene in _unique(record.scene_name for record in part):
            yield f'{robot}, {scene}', [each for each in part if each.scene_name == scene]


def _unique(values: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(values))


def _rows(records: Sequence[Record]) -> list[tuple[str, ...]]:
    ours = {(each.scene_name, each.index): each for each in records if each.planner == OURS}
    names = _unique(each.planner for each in records)
    names.sort(key=lambda name: name != OURS)
    return [_row(name, [each for each in records if each.planner == name], ours) for name in names]


def _row(
    name: str, records: Sequence[Record], ours: dict[tuple[str, int], Record]
) -> tuple[str, ...]:
    cpu = [1000.0 * each.cpu for each in records]
    solved = [each for each in records if each.path is not None]
    moving = [each for each in records if each.motion is not None]
    count = len(records)
    pairs = [(ours[each.scene_name, each.index], each) for each in records
             if (each.scene_name, each.index) in ours]
    lengths = [a.path.length / b.path.length for a, b in pairs
               if a.path is not None and b.path is not None and b.path.length > 0.0]
    lasts = [a.motion.duration / b.motion.duration for a, b in pairs
             if a.motion is not None and b.motion is not None]
    return (
        name, f'{len(solved)}/{count}',
        f'{sum(each.path.clean for each in solved if each.path)}/{count}',
        f'{sum(each.motion.clean for each in moving if each.motion)}/{count}',
        _number(np.median(cpu), 1), _number(np.percentile(cpu, 95), 1),
        _number(np.median([1000.0 * each.scene for each in records]), 1),
        _median([each.path.length for each in solved if each.path]),
        _median([each.motion.duration for each in moving if each.motion]),
        _median([a.cpu / b.cpu for a, b in pairs if b.cpu > 0.0]), _median(lengths),
        _median(lasts),
    )


def _median(values: Sequence[float]) -> str:
    return _number(np.median(values), 2) if len(values) else '-'


def _number(value: float, digits: int) -> str:
    return f'{value:.{digits}f}'


def _plot(records: Sequence[Record], robot: str, path: Path) -> None:
    """Draw the share of problems that were solved exactly within a time."""
    import matplotlib

    matplotlib.use('Agg')
    matplotlib.rcParams['svg.hashsalt'] = 'planning'
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.0, 4.0), layout='constrained')
    for name in _unique(record.planner for record in records):
        part = [record for record in records if record.planner == name]
        times = sorted(record.cpu for record in part if record.path and record.path.clean)
        axes.step([*times, 5.0], [*np.arange(1, len(times) + 1) / len(part),
                                  len(times) / len(part)], where='post', label=name)
    axes.set(xscale='log', xlabel='processor time [s]', ylim=(0.0, 1.02), title=robot,
             ylabel='share solved, exact by the referee')
    axes.grid(alpha=0.3)
    axes.legend(loc='lower right', fontsize='small')
    figure.savefig(path, metadata={'Date': None})
    pyplot.close(figure)
