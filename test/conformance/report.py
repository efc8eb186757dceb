# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The table of statements: which were tested, by what, with which result.

Tests carry ``@pytest.mark.statement('ACT-3', 'ACT-4')``, and ``@pytest.mark.upstream('name')``
where they re-enact tests of the reference. Each folder beside this file is a part with a table of
its own; a file ``explained.yaml`` in it (statement: sentence) says why a statement has no test.
A test with several sets of parameters has one row for each set of statements.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
import re
from typing import Any

import pytest
import yaml

HERE = Path(__file__).parent
COLUMNS = ('Statement', 'What is checked', 'Test', 'Upstream test', 'Result')


@dataclass
class Row:
    """One test and how it ended, for each set of its parameters."""

    statements: tuple[str, ...]
    sentence: str
    test: str
    upstream: tuple[str, ...] = ()
    results: dict[str, str] = field(default_factory=dict)

    @property
    def result(self) -> str:
        """The results in words: how many passed, and each that did not."""
        counts = Counter(self.results.values())
        return ', '.join(
            word if len(self.results) == 1 else f'{count} {word}'
            for word, count in counts.items()
        )


@dataclass(eq=False)
class ConformanceReport:
    """
    Collects the results of marked tests and writes the tables at the end of the session.

    :param path: the Markdown file; its other contents are kept.
    """

    path: Path
    parts: dict[str, dict[tuple[str, tuple[str, ...]], Row]] = field(default_factory=dict)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: Any, call: Any) -> Iterator[None]:
        """Note the result of a phase of a test."""
        report = yield
        names = arguments_of(item, 'statement')
        path = Path(item.path)
        if not names or not path.is_relative_to(HERE):
            return report
        rows = self.parts.setdefault(path.relative_to(HERE).parts[0], {})
        row = rows.setdefault(
            (name_of(item), names),
            Row(names, sentence(item), name_of(item), arguments_of(item, 'upstream')),
        )
        if report.when == 'call' or report.outcome != 'passed':
            row.results[item.nodeid] = result_of(report)
        return report

    def pytest_sessionfinish(self) -> None:
        """Write the table of every part that was run."""
        text = self.path.read_text(encoding='utf-8') if self.path.exists() else ''
        for part, rows in sorted(self.parts.items()):
            text = with_part(text, part, table(rows.values(), explained(part)))
        self.path.write_text(text, encoding='utf-8')


def sentence(item: Any) -> str:
    """Return the first line of a test's docstring."""
    text = (item.function.__doc__ or '').strip().splitlines()
    return text[0] if text else ''


def name_of(item: Any) -> str:
    """Return file and name of a test, without its parameters."""
    return f'{Path(item.path).stem}::{getattr(item, "originalname", item.name)}'


def arguments_of(item: Any, mark: str) -> tuple[str, ...]:
    """Return the arguments of all marks of a name."""
    return tuple(argument for one in item.iter_markers(mark) for argument in one.args)


def result_of(report: Any) -> str:
    """Return a result as a word, with the reason where a test was not run."""
    if hasattr(report, 'wasxfail'):
        return f'known to fail: {report.wasxfail}'
    if report.skipped:
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else ''
        return f'skipped: {reason.removeprefix("Skipped: ")}'
    return 'passed' if report.passed else '**failed**'


def explained(part: str) -> dict[str, str]:
    """Return statement -> why it has no test."""
    path = HERE / part / 'explained.yaml'
    if not path.exists():
        return {}
    content = yaml.safe_load(path.read_text(encoding='utf-8')) or {}
    return {str(key): ' '.join(str(value).split()) for key, value in content.items()}


def table(rows: Iterable[Row], reasons: dict[str, str]) -> str:
    """Return a part's table, sorted by statement; columns that would be empty are left out."""
    lines = [
        (
            statement, row.sentence, f'`{row.test}`',
            ', '.join(f'`{name}`' for name in row.upstream), row.result,
        )
        for row in rows
        for statement in row.statements
    ]
    tested = {line[0] for line in lines}
    lines += [
        (statement, reason, '', '', 'not tested')
        for statement, reason in reasons.items()
        if statement not in tested
    ]
    lines.sort(key=lambda line: sort_key(line[0]))
    used = [i for i in range(len(COLUMNS)) if any(line[i] for line in lines)]
    head = [[COLUMNS[i] for i in used], ['---'] * len(used)]
    cells = [*head, *([cell(line[i]) for i in used] for line in lines)]
    return '\n'.join(f'| {" | ".join(row)} |' for row in cells)


def cell(text: str) -> str:
    """Return a text that does not end a cell of a table."""
    return ' '.join(text.replace('|', '\\|').split())


def sort_key(statement: str) -> list[Any]:
    """Sort ACT-10 after ACT-9."""
    return [
        (0, int(word), '') if word.isdigit() else (1, 0, word)
        for word in re.findall(r'\d+|\D+', statement)
    ]


def with_part(text: str, part: str, content: str) -> str:
    """Return a text with the part between its two marks replaced, or added at the end."""
    begin, end = f'<!-- begin {part} -->', f'<!-- end {part} -->'
    block = f'{begin}\n{content}\n{end}'
    if begin in text and end in text:
        head, rest = text.split(begin, 1)
        return head + block + rest.split(end, 1)[1]
    return f'{text.rstrip()}\n\n## {part}\n\n{block}\n'.lstrip()
