# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Runs the test suite in three jobs: `make test`. What is no option of this script goes to pytest.

A test of the real-time job that failed while the machine was under pressure runs again, alone and
once. JUnit reports of all jobs stay in build/tests.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

REPORTS = Path('build/tests')
#: Job -> how many of its tests run at a time; None: as many as the command line names.
JOBS = {'core': 'auto', 'real-time': None, 'alone': '1'}
#: A failed test with programs may run again if some program waited for a processor for more than
#: this share of its time, or if the host of a virtual machine kept more than that of it.
PRESSURE, STEAL = 0.3, 0.1
#: More failures under pressure than these are a failure of the run.
MOST_RERUNS = 3
#: Elements of a JUnit report -> what became of the test.
OUTCOMES = {'failure': 'failed', 'error': 'failed', 'skipped': 'skipped'}
#: Statuses of pytest after which its report is complete: passed, failed, nothing collected.
PASSED, FAILED, NOTHING = COMPLETE = (0, 1, 5)


@dataclass(frozen=True)
class Case:
    """
    A test of a report.

    :param outcome: ``passed``, ``skipped`` or ``failed``.
    :param why: first line of the reason of a skip or failure.
    :param seconds: its duration [s].
    :param pressure: share of its time in which a program waited for a processor.
    :param steal: share of the processors' time that the host kept.
    """

    name: str
    outcome: str
    why: str
    seconds: float
    pressure: float
    steal: float

    @property
    def starved(self) -> bool:
        """Whether a failure says nothing about the test."""
        return self.pressure > PRESSURE or self.steal > STEAL


def main() -> int:
    """Run the jobs; return pytest's status of the worst."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument('--workers', default='3', help='tests with programs at a time')
    parser.add_argument('--job', action='append', choices=JOBS, help='all where none is named')
    parser.add_argument('--no-reruns', action='store_true', help='one attempt, whatever happens')
    options, arguments = parser.parse_known_args()
    signal.signal(signal.SIGINT, lambda *_: None)  # pytest ends by it, and so this script
    begin = time.monotonic()
    cases: list[Case] = []
    starved: list[Case] = []
    for job in options.job or JOBS:
        print(f'\n== {job} tests', flush=True)
        start = time.monotonic()
        status = run(job, JOBS[job] or options.workers, '--job', job, *arguments)
        if status not in COMPLETE:
            return status
        found = read(job)
        cases += found
        total = sum(case.seconds for case in found) or 1.0
        pressure = sum(case.seconds * case.pressure for case in found) / total
        print(f'{job}: {time.monotonic() - start:.0f} s, mean pressure {pressure:.0%}')
        if job == 'real-time':
            starved += [case for case in found if case.outcome == 'failed' and case.starved]
    again = {}
    if starved and not options.no_reruns and len(starved) <= MOST_RERUNS:
        print('\n== failed under pressure: once more, alone', flush=True)
        if run('again', '1', *(case.name for case in starved)) not in COMPLETE:
            return FAILED
        again = {case.name: case.outcome for case in read('again')}
    show([case for case in cases if case.outcome == 'failed'], again)
    if len(starved) > MOST_RERUNS:
        print(f'{len(starved)} failed under pressure; up to {MOST_RERUNS} would have run again')
    failed = {case.name for case in cases if case.outcome == 'failed'}
    failed -= {name for name, outcome in again.items() if outcome == 'passed'}
    summarize(cases, failed, again, time.monotonic() - begin)
    if failed:
        return FAILED
    return PASSED if cases else NOTHING


def run(report: str, workers: str, *arguments: str) -> int:
    """Run pytest with this number of workers; return its status."""
    file = REPORTS / f'{report}.xml'
    file.unlink(missing_ok=True)
    return subprocess.Popen([
        sys.executable, '-m', 'pytest', '-n', workers, '--dist', 'loadfile',
        '--no-loadscope-reorder', f'--junit-xml={file}', *arguments]).wait()


def read(report: str) -> list[Case]:
    """Return the tests of a report; a test that failed twice over counts once."""
    cases: dict[str, Case] = {}
    for element in ET.parse(REPORTS / f'{report}.xml').iter('testcase'):
        properties = {
            each.attrib['name']: each.attrib['value'] for each in element.iter('property')}
        name = properties.get('id') or f"{element.get('classname')}::{element.get('name')}"
        result = next((each for each in element if each.tag in OUTCOMES), None)
        outcome, why = ('passed', '') if result is None else (
            OUTCOMES[result.tag], first_line(result.get('message')))
        if cases.get(name) is None or cases[name].outcome != 'failed':
            cases[name] = Case(
                name, outcome, why, float(element.get('time', 0)),
                float(properties.get('pressure', 0)), float(properties.get('steal', 0)))
    return list(cases.values())


def first_line(text: str | None) -> str:
    """Return the first line that has something to say."""
    return next((line.strip() for line in (text or '').splitlines() if line.strip()), '')


def show(failed: list[Case], again: dict[str, str]) -> None:
    """Print a table of what failed."""
    if failed:
        print('\nfailed; the share of the time in which some program waited for a processor, '
              'and the share of the processors that the host kept')
    for case in failed:
        print(f'{case.pressure:5.0%} waited, {case.steal:4.0%} kept; '
              f'then {again.get(case.name, "not run again")}: {case.name}\n      {case.why}')


def summarize(cases: list[Case], failed: set[str], again: dict[str, str], seconds: float) -> None:
    """Print how long it took, and what was skipped and why."""
    minutes, seconds = divmod(round(seconds), 60)
    skips = Counter(case.why for case in cases if case.outcome == 'skipped')
    print(f'\n{len(cases)} tests in {minutes} min {seconds} s: {len(failed)} failed, '
          f'{len(again)} run again')
    print('skipped: ' + ('; '.join(f'{n} {why}' for why, n in skips.items()) or 'none'))
    print(f'not run: the page in a browser (make test-page); reports of all tests: {REPORTS}')


if __name__ == '__main__':
    sys.exit(main())
