# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The pytest plugin: a running arm as a fixture, and what a failed test leaves behind.

It is loaded by every pytest of an environment that has the package, so it imports nothing of
weight before a test asks for an arm.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, ExitStack
import random
from typing import Any, TYPE_CHECKING

import pytest

from armsim_ros.testing.stacks import (
    ARM,
    arm_in_process,
    arm_of_stack,
    armsim_node,
    armsim_shared_stack,
    armsim_stack,
    DESCRIPTION,
    MODES,
    on_failure,
    requested,
    ros_domain,
    SEED,
    users_errors_reported,
    WallTimeLimit,
)

if TYPE_CHECKING:
    from armsim_ros.testing.arm import Arm

__all__ = ['arm', 'armsim_node', 'armsim_shared_stack', 'armsim_stack', 'ros_domain']

LIMIT = pytest.StashKey[WallTimeLimit]()

#: Option -> (ini key, default, help).
_OPTIONS = {
    '--armsim-mode': ('armsim_mode', MODES[0], 'default mode of tests whose marker sets none: '
                      'inprocess (stepped in the test) or process (the real programs)'),
    '--armsim-seed': ('armsim_seed', '0', "seed of the planner where no marker gives it; "
                      "'random' chooses and prints a seed"),
    '--armsim-domains': ('armsim_domains', '', 'ROS domain ids to lease, such as 30-39'),
    '--armsim-artifacts': ('armsim_artifacts', 'armsim-artifacts', 'folder for what failed tests '
                           'leave: recording, logs'),
}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options and the keys of the ini file."""
    group = parser.getgroup('armsim', 'a simulated robot arm')
    for option, (key, default, text) in _OPTIONS.items():
        group.addoption(option, dest=key, default=None, help=text)
        parser.addini(key, text, default=default)
    group.addoption('--armsim-keep', dest='armsim_keep', action='store_true',
                    help='keep recordings and logs of tests that passed, too')


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker, check the options, choose the seed."""
    config.addinivalue_line('markers', DESCRIPTION)
    mode, seed = _option(config, 'armsim_mode'), _option(config, 'armsim_seed')
    if mode not in MODES:
        raise pytest.UsageError(f"--armsim-mode={mode}: allowed are {', '.join(MODES)}")
    if seed != 'random' and not seed.lstrip('-').isdigit():
        raise pytest.UsageError(f"--armsim-seed={seed}: a whole number, or 'random'")
    worker = getattr(config, 'workerinput', None)
    if seed == 'random':
        chosen = worker['armsim_seed'] if worker else random.randrange(2**31)
    else:
        chosen = int(seed)
    config.stash[SEED] = chosen


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give the workers of pytest-xdist the seed of this run."""
    node.workerinput['armsim_seed'] = node.config.stash[SEED]


def pytest_report_header(config: pytest.Config) -> str | None:
    """Print a random seed."""
    if _option(config, 'armsim_seed') == 'random':
        return f'armsim: --armsim-seed={config.stash[SEED]}'
    return None


@pytest.fixture
def arm(request: pytest.FixtureRequest) -> Iterator[Arm]:
    """Give an arm at its start: that of the marker ``armsim``, or the default robot."""
    config = request.config
    with ExitStack() as stack:
        with users_errors_reported():
            desired = requested(
                request.node, mode=_option(config, 'armsim_mode'), seed=config.stash[SEED])
            made = stack.enter_context(
                arm_of_stack(request, desired) if desired.mode == 'process'
                else arm_in_process(desired))
        request.node.stash[ARM] = made
        stack.enter_context(_time_limit(request.node, desired.time_limit, made))
        yield made


# pytest leaves functions with __tracebackhide__ out of the reports of failures.
@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    """Limit the wall time of what is set up after the arm."""
    __tracebackhide__ = True
    with _limited(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Limit the wall time of the test itself."""
    __tracebackhide__ = True
    with _limited(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """Limit the wall time of what is torn down before the arm."""
    __tracebackhide__ = True
    with _limited(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Any:
    """Add what is known of the arm to the report of a failed test."""
    report = yield
    made = item.stash.get(ARM, None)
    if made is not None and call.when == 'call':
        config = item.config
        on_failure(item, report, made, seed=made.seed, folder=_option(config, 'armsim_artifacts'),
                   keep=config.getoption('armsim_keep'))
    return report


@contextmanager
def _time_limit(item: pytest.Item, seconds: float, arm: Arm) -> Iterator[None]:
    limit = item.stash[LIMIT] = WallTimeLimit(seconds, arm)
    limit.resume()
    try:
        yield
    finally:
        limit.pause()
        del item.stash[LIMIT]


@contextmanager
def _limited(item: pytest.Item) -> Iterator[None]:
    """Let a test's time pass; what happens between two phases is not the test's."""
    if LIMIT in item.stash:
        item.stash[LIMIT].resume()
    try:
        yield
    finally:
        if LIMIT in item.stash:
            item.stash[LIMIT].pause()


def _option(config: pytest.Config, key: str) -> str:
    given = config.getoption(key)
    return str(config.getini(key) if given is None else given)
