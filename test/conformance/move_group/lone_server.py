# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""move_group in a domain of its own, where the test plays joint states and controllers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
import math
import re
import threading
from types import TracebackType
from typing import Any

from control_msgs.action import FollowJointTrajectory, GripperCommand
from move_group_bench import ArmBench
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.task import Future
from sensor_msgs.msg import JointState

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain, Program, start_program

READY = re.escape('You can start planning now!')
RATE = 0.02


class LoneServer:
    """
    A started move_group.

    :param words: its command line.
    :param wait: whether to wait for the ready line.
    :param namespace: of the node.
    """

    def __init__(self, *words: str, wait: bool = True, namespace: str = '') -> None:
        if namespace:
            words = (*words, '--ros-args', '-r', f'__ns:={namespace}', '--')
        self._namespace = namespace
        self._stack = ExitStack()
        self.domain = self._stack.enter_context(private_domain())
        self.program: Program = self._stack.enter_context(
            start_program('move_group', self.domain, 'use_sim_time:=false', *words)
        )
        self.client = self._stack.enter_context(ClientNode(self.domain, 'player'))
        self._arms: dict[str, ArmBench] = {}
        if wait:
            try:
                self.wait_until_ready()
            except AssertionError:
                self._stack.close()
                raise

    def wait_until_ready(self) -> None:
        """Wait for the ready line."""
        self.program.wait_for_line(READY, 60.0)

    def play(
        self, joints: Mapping[str, float], topic: str = '/sunday/joint_states', **options: Any
    ) -> PlayedArm:
        """Publish joint states from now on, and give the client's view of the arm."""
        played = PlayedArm(self.client, joints, topic, **options)
        if topic not in self._arms:
            self._arms[topic] = ArmBench(self.client, self._namespace, topic)
        played.arm = self._arms[topic]
        return played

    def __enter__(self) -> LoneServer:
        """Return the server."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop it."""
        self._stack.__exit__(kind, error, trace)


class PlayedArm:
    """
    Joint states that a test publishes, and controllers that do what the test says.

    :param joints: joint -> position [rad].
    :param stamped: whether messages carry the time.
    """

    def __init__(
        self, client: ClientNode, joints: Mapping[str, float], topic: str, *,
        stamped: bool = True, qos: Any = 10,
    ) -> None:
        self.client = client
        self.positions = dict(joints)
        self.velocities: dict[str, float] = {}
        self.shaking: dict[str, float] = {}
        self._swing = 0.0
        self.arm: Any = None
        self.shift = 0.0
        self._stamped = stamped
        node = client.node
        self._publisher = node.create_publisher(JointState, topic, qos)
        self._timer = node.create_timer(
            RATE, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def publish(self) -> None:
        """
        Publish the positions once.

        A shaking joint swings by an angle [rad]. Whichever messages a receiver misses, those that
        it gets differ.
        """
        shaking = self.shaking  # another thread may replace it
        self._swing += 1.0
        message = JointState(
            name=list(self.positions),
            position=[float(position) + shaking.get(name, 0.0) * math.sin(self._swing)
                      for name, position in self.positions.items()])
        if self.velocities:
            message.velocity = [self.velocities.get(name, 0.0) for name in message.name]
        if self._stamped:
            now = self.client.node.get_clock().now().nanoseconds + int(self.shift * 1e9)
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        self._publisher.publish(message)

    def silence(self) -> None:
        """Publish no more."""
        self.client.in_executor(self._timer.cancel)

    def resume(self) -> None:
        """Publish again."""
        self._timer.reset()

    def controller(self, action: str, kind: Any = FollowJointTrajectory) -> PlayedController:
        """Offer a controller's action."""
        return PlayedController(self, action, kind)


class PlayedController:
    """
    An action server whose goals end as the test says.

    ``behaviour`` is 'arrive' (at once, the arm jumps to the end), 'late' (the arm too, the result
    only after ``release``), 'hold' (until cancelled), 'give up' (it cancels the goal itself),
    'stall' (a gripper that succeeds though it has not arrived), 'reject', 'abort' or 'mute' (the
    goal is only answered after ``release``, and accepted then).
    """

    def __init__(self, player: PlayedArm, action: str, kind: Any) -> None:
        self.behaviour = 'arrive'
        self.error_string = 'the elbow is tired'
        self.goals: list[Any] = []
        self.cancelled = threading.Event()
        self._player = player
        self._kind = kind
        self._running: list[Future] = []
        self._server = player.client.in_executor(lambda: ActionServer(
            player.client.node, kind, action, self._execute,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=self._accept, cancel_callback=self._cancel,
        ))

    async def _accept(self, goal: Any) -> GoalResponse:
        self.goals.append(goal)
        if self.behaviour == 'mute':
            future = Future()
            self._running.append(future)
            await future
        return GoalResponse.REJECT if self.behaviour == 'reject' else GoalResponse.ACCEPT

    def _cancel(self, _goal: Any) -> CancelResponse:
        self.cancelled.set()
        self._release()
        return CancelResponse.ACCEPT

    async def _execute(self, handle: Any) -> Any:
        result = self._kind.Result()
        ways: dict[str, Callable[[Any, Any], None]] = {
            'arrive': self._arrive, 'abort': self._abort, 'stall': self._stall,
        }
        if self.behaviour == 'late':
            self._move(handle)
            future = Future()
            self._running.append(future)
            await future
            handle.succeed()
        elif self.behaviour in ('hold', 'mute', 'give up'):
            if not handle.is_cancel_requested:
                future = Future()
                self._running.append(future)
                await future
            if not handle.is_cancel_requested:
                handle._update_state(rclpy_implementation.GoalEvent.CANCEL_GOAL)
            handle.canceled()
        else:
            ways[self.behaviour](handle, result)
        return result

    def _arrive(self, handle: Any, result: Any) -> None:
        if self._kind is GripperCommand:
            result.reached_goal = True
        else:
            self._move(handle)
        handle.succeed()

    def _stall(self, handle: Any, result: Any) -> None:
        result.stalled, result.reached_goal = True, False
        handle.succeed()

    def _move(self, handle: Any) -> None:
        """Put the arm where the trajectory ends."""
        trajectory = handle.request.trajectory
        end = zip(trajectory.joint_names, trajectory.points[-1].positions, strict=True)
        self._player.positions.update(end)

    def waits(self) -> bool:
        """Return whether a goal waits for its end."""
        return bool(self._running)

    def release(self) -> None:
        """Let goals that wait end."""
        self._player.client.in_executor(self._release)

    def _release(self) -> None:
        for future in self._running:
            future.set_result(None)
        self._running = []

    def _abort(self, handle: Any, result: Any) -> None:
        if self._kind is FollowJointTrajectory:
            result.error_code, result.error_string = -4, self.error_string
        handle.abort()
