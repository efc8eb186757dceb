# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The table of statements: which were tested, by what, with which result.

Tests carry ``@pytest.mark.statement('ACT-3', 'ACT-4')``. Each folder beside this file is a part
with a table of its own; a file ``explained.yaml`` in it (statement: sentence) says why a
statement has no test.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
import re
from typing import Any

import pytest
import yaml

HERE = Path(__file__).parent
HEADER = ('| Statement | What is checked | Test | Result |', '|---|---|---|---|')


@dataclass
class Row:
    """One test and how it ended."""

    statements: tuple[str, ...]
    sentence: str
    test: str
    result: str = 'not run'


@dataclass
class ConformanceReport:
    """
    Collects the results of marked tests and writes the tables at the end of the session.

    :param path: the Markdown file; its other contents are kept.
    """

    path: Path
    parts: dict[str, dict[str, Row]] = field(default_factory=dict)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: Any, call: Any) -> Iterator[None]:
        """Note the result of a phase of a test."""
        report = yield
        names = [name for mark in item.iter_markers('statement') for name in mark.args]
        folder = Path(item.path).parent
        if not names or folder.parent != HERE:
            return report
        rows = self.parts.setdefault(folder.name, {})
        row = rows.setdefault(item.nodeid, Row(tuple(names), sentence(item), name_of(item)))
        if report.when == 'call' or report.outcome != 'passed':
            row.result = result_of(report)
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
    """Return file and name of a test."""
    return f'{Path(item.path).stem}::{item.name}'


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


def table(rows: Any, reasons: dict[str, str]) -> str:
    """Return a part's table, sorted by statement."""
    lines = [
        (
            statement,
            f'| {statement} | {cell(row.sentence)} | `{cell(row.test)}` | {cell(row.result)} |',
        )
        for row in rows
        for statement in row.statements
    ]
    tested = {statement for statement, _ in lines}
    lines += [
        (statement, f'| {statement} | {cell(reason)} | | not tested |')
        for statement, reason in reasons.items()
        if statement not in tested
    ]
    lines.sort(key=lambda line: sort_key(line[0]))
    return '\n'.join([*HEADER, *(text for _, text in lines)])


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
