# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joints that fail on purpose."""

import math

import numpy as np
from pydantic import ValidationError
import pytest

from armsim_ros.config.controllers.controller_manager import ControllerManagerParameters
from armsim_ros.config.simulation import JointFault
from armsim_ros.control.faults import FaultInjector, FaultyControllers
from armsim_ros.control.manager.controller_manager import ControllerManager
from armsim_ros.errors import ControllerError


@pytest.fixture
def faulty(rig):
    """Return a rig whose commands pass through a fault injector, and the injector."""
    r = rig()
    faults = FaultInjector(r.hardware)
    manager = ControllerManager(faults, ControllerManagerParameters(), r.manager.context.model)
    r.manager = manager
    through = FaultyControllers([manager], faults)

    def step(count=1):
        for _ in range(count):
            through.update(r.now_ns, 0.01)
            r.hardware.step(0.01)
            r.now_ns += 10_000_000

    r.step = step
    return r, faults


def send(r, trajectory):
    """Move joint a, and return the goal."""
    arm = r.manager.controllers['arm']
    return arm.send_goal(trajectory((1.0, [0.5, 0.2], [0, 0]))).goal


def test_without_faults_nothing_changes(faulty, trajectory):
    """U4: the arm follows as if there were no injector."""
    r, faults = faulty
    r.arm(constraints={'a': {'trajectory': 1e-6}, 'b': {'trajectory': 1e-6}})
    goal = send(r, trajectory)
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'
    assert faults.active == {}


def test_drives_that_carry_the_arm_are_known(rig):
    """Controllers of efforts must not carry it once more."""
    hardware = rig().hardware
    hardware.gravity_compensated = frozenset({'a'})
    assert FaultInjector(hardware).gravity_compensated == {'a'}


def test_blocked_joint_breaks_the_path_tolerance(faulty, trajectory):
    """U4: a blocked joint stands still, the other moves on; well again, it follows."""
    r, faults = faulty
    r.arm(constraints={'a': {'trajectory': 0.1}})
    faults.set_fault('a', JointFault(blocked=True))
    goal = send(r, trajectory)
    r.run(0.5)
    assert goal.result.code == -4
    assert r.hardware.state.position[0] == 0.0
    assert r.hardware.state.position[1] > 0.0
    faults.clear()
    goal = send(r, trajectory)
    r.run(1.1)
    assert goal.status.name == 'SUCCEEDED'


def test_bias_breaks_the_goal_tolerance(faulty, trajectory):
    """U4: a biased joint ends beside its goal."""
    r, faults = faulty
    r.arm(constraints={'a': {'goal': 0.01}, 'goal_time': 0.1})
    faults.set_fault('a', JointFault(bias=0.05))
    goal = send(r, trajectory)
    r.run(1.05)
    assert r.hardware.state.position[0] == pytest.approx(0.55)
    r.run(0.15)
    assert goal.result.code == -5


def test_lag_follows_late(faulty, trajectory):
    """U4: a lagging joint is behind on the way and arrives in the end."""
    r, faults = faulty
    r.arm()
    faults.set_fault('a', JointFault(lag=0.2))
    send(r, trajectory)
    r.run(0.5)
    assert 0.02 < 0.25 - r.hardware.state.position[0] < 0.2
    r.run(3.0)
    np.testing.assert_allclose(r.hardware.state.position, [0.5, 0.2], atol=1e-4)


def test_faults_are_told(faulty):
    """The active faults can be read, in words."""
    _, faults = faulty
    faults.set_fault('a', JointFault(lag=0.2, blocked=True))
    assert {k: str(v) for k, v in faults.active.items()} == {'a': 'lag 0.2 s, blocked'}
    faults.set_fault('a', JointFault())
    assert faults.active == {}


def test_an_unknown_joint_is_refused(faulty):
    """The error names the joint and those that are known."""
    with pytest.raises(ControllerError, match=r"'c'.*a, b"):
        faulty[1].set_fault('c', JointFault(blocked=True))


@pytest.mark.parametrize(('name', 'value'), [('lag', -1.0), ('lag', math.inf), ('bias', math.nan)])
def test_bad_numbers_are_refused(name, value):
    """A lag below 0, and numbers that are none."""
    with pytest.raises(ValidationError, match=name):
        JointFault(**{name: value})


def test_what_the_hardware_forgets_is_forgotten(hardware_class):
    """A command that the hardware drops at a switch is not written to it again."""
    class Forgetful(hardware_class):
        def perform_command_mode_switch(self, claimed):
            self.command.velocity[:] = np.nan

    hardware = Forgetful()
    faults = FaultInjector(hardware)
    faults.command.velocity[:] = 1.0
    faults.write(0.01)
    assert (hardware.command.velocity == 1.0).all()
    faults.perform_command_mode_switch({})
    faults.write(0.01)
    assert np.isnan(hardware.command.velocity).all()


def test_updates_at_rest_are_made_while_a_joint_fails(faulty):
    """A fault changes commands though no controller does; well again, updates are left out."""
    r, faults = faulty
    r.arm()
    group = FaultyControllers([r.manager], faults)
    planned = lambda: group.plan(5, r.now_ns, 0.01, moving=False)  # noqa: E731
    assert planned() == 5
    faults.set_fault('a', JointFault(bias=0.1))
    assert planned() == 0
    faults.clear()
    assert planned() == 0
    group.update(r.now_ns, 0.01)
    assert planned() == 5
