# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which trajectories run at once, which wait, which are refused; of a cell of two arms."""

from types import SimpleNamespace

import numpy as np
import pytest

from armsim_ros.errors import MoveItErrorCode
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.nodes.move_group.execution import controller_managers, trajectory_execution
from armsim_ros.nodes.move_group.execution.execution import ExecutionOutcome, ExecutionWatch
from armsim_ros.nodes.move_group.execution.trajectory_execution import TrajectoryExecutionManager
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.trajectory import JointTrajectory, TrajectoryPoint

START = (0.0, 0.0, 0.0, 0.0, 0.0)
INWARD = {'left': (-1.4, 0.8, 0.0, 0.0, 0.0), 'right': (1.4, 0.8, 0.0, 0.0, 0.0)}
OUTWARD = {'left': (0.5, -0.4, 0.0, 0.0, 0.0), 'right': (-0.5, -0.4, 0.0, 0.0, 0.0)}


class Pulse:
    """What a coroutine awaits; it goes on when it is asked the next time."""

    def __await__(self):
        yield


class Execution:
    """An execution that lasts until a test ends it."""

    made = ()

    def __init__(self, context, handles, watch):
        self.stopped = self.over = self.began = self.replaced = False

    def stop(self):
        self.stopped = True

    def replace(self):
        self.replaced = True

    async def run(self, trajectory, names, multi_dof, *, start_checked):
        self.began = True
        Execution.made = (*Execution.made, self)
        while not (self.stopped or self.over or self.replaced):
            await Pulse()
        code = MoveItErrorCode.PREEMPTED if not self.over else MoveItErrorCode.SUCCESS
        return ExecutionOutcome(code)


class Job:
    """A coroutine, run step by step."""

    def __init__(self, coroutine):
        self.coroutine, self.outcome = coroutine, None
        self.step()

    def step(self, count=3):
        """Go on a few times; keep the outcome where it ends."""
        for _ in range(count):
            if self.outcome is None:
                try:
                    self.coroutine.send(None)
                except StopIteration as end:
                    self.outcome = end.value


@pytest.fixture(scope='module')
def cell():
    """Return a cell of two arms."""
    return load_cell('two_bots')


@pytest.fixture(scope='module')
def kinematics(cell):
    """Return its kinematics."""
    return KinematicModel(cell.model)


@pytest.fixture
def execution(cell, kinematics, monkeypatch):
    """Return the queue of a move_group whose controllers are not there."""
    monkeypatch.setattr(trajectory_execution, 'Execution', Execution)
    monkeypatch.setattr(
        controller_managers, 'ControllerHandle', lambda node, settings, wake: None)
    monkeypatch.setattr(Execution, 'made', ())

    async def now(work):
        return work()

    return TrajectoryExecutionManager(SimpleNamespace(
        node=None, settings=cell.settings, robot=cell.model, scene=PlanningScene(kinematics),
        ticker=SimpleNamespace(wake=lambda: None, next=Pulse),
        states=SimpleNamespace(now_ns=lambda: 0, positions={
            f'{arm}_joint{number}': 0.0 for arm in ('left', 'right') for number in range(1, 6)}),
        execution_settings=cell.settings.trajectory_execution,
        queries=SimpleNamespace(submit=now),
    ))


def motion(arm, *ways):
    """Return a motion of one arm."""
    return JointTrajectory(
        tuple(f'{arm}_joint{number}' for number in range(1, 6)),
        np.arange(float(len(ways))), np.array(ways),
    )


def test_two_arms_at_once(execution):
    """Motions on different controllers run at once."""
    jobs = [Job(execution.queued(motion(arm, START, OUTWARD[arm]), ExecutionWatch()))
            for arm in ('left', 'right')]
    assert len(Execution.made) == 2
    for made, job in zip(Execution.made, jobs, strict=True):
        made.over = True
        job.step()
        assert job.outcome.success
    assert not execution.busy


def test_one_arm_waits_for_itself(execution):
    """Motions on the same controller follow one another; another arm's pass by."""
    first = Job(execution.queued(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    second = Job(execution.queued(motion('left', OUTWARD['left'], START), ExecutionWatch()))
    other = Job(execution.queued(motion('right', START, OUTWARD['right']), ExecutionWatch()))
    assert len(Execution.made) == 2
    Execution.made[0].over = True
    first.step()
    second.step()
    assert first.outcome.success
    assert len(Execution.made) == 3
    assert other.outcome is None


def test_newer_motion_takes_over(execution):
    """One that begins where the robot is replaces what its controller runs, and only that."""
    other = Job(execution.queued(motion('right', START, OUTWARD['right']), ExecutionWatch()))
    first = Job(execution.queued(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    newer = Job(execution.queued(motion('left', START, INWARD['left']), ExecutionWatch()))
    first.step()
    assert first.outcome.code == MoveItErrorCode.PREEMPTED
    assert (newer.outcome, other.outcome) == (None, None)
    Execution.made[-1].over = True
    newer.step()
    assert newer.outcome.success


def test_motion_from_elsewhere_does_not_take_over(execution):
    """One that begins neither where the robot is nor where the motion ends stops nothing."""
    first = Job(execution.queued(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    stray = Job(execution.queued(motion('left', INWARD['left'], START), ExecutionWatch()))
    first.step()
    assert (first.outcome, stray.outcome) == (None, None)
    assert len(Execution.made) == 1


def test_same_controller_now_is_refused(execution):
    """A motion that cannot wait is refused while its controller is busy."""
    first = Job(execution.run(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    late = Job(execution.run(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    assert late.outcome.code == MoveItErrorCode.CONTROL_FAILED
    assert first.outcome is None


def test_arms_that_would_meet(execution):
    """The second is refused with the names of the links that would touch."""
    first = Job(execution.run(motion('left', START, INWARD['left']), ExecutionWatch()))
    second = Job(execution.run(motion('right', START, INWARD['right']), ExecutionWatch()))
    assert second.outcome.code == MoveItErrorCode.CONTROL_FAILED
    assert "'left_" in second.outcome.message
    assert "'right_" in second.outcome.message
    assert first.outcome is None


@pytest.mark.parametrize('arm', ['left', 'right'])
def test_what_cannot_be_run_is_told_at_once(execution, arm):
    """Points that do not fit their joints wait for nobody, stop nobody, and meet nobody."""
    first = Job(execution.queued(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    whole = motion(arm, START, OUTWARD[arm])
    short = [TrajectoryPoint(row[:-1]) for row in whole.positions]
    unfit = JointTrajectory.of_points(whole.joint_names, whole.times, short)
    Job(execution.queued(unfit, ExecutionWatch()))
    assert len(Execution.made) == 2
    assert (first.outcome, Execution.made[0].replaced) == (None, False)


def test_stop_ends_all(execution):
    """The word "stop" ends every motion and every wait."""
    jobs = [Job(execution.queued(motion(arm, START, OUTWARD[arm]), ExecutionWatch()))
            for arm in ('left', 'right', 'left')]
    assert execution.stop()
    for job in jobs:
        job.step()
        assert job.outcome.code == MoveItErrorCode.PREEMPTED


def test_a_start_that_is_not_checked_takes_nothing_over(execution):
    """
    Without a start tolerance, too, only a motion from where the robot is replaces another.

    Upstream: execute_trajectory_action_capability.cpp runs goals one after the other.
    """
    context = execution._context
    context.execution_settings = context.execution_settings.model_copy(update={
        'allowed_start_tolerance': 0.0, 'allowed_start_tolerance_joints': {'left_joint1': 0.0}})
    first = Job(execution.queued(motion('left', START, OUTWARD['left']), ExecutionWatch()))
    stray = Job(execution.queued(motion('left', INWARD['left'], START), ExecutionWatch()))
    first.step()
    assert (first.outcome, stray.outcome) == (None, None)
    assert len(Execution.made) == 1
