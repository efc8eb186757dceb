# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Planning problems for this package and for its peers, judged by one referee.

Every planner is a process of its own; they take turns, problem by problem, so that all of them
meet the same load of the machine. What counts is processor time. The referee, which takes the
longest of all, works when they are done, on all cores.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import repeat
import json
import multiprocessing
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

from benchmarks.options import Options
from benchmarks.planning.problems import (
    ACCELERATION,
    cache_folder,
    Problem,
    problem_sets,
    problem_text,
    ProblemSet,
    VELOCITY,
)
from benchmarks.planning.referee import Referee, Verdict
from benchmarks.planning.report import print_tables, write_report

OURS = 'armsim_ros'
SECONDS = 5.0
"""Time that every planner has for a problem [s]."""


@dataclass(frozen=True)
class Peer:
    """
    A planner to compare with.

    :param script: in ``peers``.
    :param packages: what its environment needs; none for the interpreter that runs this.
    """

    script: str
    packages: tuple[str, ...] = ()


PEERS = {
    OURS: Peer('armsim.py'),
    'OMPL at its defaults': Peer('ompl_defaults.py'),
    'roboplan': Peer('roboplan_rrt.py', ('roboplan==0.7.0', 'roboplan-rrt==0.7.0',
                                         'roboplan-toppra==0.7.0')),
    'mplib': Peer('mplib_ompl.py', ('mplib==0.2.1',)),
    'pyroboplan': Peer('pyroboplan_rrt.py', ('pyroboplan==1.3.1',)),
    'vamp': Peer('vamp_rrtc.py', ('vamp-planner==0.6.4',)),
}


@dataclass(frozen=True)
class Record:
    """
    What one planner did with one problem.

    :param path: verdict on the path, or on the trajectory of a planner that gives no other.
    :param motion: verdict on the trajectory.
    :param cpu: processor time [s] of planning and timing.
    :param scene: processor time [s] of making the scene.
    """

    robot: str
    planner: str
    scene_name: str
    index: int
    solved: bool
    path: Verdict | None
    motion: Verdict | None
    cpu: float
    wall: float
    scene: float
    message: str = ''


class Worker:
    """A planner's process."""

    def __init__(self, name: str, peer: Peer, python: str, robot: dict[str, Any]) -> None:
        """Start it; it is not waited for."""
        self.name = name
        script = Path(__file__).parent / 'peers' / peer.script
        self._process = subprocess.Popen(
            [python, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True,
            env={**os.environ, 'PYTHONDONTWRITEBYTECODE': '1'})
        self.ready = bool(self._ask(robot))

    def plan(self, problem: Problem, seed: int) -> dict[str, Any]:
        """Return the planner's answer."""
        answer = self._ask({'problem': problem_text(problem), 'seed': seed, 'seconds': SECONDS})
        if answer is None:
            self.ready = False
            return {'message': 'the process ended', 'cpu': 0.0, 'wall': 0.0, 'scene': 0.0}
        return answer

    def end(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()

    def _ask(self, question: dict[str, Any]) -> dict[str, Any] | None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(json.dumps(question) + '\n')
            self._process.stdin.flush()
        except BrokenPipeError:
            return None
        line = self._process.stdout.readline()
        return json.loads(line) if line else None


@cache
def environment(name: str, peer: Peer) -> str | None:
    """Return the Python of a peer, made at its first use; None where it cannot be installed."""
    if not peer.packages:
        return sys.executable
    folder = cache_folder() / 'peers' / name
    python = folder / 'bin' / 'python'
    mark = folder / 'installed'
    if mark.exists():
        return str(python)
    subprocess.run([sys.executable, '-m', 'venv', str(folder)], check=True)
    made = subprocess.run(
        [str(python), '-m', 'pip', 'install', '--quiet', *peer.packages], check=False,
        capture_output=True, text=True)
    if made.returncode:
        print(f'{name} cannot be installed here: {made.stderr.strip().splitlines()[-1]}')
        return None
    mark.touch()
    return str(python)


class Judge:
    """Makes records of answers; lives in a process of its own."""

    referee: Referee

    @classmethod
    def take_office(cls, robot: dict[str, Any]) -> None:
        """Read the robot, once in the process."""
        cls.referee = Referee(
            robot['urdf'], robot['srdf'], robot['joints'], velocity=VELOCITY,
            acceleration=ACCELERATION)

    @classmethod
    def record(cls, robot: str, problem: Problem, name: str, answer: dict[str, Any]) -> Record:
        """Return the record of an answer."""
        path = motion = None
        if answer.get('times'):
            motion = cls.referee.trajectory(
                problem, answer['times'], answer['positions'], answer.get('velocities'),
                answer.get('accelerations'))
        if answer.get('path'):
            path = cls.referee.path(problem, answer['path'])
        elif motion is not None:
            length = answer.get('length', motion.length)
            path = Verdict(motion.clean, motion.fault, length)
        return Record(
            robot, name, problem.scene, problem.index, path is not None, path, motion,
            answer['cpu'], answer['wall'], answer['scene'], answer['message'])


def run(problems: ProblemSet, names: Sequence[str], seed: int) -> list[Record]:
    """Give every problem to every planner in turn."""
    text = problems.for_peers()
    workers = []
    for name in names:
        python = environment(name, PEERS[name])
        if python is not None:
            worker = Worker(name, PEERS[name], python, text)
            if worker.ready:
                workers.append(worker)
            else:
                print(f'{name} does not start with the robot {problems.robot}')
    answers = []
    try:
        for number, problem in enumerate(problems.problems):
            turn = number % len(workers)
            for worker in workers[turn:] + workers[:turn]:
                if worker.ready:
                    answers.append((problem, worker.name, worker.plan(problem, seed)))
            print(f'\r{problems.robot}: {number + 1} of {len(problems.problems)}', end='',
                  file=sys.stderr, flush=True)
    finally:
        for worker in workers:
            worker.end()
    print(file=sys.stderr)
    with ProcessPoolExecutor(
        os.cpu_count(), multiprocessing.get_context('spawn'), Judge.take_office, (text,)
    ) as office:
        return list(office.map(Judge.record, repeat(problems.robot), *zip(*answers, strict=True)))


def main(options: Options) -> None:
    """Run all problem sets; print the tables, and write them where ``--report`` says."""
    names = [name for name in PEERS if not options.peers or any(
        name.lower().startswith(wanted.strip().lower()) for wanted in options.peers.split(','))]
    records: list[Record] = []
    for problems in problem_sets(options.problems, options.problems_of_a_scene):
        records += run(problems, names, options.seed)
    print_tables(records)
    for record in records:
        verdict = record.path
        if record.planner == OURS and (verdict is None or not verdict.clean):
            print(f'{record.robot} {record.scene_name} {record.index}: '
                  f'{verdict.fault if verdict else record.message}')
    if options.report:
        write_report(records, Path(options.report))
