# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Clients in other threads while the control loop runs."""

import threading

import numpy as np

from armsim_ros.control.trajectory.goal import superseded


def test_goals_and_readers_from_many_threads(rig, trajectory):
    """I3, I4, I11: every goal ends exactly once; a snapshot never mixes two updates."""
    r = rig()
    arm = r.arm()
    stop = threading.Event()
    goals, ends, torn = [], [], []

    def client(number):
        while not stop.is_set():
            target = 0.1 * (number + 1)
            goal = arm.send_goal(trajectory((0.2, [target, -target], [0, 0]))).goal
            goals.append(goal)
            goal.add_done_callback(ends.append)
            if number == 1:
                arm.cancel(goal)

    def reader():
        while not stop.is_set():
            s = arm.snapshot()
            if not np.array_equal(s.error.positions, s.reference.positions - s.feedback.positions):
                torn.append(s)
            arm.query_state(r.now_ns)

    threads = [threading.Thread(target=client, args=(n,)) for n in range(3)]
    threads.append(threading.Thread(target=reader))
    for thread in threads:
        thread.start()
    while len(goals) < 200:
        r.step()
    stop.set()
    for thread in threads:
        thread.join()
    r.run(1.0)
    assert torn == []
    assert sorted(map(id, ends)) == sorted(map(id, goals))
    assert all(goal.done for goal in goals)
    assert arm.active_goal is None


def test_burst_is_spread_over_updates(rig, trajectory):
    """I4, I10: of 500 goals at once the last wins; none of the others moves the arm."""
    r = rig()
    arm = r.arm()
    goals = [
        arm.send_goal(trajectory((0.5, [0.1 * (-1) ** n, 0.0], [0, 0]))).goal for n in range(499)
    ]
    goals.append(arm.send_goal(trajectory((0.5, [0.0, 0.3], [0, 0]))).goal)
    r.step()
    assert not goals[-1].done
    assert goals[0].status.name == 'ABORTED'
    r.run(1.0)
    assert [goal.status.name for goal in goals] == ['ABORTED'] * 499 + ['SUCCEEDED']
    np.testing.assert_allclose(r.hardware.state.position, [0.0, 0.3])


def test_topic_after_goals_keeps_the_last_goal(rig, trajectory):
    """I8: a topic trajectory in the same update is what the last goal is judged on."""
    r = rig()
    arm = r.arm()
    first = arm.send_goal(trajectory((0.5, [0.1, 0.0]))).goal
    second = arm.send_goal(trajectory((0.5, [0.2, 0.0]))).goal
    arm.set_trajectory(trajectory((0.5, [0.3, 0.0])))
    arm.set_trajectory(trajectory((0.5, [0.4, 0.0])))
    r.run(0.6)
    assert (first.status.name, second.status.name) == ('ABORTED', 'SUCCEEDED')
    assert r.hardware.state.position[0] == 0.4


def test_future_trajectories_supersede_nothing(rig, trajectory):
    """E4: what waits for its stamp does not stand for what starts now."""
    assert superseded([], 0) == {}
    r = rig()
    arm = r.arm()
    arm.send_goal(trajectory((0.2, [0.2, 0.0])))
    arm.send_goal(trajectory((0.5, [0.0, 0.0]), stamp_ns=r.now_ns + 300_000_000))
    r.run(0.25)
    assert r.hardware.state.position[0] == 0.2
