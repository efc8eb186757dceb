# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Latencies of the trajectory action through DDS, beside an empty rclpy server in the same run.

Goals go to the two in turn, from one client. Ours hold the arm where it is for a while; the time
that the trajectory lasts is taken off its result's latency.
"""

from __future__ import annotations

from dataclasses import dataclass, field
import time
from typing import Any

from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.task import Future
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.clients.trajectory import trajectory_message
from benchmarks.controllers.empty_action_server import ACTION
from benchmarks.options import Options
from benchmarks.stack import arm_of, median, peer, percentile, running_stack

#: Time that a trajectory lasts [s].
DURATION = 0.1
PHASES = ('accepted', 'first feedback', 'result')


@dataclass
class Latencies:
    """Time from the sending of a goal to what came back [s], one entry a goal."""

    accepted: list[float] = field(default_factory=list)
    first_feedback: list[float] = field(default_factory=list)
    result: list[float] = field(default_factory=list)


class Stopwatch:
    """
    Sends goals to one action server and notes when what comes back.

    Everything happens in the executor's thread of the node.

    :param duration: time that a goal lasts by itself [s].
    """

    def __init__(self, client: ClientNode, action: str, duration: float) -> None:
        self.latencies = Latencies()
        self._client = client
        self._duration = duration
        self._action = ActionClient(client.node, FollowJointTrajectory, action)
        assert self._action.wait_for_server(10.0), f'no action server {action}'

    def run(self, goal: FollowJointTrajectory.Goal) -> None:
        """Send a goal, wait for its end."""
        self._ended = Future()
        self._fed_back = False
        self._client.in_executor(lambda: self._send(goal))
        self._client.result(self._ended, 20.0, 'result')

    def _send(self, goal: FollowJointTrajectory.Goal) -> None:
        self._began = time.monotonic()
        future = self._action.send_goal_async(goal, feedback_callback=self._feedback)
        future.add_done_callback(self._answer)

    def _answer(self, future: Future) -> None:
        self.latencies.accepted.append(time.monotonic() - self._began)
        handle: Any = future.result()
        assert handle.accepted, 'the goal was rejected'
        handle.get_result_async().add_done_callback(self._result)

    def _feedback(self, _message: object) -> None:
        if not self._fed_back:
            self._fed_back = True
            self.latencies.first_feedback.append(time.monotonic() - self._began)

    def _result(self, _future: Future) -> None:
        self.latencies.result.append(time.monotonic() - self._began - self._duration)
        self._ended.set_result(None)


def main(options: Options) -> None:
    """Print a table of both servers."""
    with running_stack(f'robot:={options.robot}') as stack, peer(
        'controllers.empty_action_server', domain=stack.domain):
        controller, joints = arm_of(options.robot)
        state = stack.client.collect(
            f'{controller.rpartition("/")[0]}/joint_states', JointState).wait(1)[-1]
        here = dict(zip(state.name, state.position, strict=True))
        goal = FollowJointTrajectory.Goal(
            trajectory=trajectory_message(joints, [(DURATION, [here[name] for name in joints])]))
        watches = {
            'ours': (Stopwatch(
                stack.client, f'{controller}/follow_joint_trajectory', DURATION), goal),
            'empty rclpy server': (
                Stopwatch(stack.client, ACTION, 0.0), FollowJointTrajectory.Goal()),
        }
        for _ in range(options.goals):
            for watch, message in watches.values():
                watch.run(message)
    print(f'latency in ms, {options.goals} goals each' + ' ' * 15 + 'p50      p99')
    for phase in PHASES:
        for name, (watch, _) in watches.items():
            values = getattr(watch.latencies, phase.replace(' ', '_'))
            print(f'{phase:<16}{name:<22}{median(values) * 1e3:9.2f}'
                  f'{percentile(values, 0.99) * 1e3:9.2f}')
