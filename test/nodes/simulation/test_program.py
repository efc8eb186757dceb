# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulation does before its first node exists."""

import pytest

from armsim_ros.cli.arguments import parse_arguments, UsageError
from armsim_ros.nodes.bringup.domain_lock import DomainTakenError, lock_domain
from armsim_ros.nodes.simulation.program import SimulationProgram


@pytest.fixture
def program(tmp_path, monkeypatch):
    """Return a function from a command line to its program; the locks go with the test."""
    monkeypatch.setenv('XDG_RUNTIME_DIR', str(tmp_path))
    made = []

    def make(*words):
        made.append(SimulationProgram(parse_arguments(words), lambda: False))
        return made[-1]

    yield make
    for lock in [lock for one in made for lock in one._locks]:
        lock.release()


def test_a_cell_keeps_the_namespace_of_each_robot(program):
    """A second simulation in one of them is refused, one in another is not."""
    program('robot:=two_bots')
    for side in ('left', 'right'):
        with pytest.raises(DomainTakenError, match=f'in namespace /{side}'):
            lock_domain([], program='simulation', namespace=f'/{side}')
    lock_domain([], program='simulation', namespace='/middle').release()


def test_robots_of_a_cell_are_not_remapped_into_one_namespace(program):
    """The message says where each gets its own."""
    with pytest.raises(UsageError, match=r"'__ns:=/x' would put .* 2 robots .*robots\.yaml"):
        program('robot:=two_bots', '--ros-args', '-r', '__ns:=/x')


def test_a_namespace_of_the_environment_leaves_robots_apart(program, monkeypatch):
    """It holds for nodes without a namespace of their own."""
    monkeypatch.setenv('ROS_NAMESPACE', '/x')
    program('robot:=two_bots')
    with pytest.raises(DomainTakenError, match='in namespace /left'):
        program('robot:=bot', 'namespace:=left')


@pytest.mark.parametrize(('manage', 'given_up'), [('true', True), ('false', False)])
def test_overruns_manage(program, manage, given_up):
    """
    Without it no time is ever given up: a loop that was late for an hour makes all of it up.

    Upstream: sleeping_policies.cpp, sleep_for_periodic_cycle.
    """
    made = program('robot:=bot', f'overrides:={{controller_manager.overruns.manage: {manage}}}')
    pacer = made._loop._pacer
    pacer._deadline -= 3600e9
    pacer._started = pacer._deadline - 3600e9
    pacer.wait(1e6)
    assert (pacer.statistics().dropped_ns > 0) is given_up
