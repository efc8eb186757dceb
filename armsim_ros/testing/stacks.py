# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The marker ``armsim``, the arms of tests, their time limit, artifacts of a failed test."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
import json
from pathlib import Path
import re
import signal
import threading
from typing import Any, TYPE_CHECKING

import pytest

from armsim_ros.errors import ArmsimError, nearest
from armsim_ros.testing.program import domain_range, private_domain

if TYPE_CHECKING:
    from armsim_ros.clients.client_node import ClientNode
    from armsim_ros.model.cell import Cell
    from armsim_ros.testing.arm import Arm
    from armsim_ros.testing.robot_user import RobotUser
    from armsim_ros.testing.started_stack import SharedStack


MODES = ('inprocess', 'process')
DESCRIPTION = (
    "armsim(robot='sunday', world=None, mode='inprocess', seed=0, time_limit=60, faults={}, "
    "overrides={}): the arm that the fixture 'arm' gives to a test, its class or its module")


@dataclass(frozen=True)
class ArmRequest:
    """
    What a test wants.

    :param robot: a name or a folder, as ``bringup robot:=`` takes it.
    :param world: a world's name or file in place of the robot's own.
    :param mode: ``inprocess`` steps the stack in the test's process, ``process`` starts the real
        programs on a ROS domain of their own.
    :param seed: of the planner's random numbers; a negative one leaves it to the robot's files.
    :param time_limit: what a test may take, both of simulated and of wall time [s].
    :param faults: joint -> what is wrong with it, such as ``{'joint_1': {'blocked': True}}``.
    :param overrides: dotted path -> value over the robot's files, such as
        ``{'simulation.gravity': [0, 0, 0]}``.
    """

    robot: str = 'sunday'
    world: str | None = None
    mode: str = 'inprocess'
    seed: int = 0
    time_limit: float = 60.0
    faults: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)

    @property
    def settings(self) -> dict[str, Any]:
        """The overrides, and fault injection where a joint fails."""
        return {**self.overrides, **({'simulation.fault_injection': True} if self.faults else {})}

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments of bringup; tests that have them in common can share programs."""
        arguments = [f'robot:={self.robot}']
        if self.world is not None:
            arguments.append(f'world:={self.world}')
        if self.seed >= 0:
            arguments.append(f'seed:={self.seed}')
        if self.settings:
            arguments.append(f'overrides:={json.dumps(self.settings, sort_keys=True)}')
        return tuple(arguments)

    def cell(self) -> Cell:
        """Return the checked files of the robot."""
        return built_cell(self.robot, self.world, self.settings)


#: Seed where no marker gives it.
SEED: pytest.StashKey[int] = pytest.StashKey()
WORDS = tuple(field.name for field in fields(ArmRequest))


def requested(node: Any, *, mode: str, seed: int) -> ArmRequest:
    """
    Return the arguments of a test's markers; the innermost marker wins, argument by argument.

    :param node: the test, or the module for fixtures of a module.
    :param mode: where no marker sets it.
    :param seed: where no marker sets it.
    :raises pytest.UsageError: a word that there is not, or a value that cannot be.
    """
    words: dict[str, Any] = {'mode': mode, 'seed': seed}
    for marker in reversed(list(node.iter_markers('armsim'))):
        if marker.args:
            raise pytest.UsageError(
                f'{node.nodeid}: armsim() takes keyword arguments only, such as robot=...; '
                f'got {marker.args}')
        words.update(_checked(node.nodeid, marker.kwargs, words.get('overrides', {})))
    return ArmRequest(**words)


def _checked(where: str, given: Mapping[str, Any], before: Mapping[str, Any]) -> dict[str, Any]:
    words: dict[str, Any] = {}
    overrides = {**before, **given.get('overrides', {})}
    for word, value in given.items():
        if '.' in word:
            overrides[word] = value
        elif word in WORDS:
            words[word] = value
        else:
            hint = nearest(word, WORDS)
            raise pytest.UsageError(
                f"{where}: armsim() has no argument '{word}'; allowed: {', '.join(WORDS)}, or a "
                f"dotted path of the robot's settings{'; ' if hint else ''}{hint}")
    if words.get('mode', MODES[0]) not in MODES:
        raise pytest.UsageError(
            f"{where}: armsim(mode={words['mode']!r}); allowed: {', '.join(MODES)}")
    limit = words.get('time_limit', 1.0)
    if not isinstance(limit, (int, float)) or not limit > 0:
        raise pytest.UsageError(f'{where}: armsim(time_limit={limit!r}) must be above 0 [s]')
    if not isinstance(words.get('seed', 0), int):
        raise pytest.UsageError(f"{where}: armsim(seed={words['seed']!r}) must be a whole number")
    return {**words, 'overrides': overrides} if overrides else words


_cells: dict[tuple[str, str | None, str], Cell] = {}


def built_cell(robot: str, world: str | None, overrides: Mapping[str, Any]) -> Cell:
    """Return the checked files of a robot; each is read once a process."""
    from armsim_ros.model.cell_loading import load_cell

    key = (robot, world, repr(sorted(overrides.items())))
    if key not in _cells:
        _cells[key] = load_cell(robot, world=world, overrides=overrides)
    return _cells[key]


@contextmanager
def arm_in_process(desired: ArmRequest) -> Iterator[Arm]:
    """Give an arm that the test steps, built from files that are read once a process."""
    from armsim_ros.testing.in_process import InProcessArm

    yield InProcessArm(
        desired.cell(), seed=desired.seed, faults=desired.faults, time_limit=desired.time_limit)


@contextmanager
def arm_of_stack(request: pytest.FixtureRequest, desired: ArmRequest) -> Iterator[Arm]:
    """Give an arm of programs that the tests of a module share, as it is after their start."""
    shared: SharedStack = request.getfixturevalue('armsim_shared_stack')
    robot = shared.at_start(desired.arguments, lambda: desired.cell().settings.namespace)
    from armsim_ros.testing.ros_arm import RosArm

    with _faulty(robot, desired):
        yield RosArm(
            robot, desired.cell(), seed=desired.seed, time_limit=desired.time_limit)


@pytest.fixture(scope='module')
def armsim_shared_stack(ros_domain: int) -> Iterator[SharedStack]:
    """Keep the programs of a module's tests, which are put back to their start in between."""
    from armsim_ros.testing.started_stack import SharedStack

    shared = SharedStack(ros_domain)
    yield shared
    shared.close()


@pytest.fixture(scope='module')
def ros_domain(request: pytest.FixtureRequest) -> Iterator[int]:
    """Lease a ROS domain that no other test on this machine has, for a module of tests."""
    with private_domain(_domains(request)) as domain:
        yield domain


@pytest.fixture(scope='module')
def armsim_stack(request: pytest.FixtureRequest) -> Iterator[RobotUser]:
    """Run the programs of the module's marker ``armsim`` for a module of tests."""
    desired = requested(request.node, mode='process', seed=request.config.stash[SEED])
    with _running(request, desired) as robot:
        yield robot


@pytest.fixture
def armsim_node(ros_domain: int) -> Iterator[ClientNode]:
    """Give a node that spins on the leased domain."""
    from armsim_ros.clients.client_node import ClientNode

    with ClientNode(ros_domain) as node:
        yield node


@contextmanager
def _running(request: pytest.FixtureRequest, desired: ArmRequest) -> Iterator[RobotUser]:
    from armsim_ros.testing.robot_user import running_robot

    namespace = desired.cell().settings.namespace
    domain = request.getfixturevalue('ros_domain')
    with (
        running_robot(*desired.arguments, domain=domain, namespace=namespace) as robot,
        _faulty(robot, desired),
    ):
        yield robot


@contextmanager
def _faulty(robot: RobotUser, desired: ArmRequest) -> Iterator[None]:
    """Have joints fail for the time of the context."""
    for joint, fault in desired.faults.items():
        robot.fault(joint, **fault)
    yield
    for joint, fault in desired.faults.items():
        robot.fault(joint, **{kind: type(value)() for kind, value in fault.items()})


def _domains(request: pytest.FixtureRequest) -> range | None:
    given = request.config.getoption('armsim_domains') or request.config.getini('armsim_domains')
    return domain_range(given) if given else None


#: The arm of a test.
ARM: pytest.StashKey[Arm] = pytest.StashKey()
#: Events that the section shows; the recording has more.
SHOWN_EVENTS = 12


@contextmanager
def users_errors_reported() -> Iterator[None]:
    """End a test with the sentence of a user's error, without a traceback of ours."""
    __tracebackhide__ = True
    try:
        yield
    except (ArmsimError, pytest.UsageError) as error:
        reason = str(error)
    else:
        return
    pytest.fail(reason, pytrace=False)


def on_failure(
    item: pytest.Item, report: pytest.TestReport, arm: Arm, *, seed: int, folder: str, keep: bool
) -> None:
    """
    Add a section on the arm to the report of a failed test, and write its artifacts.

    :param folder: where artifacts go; relative ones lie beside the ini file.
    :param keep: write them for a test that passed, too.
    """
    if not (report.failed or keep):
        return
    name = re.sub(r'[^\w.-]+', '_', item.nodeid).strip('_')[-150:]
    place = item.config.rootpath / folder / name
    facts = {'robot': arm.name, 'seed': str(seed)}
    lines = []
    try:
        facts['digest'] = arm.digest()
        facts['simulated time'] = f'{arm.time:.3f} s'
        lines.append(f'state: {arm.summary()}')
        lines += [f'event: {event}' for event in arm.event_lines()[-SHOWN_EVENTS:]]
    except AssertionError as silence:  # the programs of a stack that ended answer nothing
        lines.append(f'state: unknown, {silence}')
    lines[:0] = [f'{key}: {value}' for key, value in facts.items() if value]
    for kind, path in _artifacts(arm, place):
        lines.append(f'{kind}: {path}')
        facts[kind] = str(path)
    lines.append(f'again: python -m pytest "{item.nodeid}" --armsim-seed={seed}')
    if report.failed:
        report.sections.append(('armsim', '\n'.join(lines)))
        item.user_properties.extend((f'armsim {key}', value) for key, value in facts.items())


def _artifacts(arm: Arm, place: Path) -> list[tuple[str, Path | str]]:
    """Write what the arm has to show; a disk that is full spoils no report."""
    try:
        return list(arm.save_artifacts(place))
    except OSError as error:
        return [('artifacts', f'not written: {error}')]


class WallTimeLimit:
    """
    Raises an AssertionError with the arm's state in a test that takes too long.

    Works in the main thread, where tests run. An alarm that was set elsewhere, such as
    pytest-timeout, is left alone and replaces this limit. Between the phases of a test the limit
    must be paused: what it raised there would end pytest itself.

    :param seconds: for set-up, call and teardown together [s].
    """

    def __init__(self, seconds: float, arm: Arm) -> None:
        self._seconds = self._left = seconds
        self._arm = arm

    def resume(self) -> None:
        """Let the time pass, as far as there is any left."""
        if (threading.current_thread() is threading.main_thread()
                and signal.getsignal(signal.SIGALRM) is signal.SIG_DFL):
            signal.signal(signal.SIGALRM, self._end)
            signal.setitimer(signal.ITIMER_REAL, self._left)

    def pause(self) -> None:
        """Stop the time until it is resumed."""
        if signal.getsignal(signal.SIGALRM) == self._end:
            self._left, _ = signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)

    def _end(self, *_: Any) -> None:
        self._left = 0.0
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        raise AssertionError(
            f'the test took more than {self._seconds:g} s of wall time; {self._arm.summary()}')
