# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A whole stack in processes of its own, and a client of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, nullcontext
import re
from typing import Any

from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode, Collector
from armsim_ros.clients.controller_manager import ParameterClient
from armsim_ros.clients.move_group import MoveGroupClient
from armsim_ros.clients.trajectory import Outcome, trajectory_message, TrajectoryClient
from armsim_ros.testing.program import private_domain, Program, start_program

#: A joint that is slower has come to rest [rad/s or m/s].
AT_REST = 0.001
READY = 'You can start planning now!'


class RobotUser:
    """
    What a user of a running robot has: its actions and its joint states.

    :param client: the node to use.
    :param program: the bringup.
    :param namespace: of controllers and joint states, '' or such as ``/sunday``.
    """

    def __init__(self, client: ClientNode, program: Program, namespace: str) -> None:
        self.client, self.program, self.namespace = client, program, namespace
        self.move_group = MoveGroupClient(client)

    def positions(self) -> dict[str, float]:
        """Return the joint positions of a message that comes from now on [rad or m]."""
        with self._joint_states() as states:
            message = states.wait(1)[-1]
        return dict(zip(message.name, message.position, strict=True))

    def distance(self, target: Mapping[str, float]) -> float:
        """Return the largest distance of a joint from its target [rad or m]."""
        now = self.positions()
        return max(abs(now[joint] - value) for joint, value in target.items())

    def fault(self, joint: str, **fault: Any) -> None:
        """
        Make a joint of a stack with fault injection fail.

        :param fault: ``lag`` [s], ``bias`` [rad or m], ``blocked``.
        :raises AssertionError: it is refused; with the reason.
        """
        manager = ParameterClient(self.client, f'{self.namespace}/controller_manager')
        for kind, value in fault.items():
            reason = manager.set(f'faults.{joint}.{kind}', value)
            assert not reason, f"fault {kind} of joint '{joint}': {reason}"

    def wait_until_still(self) -> None:
        """Wait for a message in which no joint moves."""
        with self._joint_states() as states:
            states.wait_for(lambda message: max(map(abs, message.velocity), default=0.0) < AT_REST)

    def send(self, controller: str, joints: Sequence[str],
             points: Sequence[tuple[float, Sequence[float]]], **tolerances: Any) -> Outcome:
        """Send a trajectory to a controller and return how it ended."""
        arm = TrajectoryClient(self.client, f'{self.namespace}/{controller}')
        return arm.send(trajectory_message(joints, points), **tolerances).result()

    def _joint_states(self) -> closing[Collector]:
        """Subscribe for the time of the context: many a robot publishes a thousand a second."""
        return closing(self.client.collect(f'{self.namespace}/joint_states', JointState, 1))


@contextmanager
def running_robot(
    *arguments: str, namespace: str = '', domain: int | None = None
) -> Iterator[RobotUser]:
    """
    Bring a robot up on a private domain for the time of the context.

    :param arguments: of bringup, such as ``robot:=sunday``.
    :param namespace: where the robot's controllers will be.
    :param domain: a domain that the caller has leased.
    """
    with (
        private_domain() if domain is None else nullcontext(domain) as domain,
        start_program('bringup', domain, *arguments) as program,
        user_of(program, domain, namespace) as robot,
    ):
        yield robot


@contextmanager
def user_of(program: Program, domain: int, namespace: str) -> Iterator[RobotUser]:
    """
    Wait until a bringup is ready, and be its user for the time of the context.

    :param namespace: where the robot's controllers are.
    """
    with ClientNode(domain, 'user') as client:
        program.wait_for_line(re.escape(READY), 60.0)
        yield RobotUser(client, program, namespace)
