# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Updates that are planned: what follows equals single steps, at any pace."""

import threading
from types import SimpleNamespace

from invented_time import invented_pacer
import numpy as np
import pytest

from armsim_ros.control.mailbox import GoalStatus
from armsim_ros.control.trajectory.tolerances import JointTolerance
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.stack import ArmSim
from armsim_ros.testing.stacks import built_cell
from armsim_ros.trajectory import JointTrajectory

STATES = 'joint_state_broadcaster/JointStateBroadcaster'
TRAJECTORY = 'joint_trajectory_controller/JointTrajectoryController'
#: Time between two calls of a listener [ns].
LISTENER_NS = 10_000_000
MOTION = JointTrajectory(
    tuple(f'joint_{i}' for i in range(1, 7)), np.array([0.3, 0.6]),
    np.array([[0.1] * 6, [0.3] * 6]), np.array([[0.5] * 6, [0.0] * 6]),
)


class PacedArm:
    """An arm whose loop keeps the pace of an invented wall clock."""

    def __init__(self, rate=1000):
        self.sim = ArmSim(built_cell('sunday', None, {'controller_manager.update_rate': rate}))
        self.pacer, self.clock, self.alarm = invented_pacer()
        self.loop = ControlLoop(
            self.sim.simulation, self.sim.manager, rate, pacer=self.pacer)
        self.sim.step(20)
        self.controller = self.sim.manager.controllers['arm_joint_controller']
        self.begin_ns = self.sim.simulation.time_ns

    def run(self, ticks):
        """Let so many ticks' time pass, with a listener."""
        stop = threading.Event()

        def listen(time_ns):
            if time_ns >= self.begin_ns + ticks * 1_000_000:
                stop.set()

        self.loop.every(LISTENER_NS, listen)
        self.loop.run(stop)


@pytest.fixture(params=[1000, 250, 100])
def arm(request):
    """Return an arm with controllers at some rate."""
    return PacedArm(request.param)


def outcome(sim, goal):
    """Return all that a motion leaves behind."""
    return goal.status, goal.result, sim.time, sim.digest()


def test_a_paced_motion_equals_single_steps_and_takes_few_naps(arm):
    """How the wall clock's time is slept through changes no bit, within path tolerances too."""
    tolerances = [JointTolerance('joint_2', position=0.1)]
    goal = arm.controller.send_goal(MOTION, tolerances).goal
    arm.run(1000)
    single = PacedArm(arm.sim.settings.controller_manager.update_rate)
    expected = single.controller.send_goal(MOTION, tolerances).goal
    while single.sim.time < arm.sim.time:
        single.sim.step()
    assert goal.status is GoalStatus.SUCCEEDED
    assert outcome(arm.sim, goal) == outcome(single.sim, expected)
    assert arm.clock.naps < 300


def test_who_asks_in_the_middle_of_a_motion_is_answered_at_the_next_tick(arm):
    """Nothing is done before its time, and the motion goes on as if nobody had asked."""
    goal = arm.controller.send_goal(MOTION).goal
    simulation, served = arm.sim.simulation, []

    def ask_in_a_while():
        if len(served) < 20:
            asked = arm.clock.now + 1_400_000
            arm.loop.call(lambda: served.append(
                (arm.clock.now - asked, simulation.time_ns - arm.begin_ns - arm.clock.now)))
            arm.alarm.at = asked

    # What ends a nap lies in the mailbox when it begins: the loop does not look there meanwhile.
    arm.alarm.on_nap = ask_in_a_while
    arm.run(1000)
    single = PacedArm(arm.sim.settings.controller_manager.update_rate)
    expected = single.controller.send_goal(MOTION).goal
    single.sim.run_until(arm.sim.time)
    assert len(served) == 20
    assert all(0 <= late <= 1_000_000 for late, _ in served)
    assert all(-1_000_000 <= ahead <= 0 for _, ahead in served)
    assert outcome(arm.sim, goal) == outcome(single.sim, expected)


def test_states_are_read_when_their_time_has_come_while_the_arm_moves():
    """A sample waits for no tick that comes after it."""
    arm, late = PacedArm(), []
    broadcaster = arm.sim.manager.controllers['joint_state_controller']
    arm.controller.send_goal(MOTION)
    while broadcaster.poll() is not None:
        pass
    broadcaster.listen(
        lambda: late.append(arm.clock.now - (broadcaster.poll().time_ns - arm.begin_ns)))
    arm.run(500)
    assert len(late) >= 24
    assert set(late[1:]) == {0}


def test_a_path_tolerance_ends_a_paced_goal_at_its_tick():
    """A joint that is pushed away aborts the goal, and is seen, as with single steps."""
    ends, samples = [], ([], [])
    for paced in (True, False):
        arm = PacedArm()
        states = arm.sim.manager.controllers['joint_state_controller']
        while states.poll() is not None:
            pass
        states.listen(lambda poll=states.poll, found=samples[paced]: found.append(poll()))
        goal = arm.controller.send_goal(
            MOTION, [JointTolerance('joint_2', position=0.001)]).goal
        arm.sim.simulation.apply_wrench('link_3', force=(60.0, 0.0, 60.0))
        if paced:
            arm.run(400)
        else:
            arm.sim.run_until(ends[0][2])
        ends.append(outcome(arm.sim, goal))
    assert ends[0][0] is GoalStatus.ABORTED
    assert ends[0] == ends[1]
    single, paced = (
        [(one.time_ns, one.values.tobytes()) for one in found] for found in samples)
    assert single == paced
    assert len(single) > 5


def test_a_fault_in_a_planned_motion_is_told_as_in_single_steps():
    """What becomes unstable on the way is found at the step where it happens."""
    told = []
    for count in (1, 3, 500):
        arm = PacedArm()
        arm.controller.send_goal(MOTION)
        arm.sim.step(200)
        simulation = arm.sim.simulation
        simulation.apply_wrench('link_6', force=(4e5, 0.0, 0.0))
        while not simulation.clock.paused:
            arm.loop.advance(count)
        told.append((arm.loop.poll_faults(), arm.sim.time, arm.sim.digest()))
    assert 'unstable' in told[0][0][0]
    assert told[0] == told[1] == told[2]


@pytest.mark.parametrize('rate', [1000, 200])
def test_batched_updates_equal_single_ones_with_controllers_of_any_rate(rate):
    """A batch ends at the next update of a controller that waits; each sample has its time."""
    def part(joints, slower=1.0, stamp_ns=0):
        columns = [MOTION.joint_names.index(joint) for joint in joints]
        return JointTrajectory(joints, slower * MOTION.times, MOTION.positions[:, columns],
                               MOTION.velocities[:, columns] / slower, stamp_ns=stamp_ns)

    front, back = MOTION.joint_names[:4], MOTION.joint_names[4:]
    outcomes = []
    for batched in (True, False):
        sim = ArmSim(built_cell('sunday', None, {'controller_manager.update_rate': rate}))
        sim.manager.switch(deactivate=['arm_joint_controller'])
        made = {}
        for name, kind, parameters in (
            ('slow', STATES, {'update_rate': rate // 8}),
            ('odd', STATES, {'publish_rate': 30.0}),
            ('both', STATES, {'update_rate': rate // 5, 'publish_rate': 30.0}),
            ('front', TRAJECTORY, {'joints': list(front)}),
            ('back', TRAJECTORY, {'joints': list(back), 'constraints': {
                'goal_time': 0.0423, **{joint: {'goal': 1e-6} for joint in back}}}),
        ):
            made[name] = sim.manager.load(
                SimpleNamespace(name=name, type=kind, parameters=parameters))
            sim.manager.configure(name)
            assert sim.manager.switch(activate=[name]).ok
        times = {name: [] for name in ('slow', 'odd', 'both')}
        for name, found in times.items():
            made[name].listen(
                lambda found=found, poll=made[name].poll: found.append(poll().time_ns))
        sim.simulation.apply_wrench('link_6', force=(0.0, 5.0, 20.0))
        goal = made['front'].send_goal(part(front, slower=1.5)).goal
        made['back'].set_trajectory(part(back, stamp_ns=37_000_000))
        for _ in range(1 if batched else 1000):
            sim.step(1000 if batched else 1)
        events = [(event.time_ns, event.text) for event in sim.manager.poll_events()]
        assert any('goal_time_tolerance exceeded' in text for _, text in events)
        assert min(map(len, times.values())) >= 25
        outcomes.append((outcome(sim, goal), times, events))
    assert outcomes[0] == outcomes[1]


@pytest.mark.parametrize('moving', [False, True])
@pytest.mark.parametrize('rate', [1000, 100])
def test_a_goal_sent_while_states_are_read_starts_at_the_next_update(rate, moving):
    """Planned updates end where a listener of states asks for a motion."""
    sim, sent = ArmSim(built_cell('sunday', None, {'controller_manager.update_rate': rate})), []
    sim.step(20)
    controller = sim.manager.controllers['arm_joint_controller']
    if moving:
        controller.send_goal(MOTION)

    def send():
        if sim.time > 0.1 and not sent:
            sent.append(sim.time)
            controller.send_goal(MOTION)

    sim.manager.controllers['joint_state_controller'].listen(send)
    sim.step(400)
    last_update = sim.time - 1.0 / rate
    begun = last_update - controller.snapshot().desired_time_from_start
    assert begun == pytest.approx(sent[0] + 1.0 / rate)


def test_a_robot_at_rest_is_not_updated_because_another_moves(monkeypatch):
    """The updates of both are planned, and the motion equals one in single steps."""
    outcomes = []
    for steps in (1, 700):
        sim, updates = ArmSim('two_bots'), []
        sim.step(20)
        at_rest, moving = sim.managers.values()
        controller = next(iter(
            found for found in moving.controllers.values() if hasattr(found, 'send_goal')))
        joints = controller.joints
        start = np.array([sim.joint_positions[joint] for joint in joints])
        goal = controller.send_goal(JointTrajectory(
            joints, np.array([0.3, 0.6]), start + np.array([[0.1], [0.2]]),
            np.array([[0.4], [0.0]]) * np.ones(len(joints)))).goal
        monkeypatch.setattr(
            at_rest, 'update',
            lambda *time, made=at_rest.update, updates=updates: updates.append(made(*time)))
        for _ in range(700 // steps):
            sim.step(steps)
        outcomes.append(outcome(sim, goal))
    assert goal.status is GoalStatus.SUCCEEDED
    assert outcomes[0] == outcomes[1]
    assert len(updates) < 100


@pytest.mark.parametrize('rate', [500, 250])
@pytest.mark.parametrize('first', range(200, 206))
def test_a_dwell_in_a_motion_equals_single_steps(rate, first):
    """The drives come to rest in the same update, wherever planned updates end before it."""
    positions = np.array([[0.1] * 6, [0.1] * 6, [0.2] * 6])
    dwell = JointTrajectory(
        MOTION.joint_names, np.array([0.2, 0.5, 0.7]), positions, np.zeros((3, 6)))
    outcomes = []
    for requests in ([first, 60], [1] * (first + 60)):
        sim = ArmSim(built_cell('sunday', None, {'controller_manager.update_rate': rate}))
        sim.step(20)
        goal = sim.manager.controllers['arm_joint_controller'].send_goal(dwell).goal
        for steps in requests:
            sim.step(steps)
        outcomes.append(outcome(sim, goal))
    assert outcomes[0] == outcomes[1]


def test_a_restart_without_states_equals_single_steps():
    """The robot is held where it is then, by the first update."""
    outcomes = []
    for steps in (1, 50):
        sim = ArmSim(built_cell('sunday', None, {}))
        sim.step(20)
        sim.simulation.apply_wrench('link_6', force=(20.0, 0.0, 0.0))
        sim.step(50)
        sim.loop.restart('again', states=False)
        for _ in range(50 // steps):
            sim.step(steps)
        outcomes.append(sim.digest())
    assert outcomes[0] == outcomes[1]


def test_a_goal_ends_at_the_same_update_however_steps_are_requested():
    """Batched updates end before the last waypoint."""
    ends = []
    for steps in (1, 700):
        sim = ArmSim(built_cell('sunday', None, {}))
        sim.step(20)
        goal = sim.manager.controllers['arm_joint_controller'].send_goal(MOTION).goal
        goal.add_done_callback(lambda _, sim=sim: ends.append(sim.time))
        for _ in range(700 // steps):
            sim.step(steps)
    assert len(ends) == 2
    assert ends[0] == ends[1]


def test_a_motion_that_begins_as_the_pace_ends_equals_single_steps():
    """What was planned while the arm was at rest is dropped: nothing of it is followed later."""
    arm, sent = PacedArm(), []
    arm.loop.every(4_000_000, lambda time_ns: None)

    def send():
        if not sent and arm.clock.now > 50_000_000:
            sent.extend((arm.sim.time, arm.controller.send_goal(MOTION).goal))
            arm.sim.simulation.clock.real_time_factor = 0.0
            arm.alarm.at = arm.clock.now + 1_400_000

    arm.alarm.on_nap = send
    arm.run(1000)
    single = PacedArm()
    single.sim.run_until(sent[0])
    expected = single.controller.send_goal(MOTION).goal
    single.sim.run_until(arm.sim.time)
    assert outcome(arm.sim, sent[1]) == outcome(single.sim, expected)
