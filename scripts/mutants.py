# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Change the package in random places and report the changes that no test notices.

    make mutants ARGS="--count 300 --seed 1"
    make mutants ARGS="--only control/trajectory --count 20"

The tests run once with coverage, which takes a while and is repeated only when the tree has
changed. Each mutant is tested in a copy of the tree below ``build/mutants`` by the tests that
execute its line (or, of a line that the import executes, any line of its file). Up to the budget,
tests whose paths share the most names with the changed file are chosen first, then the quickest.
The first test that fails is printed, once it has passed without the mutant. The mutations are
those of cosmic-ray.
"""

from __future__ import annotations

import argparse
import ast
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
import difflib
from functools import cache
import hashlib
import json
import os
from pathlib import Path
from queue import SimpleQueue
import random
import shutil
import subprocess
import sys
import time
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PLACE = ROOT / 'build' / 'mutants'
TREE = PLACE / 'tree0'
#: Written by the tests' run with coverage, see ``test_contexts.py``.
DURATIONS = PLACE / 'durations.json'
SETTINGS = f"""[run]
source = {TREE}/armsim_ros
data_file = {PLACE}/coverage
parallel = true
sigterm = true
patch = _exit, execv
context = ${{TEST_CONTEXT-}}
"""
#: Operators that need arguments, and a decorator is not a place where one errs.
UNUSED = ('VariableInserter', 'VariableReplacer', 'RemoveDecorator')
#: A mutant may make its tests so many times slower before it counts as found [-], [s].
SLOWER, AT_LEAST = 3.0, 60.0
#: Tests with programs, and how long those of a folder start [s].
WITH_PROGRAMS, START = ('test/conformance', 'test/nodes', 'test/system'), 6.0
#: Job of the tests -> how many run at a time with coverage, under which programs are slower.
JOBS = {'core': 'auto', 'real-time': '2', 'alone': '1'}


@dataclass(frozen=True)
class Place:
    """A mutation: which operator of cosmic-ray, and its occurrence in the file."""

    path: str
    line: int
    column: int
    operator: str
    occurrence: int


@dataclass(frozen=True)
class Outcome:
    """
    What became of a mutant.

    :param outcome: ``killed``, ``survived`` or ``uncovered``.
    :param tests: how many were chosen.
    :param by: the test that failed, ``time``, or a status of pytest.
    """

    place: Place
    outcome: str
    difference: str
    tests: int
    seconds: float
    by: str = ''


def main() -> int:
    """Print a line per mutant and the survivors; return 0 where enough were killed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--count', type=int, default=300, help='mutants [300]')
    parser.add_argument('--seed', type=int, default=0, help='chooses the places [0]')
    parser.add_argument('--only', nargs='*', default=[''], metavar='PATH',
                        help='folders or files below armsim_ros/')
    parser.add_argument('--budget', type=float, default=120.0, metavar='S',
                        help='undisturbed duration of the tests of a mutant [120 s]')
    parser.add_argument('--tests', nargs='*', default=['test'], metavar='PATH',
                        help='the tests that may kill a mutant [test]')
    parser.add_argument('--workers', type=int, default=2, help='mutants at a time [2]')
    arguments = parser.parse_args()
    trees = SimpleQueue[Path]()
    for number in range(arguments.workers):
        _copy_tree(PLACE / f'tree{number}')
        trees.put(PLACE / f'tree{number}')
    covering = _coverage(arguments.tests)

    def test(place: Place) -> Outcome:
        tree = trees.get()
        try:
            return _test(place, tree, covering, arguments.budget)
        finally:
            trees.put(tree)

    outcomes = []
    with ThreadPoolExecutor(arguments.workers) as pool:
        for outcome in pool.map(
                test, _sample(arguments.only, arguments.count, arguments.seed)):
            outcomes.append(outcome)
            place = outcome.place
            print(f'{outcome.outcome:9} {outcome.seconds:5.0f} s {outcome.tests:4} tests  '
                  f'{place.path}:{place.line} {place.operator}  {outcome.by}', flush=True)
    survivors = [outcome for outcome in outcomes if outcome.outcome != 'killed']
    for outcome in survivors:
        print(f'\n{outcome.outcome}: {outcome.place.path}:{outcome.place.line}'
              f'\n{outcome.difference}')
    (PLACE / 'outcomes.json').write_text(json.dumps([asdict(each) for each in outcomes], indent=1))
    killed = len(outcomes) - len(survivors)
    print(f'\n{killed} of {len(outcomes)} mutants were killed '
          f'({100 * killed / max(len(outcomes), 1):.0f} %); all: {PLACE / "outcomes.json"}')
    return 0 if killed >= 0.95 * len(outcomes) else 1


def _files() -> list[str]:
    command = ['git', 'ls-files', '-z', '--cached', '--others', '--exclude-standard']
    listed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return [name for name in listed.stdout.split('\0') if name and (ROOT / name).is_file()]


def _copy_tree(tree: Path) -> None:
    """Bring a copy up to date; also after a mutant that was not put back."""
    files = _files()
    for name in files:
        source, target = ROOT / name, tree / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_symlink():
            target.unlink(missing_ok=True)
            target.symlink_to(source.readlink())
        elif not target.is_file() or target.read_bytes() != source.read_bytes():
            target.write_bytes(source.read_bytes())
    for path in [*(tree / 'armsim_ros').rglob('*.py'), *(tree / 'test').rglob('*.py')]:
        if str(path.relative_to(tree)) not in set(files):
            path.unlink()


def _coverage(tests: Sequence[str]) -> Mapping[tuple[str, int], set[str]]:
    """Return file and line -> tests, or whole files of tests whose programs execute it."""
    import coverage

    state = hashlib.sha256(repr(tests).encode())
    for name in sorted(_files()):
        if name.startswith(('armsim_ros/', 'test/')):
            state.update(name.encode() + (ROOT / name).read_bytes())
    known = PLACE / 'state'
    if not known.is_file() or known.read_text() != state.hexdigest():
        for old in PLACE.glob('coverage*'):
            old.unlink()
        settings = PLACE / 'coveragerc'
        settings.write_text(SETTINGS)
        DURATIONS.unlink(missing_ok=True)
        python = [sys.executable, '-m', 'coverage']
        environment = {**_environment(TREE), 'COVERAGE_PROCESS_START': str(settings)}
        for job, workers in JOBS.items():
            run = subprocess.run(
                [*python, 'run', f'--rcfile={settings}', '-m', 'pytest', '-q', '-p',
                 'test_contexts', '-n', workers, '--dist', 'loadfile', '--no-loadscope-reorder',
                 '--job', job, *tests], cwd=TREE, check=False, env=environment)
            if run.returncode not in (0, 1, 5):
                sys.exit('mutants: the tests did not run with coverage; see above')
        subprocess.run([*python, 'combine', '-q', f'--rcfile={settings}'], cwd=TREE, check=True)
        known.write_text(state.hexdigest())
    data = coverage.CoverageData(str(PLACE / 'coverage'))
    data.read()
    found: dict[tuple[str, int], set[str]] = {}
    for file in data.measured_files():
        name = str(Path(file).relative_to(TREE))
        for line, contexts in data.contexts_by_lineno(file).items():
            found[name, line] = {context for context in contexts if context}
    return found


def _environment(tree: Path) -> dict[str, str]:
    """Return an environment in which a copy wins over the installed package."""
    path = [str(tree), str(tree / 'scripts'), os.environ.get('PYTHONPATH', '')]
    domain = int(os.environ.get('ROS_DOMAIN_ID', 50)) + int(tree.name.removeprefix('tree'))
    return {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, path)),
            'ROS_DOMAIN_ID': str(domain),
            'TEST_DURATIONS': str(DURATIONS), 'PYTHONDONTWRITEBYTECODE': '1'}


def _sample(only: Sequence[str], count: int, seed: int) -> list[Place]:
    """Choose places evenly over those that the core and the nodes have, an operator for each."""
    paths = sorted(TREE.glob('armsim_ros/**/*.py'))
    places: dict[tuple[str, int, int], list[Place]] = {}
    for path in paths:
        name = str(path.relative_to(TREE))
        if name.startswith(tuple(f'armsim_ros/{each}' for each in only)):
            for place in _places(name):
                places.setdefault((place.path, place.line, place.column), []).append(place)
    choice = random.Random(seed)
    chosen = choice.sample(sorted(places), min(count, len(places)))
    return [choice.choice(places[each]) for each in chosen]


def _places(name: str) -> Iterator[Place]:
    """Yield all mutations of a file but those of annotations, which nothing evaluates."""
    from cosmic_ray.ast import get_ast_from_path, Visitor

    skipped = _annotations(ast.parse((TREE / name).read_text()))

    class Finder(Visitor):  # type: ignore[misc]  # cosmic-ray brings no types
        def __init__(self) -> None:
            self.places: list[Place] = []
            self.counts = dict.fromkeys(_operators(), 0)

        def visit(self, node: object) -> object:
            for operator_name, operator in _operators().items():
                for (line, column), _ in operator.mutation_positions(node):
                    self.places.append(
                        Place(name, line, column, operator_name, self.counts[operator_name]))
                    self.counts[operator_name] += 1
            return node

    finder = Finder()
    finder.walk(get_ast_from_path(TREE / name))
    for place in finder.places:
        at = place.line, place.column
        if not any(begin <= at < end for begin, end in skipped):
            yield place


def _annotations(tree: ast.AST) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return begin and end of all annotations and of what only type checkers execute."""
    found: list[ast.AST | None] = []
    for node in ast.walk(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            found.append(node.returns)
        elif isinstance(node, (ast.arg, ast.AnnAssign)):
            found.append(node.annotation)
        elif (isinstance(node, ast.If) and ast.unparse(node.test).endswith('TYPE_CHECKING')) or (
                isinstance(node, ast.Call) and ast.unparse(node.func) in ('TypeVar', 'cast')):
            found.append(node)
    return [((each.lineno, each.col_offset), (each.end_lineno or 0, each.end_col_offset or 0))
            for each in found if isinstance(each, (ast.expr, ast.stmt))]


@cache
def _operators() -> Mapping[str, Any]:
    from cosmic_ray import plugins

    return {name.removeprefix('core/'): plugins.get_operator(name)()
            for name in sorted(plugins.operator_names())
            if name.removeprefix('core/') not in UNUSED}


def _test(place: Place, tree: Path, covering: Mapping[tuple[str, int], set[str]], budget: float
          ) -> Outcome:
    """Run the covering tests on a mutant in a copy of the tree."""
    from cosmic_ray.mutating import mutate_code

    path = tree / place.path
    source = path.read_text()
    mutated = mutate_code(source, _operators()[place.operator], place.occurrence)
    difference = '\n'.join(difflib.unified_diff(
        source.splitlines(), mutated.splitlines(), lineterm='', n=2))
    contexts = covering.get((place.path, place.line))
    if contexts is not None and not contexts:  # executed by the import of the file
        contexts = set().union(*(found for (name, _), found in covering.items()
                                 if name == place.path))
    tests, duration = _ordered(contexts or (), place.path, budget)
    if not tests:
        return Outcome(place, 'uncovered', difference, 0, 0.0)
    begin = time.monotonic()
    limit = max(AT_LEAST, SLOWER * duration)
    by = 'nothing yet'
    while by and tests:
        path.write_text(mutated)
        try:
            by = _killer(tests, tree, limit)
        finally:
            path.write_text(source)
        # A test may depend on one that was not chosen.
        until = tests[:tests.index(by) + 1] if by in tests else tests
        if not by or not _killer(until, tree, limit):
            break
        print(f'fails without a mutant, too: {by}', flush=True)
        if by == 'time':
            by = ''
            break
        tests = [test for test in tests if test != until[-1]]
    return Outcome(place, 'killed' if by and tests else 'survived', difference, len(tests),
                   time.monotonic() - begin, by)


def _ordered(contexts: Collection[str], path: str, budget: float) -> tuple[list[str], float]:
    """Return the tests to run, in order, and how long they take without a mutant [s]."""
    durations: Mapping[str, float] = json.loads(DURATIONS.read_text())
    # Tests of a folder may share a program, whose lines count for the test that started it.
    folders = {_folder(context) for context in contexts if '::' not in context}
    tests = {test for test in durations if test in contexts or _folder(test) in folders}
    names = _names(path)
    far = {test: -len(names & _names(test.partition('::')[0])) for test in tests}
    chosen: list[str] = []
    total = 0.0
    taken: dict[str, float] = {}  # by folder; starting its stack counts once
    for test in sorted(tests, key=lambda test: (far[test], durations[test])):
        folder = _folder(test)
        seconds = durations[test] + (
            START if folder not in taken and folder.startswith(WITH_PROGRAMS) else 0.0)
        if chosen and total + seconds > budget:
            continue
        chosen.append(test)
        total += seconds
        taken[folder] = taken.get(folder, 0.0) + seconds
    places = {test: number for number, test in enumerate(durations)}

    def rank(test: str) -> tuple[float, str, int]:
        return taken[_folder(test)], test.partition('::')[0], places[test]

    return sorted(chosen, key=rank), total


def _folder(test: str) -> str:
    """Return the folder that may have a stack for its tests."""
    return str(Path(*Path(test.partition('::')[0]).parent.parts[:3]))


def _names(path: str) -> set[str]:
    """Return what a file and its folders are called, without what all are called."""
    return {name.removeprefix('test_') for name in Path(path).with_suffix('').parts[1:]}


def _killer(tests: Sequence[str], tree: Path, seconds: float) -> str:
    """Return the first test that fails, ``time`` or a status of pytest; '' where all pass."""
    names = tree / 'tests.txt'
    names.write_text('\n'.join(tests))
    process = subprocess.Popen(
        [sys.executable, '-m', 'pytest', '-x', '-v', '-p', 'no:cacheprovider', f'@{names}'],
        cwd=tree, env=_environment(tree), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        text=True, start_new_session=True)
    try:
        printed, _ = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        return 'time'
    finally:
        if process.poll() is None:
            os.killpg(process.pid, 9)
            process.wait()
    if process.returncode == 0:
        return ''
    begun = [test for test in tests if f'\n{test} ' in printed]
    return begun[-1] if begun else f'status {process.returncode}'


if __name__ == '__main__':
    if shutil.which('git') is None:
        sys.exit('mutants: git is needed to list the files')
    sys.exit(main())
