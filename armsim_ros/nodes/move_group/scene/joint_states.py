# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot state monitor: ``joint_states`` into the planning scene."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
import math

from rclpy.clock import Clock, ClockType
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from rclpy.task import Future
from sensor_msgs.msg import JointState

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.watching import is_overloaded
from armsim_ros.planning.scene.planning_scene import PlanningScene

COMPLAINT_PERIOD_NS = 1_000_000_000
#: The joints of several robots arrive in sequence, within this time [ns].
COMPLETION_NS = 300_000_000
#: How often states are read while a caller waits for a state, and otherwise [s].
WAITING_PERIOD, IDLE_PERIOD = 0.005, 0.25
#: Messages of a topic that are queued in between.
DEPTH = 250
#: How long to wait for the first state [s]: its publisher may just be starting.
FIRST_STATE_TIMEOUT = 5.0
AT_REST = 1e-3
CLOCK_MISMATCH_NS = 10_000_000_000


class StateMonitor:
    """
    Keeps the latest position of every joint.

    Messages that carry only some joints, such as those of a single robot of several, add up: the
    state is as new as the last message, whatever joints it has. Only where time moves in steps it
    is as old as its oldest joint, passive ones aside. A message without a stamp counts with the
    time of its arrival.

    Messages wake no thread: they are read before each callback of the executor, so that what
    looks sees the newest state; a timer sees to it that there is such a callback.

    :param topics: joint state topics; several may be given.
    :param steady: measures waiting times; by default wall time.
    """

    def __init__(
        self, node: PollingNode, scene: PlanningScene, topics: Sequence[str], *,
        steady: Clock | None = None
    ) -> None:
        self._node, self._scene = node, scene
        self.topics = tuple(topics)
        robot = scene.robot
        self._needed = set(robot.active_joints)
        self._known = set(robot.movable_joints)
        self._timed = self._needed - set(robot.semantic.passive_joints)
        self.positions: dict[str, float] = {}
        self.velocities: dict[str, float] = {}
        #: Asks the stepper of time for the current time [ns]; None where time runs by itself.
        self.asks: Callable[[], Awaitable[int]] | None = None
        #: Whether messages about the present state carry velocities too.
        self.monitor_dynamics = False
        #: Called with the time [ns] and all positions after each message.
        self.recorders: list[Callable[[int, Mapping[str, float]], None]] = []
        #: False lets every wait for a state end now, as if its time were over.
        self.patient = True
        #: Messages that have come.
        self.count = 0
        self._stamps: dict[str, int] = {}
        self._newest = 0
        self._first_ns: int | None = None
        self._scene_is_late = False
        self._complained: dict[str, int] = {}
        self._warned: set[str] = set()
        self._waiting: list[tuple[int, int, Future]] = []
        self._subscriptions: list[Subscription] = []
        self.start()
        # Patience is a matter of wall time: simulated time does not advance in a pause, and jumps
        # from 0 to the present when the first message of /clock comes.
        self._steady = steady or Clock(clock_type=ClockType.STEADY_TIME)
        self._idler = node.create_timer(IDLE_PERIOD, lambda: None, clock=self._steady)
        self._sweeper = node.create_timer(WAITING_PERIOD, self._sweep, clock=self._steady)
        self._sweeper.cancel()

    def start(self) -> None:
        """Follow the topics, which the monitor does from the beginning."""
        if not self._subscriptions:
            profile = QoSProfile(
                depth=DEPTH, reliability=qos.COMMAND.reliability,
                durability=qos.COMMAND.durability)
            self._subscriptions = [
                self._node.poll(JointState, topic, self._receive, profile)
                for topic in self.topics]

    def stop(self) -> None:
        """Keep the state as it is; call it from the executor's thread."""
        for subscription in self._subscriptions:
            self._node.destroy_subscription(subscription)
        self._subscriptions = []

    @property
    def missing(self) -> tuple[str, ...]:
        """Joints that no message has contained yet."""
        return tuple(sorted(self._needed - self.positions.keys()))

    @property
    def complete(self) -> bool:
        """Whether every joint has been received."""
        return self._needed <= self.positions.keys()

    @property
    def at_rest(self) -> bool:
        """Whether no joint moves faster than 1e-3 [rad/s or m/s], as far as states have speeds."""
        speeds = self.velocities.values()
        return bool(speeds) and all(abs(value) < AT_REST for value in speeds)

    @property
    def stamp_ns(self) -> int:
        """Stamp of the state [ns], 0 where none has come."""
        return self._newest if self.asks is None else min(self._stamps.values(), default=0)

    def now_ns(self) -> int:
        """Return the node's time [ns]."""
        return int(self._node.get_clock().now().nanoseconds)

    def newer_than(self, time_ns: int, timeout: float) -> Future:
        """
        Return a future: True with a state stamped at that time or later, False after a while.

        :param time_ns: [ns] of the node's clock.
        :param timeout: [s] of wall time.
        """
        future = Future()
        if self.count and self.stamp_ns >= time_ns:
            future.set_result(True)
        else:
            deadline = self._steady.now().nanoseconds + int(timeout * 1e9)
            self._waiting.append((time_ns, deadline, future))
            if self._sweeper.is_canceled():
                self._sweeper.reset()
        return future

    async def current(self, timeout: float = 1.0) -> bool:
        """
        Wait until the scene holds the present state.

        A robot at rest whose last message is younger than 0.1 s need not be waited for.

        :param timeout: [s] of wall time; the first state is waited for longer.
        :returns: False where no such state came; the scene then holds the last state.
        """
        now, at_rest = self.now_ns(), self.at_rest
        if self.asks is not None:
            now, at_rest = await self.asks(), False
            if self.stamp_ns > now:  # time was reset
                self._stamps = dict.fromkeys(self._stamps, -1)
        fresh = self.count and at_rest and abs(now - self.stamp_ns) < 100_000_000
        patience = timeout if self.count else max(timeout, FIRST_STATE_TIMEOUT)
        recent = fresh or await self.newer_than(now, patience)
        self.update_scene()
        return bool(recent)

    def update_scene(self) -> None:
        """Write the latest positions into the scene, if it does not have them yet."""
        if self._scene_is_late:
            self._scene_is_late = False
            self._scene.set_positions(self.positions)

    def _receive(self, message: JointState) -> None:
        names, values = message.name, message.position
        if len(names) != len(values):
            self._complain(f'joint state dropped: {len(names)} names and {len(values)} positions')
            return
        moving = len(message.velocity) == len(names)
        stamp = self._stamp(message)
        for index, (name, value) in enumerate(zip(names, values, strict=False)):
            if name not in self._known:
                continue
            if not math.isfinite(value):
                self._complain(f"joint state: position of '{name}' is {value}; not used")
                continue
            self.positions[name] = value
            self._scene_is_late = True
            if name in self._timed:
                self._stamps[name] = stamp
            if moving and math.isfinite(message.velocity[index]):
                self.velocities[name] = message.velocity[index]
        self.count += 1
        self._newest = stamp
        for record in self.recorders:
            record(stamp, self.positions)
        if self._first_ns is None:
            self._first_ns = stamp
        if abs(stamp - self._first_ns) > COMPLETION_NS and not self.complete:
            self._complain(
                f"joint states are incomplete: no position of {', '.join(self.missing)} on "
                f"{', '.join(self.topics)}")
        self._notify()

    def _stamp(self, message: JointState) -> int:
        """Return the time of a message [ns]."""
        stamp = ns_from_time(message.header.stamp)
        now = self.now_ns()
        if self.asks is not None:
            return stamp
        if stamp == 0:
            self._warn_once(
                'stamp', 'joint states have no stamp; the time of their arrival is used')
            stamp = now
        elif now and abs(now - stamp) > CLOCK_MISMATCH_NS:
            # Where a program starves, its messages are old though the clocks agree.
            if not is_overloaded():
                self._warn_once(
                    'clocks',
                    f'joint states are stamped {abs(now - stamp) / 1e9:.0f} s away from the clock '
                    'of this node: one of the two does not use sim time; set use_sim_time on both')
            stamp = now
        return stamp

    def _notify(self) -> None:
        if not self._waiting:
            return
        stamp = self.stamp_ns
        done = [entry for entry in self._waiting if stamp >= entry[0]]
        self._waiting = [entry for entry in self._waiting if stamp < entry[0]]
        for _, _, future in done:
            future.set_result(True)

    def _sweep(self) -> None:
        if not self._waiting:
            self._sweeper.cancel()
            return
        now = self._steady.now().nanoseconds
        late = [entry for entry in self._waiting if now >= entry[1] or not self.patient]
        self._waiting = [entry for entry in self._waiting if entry not in late]
        for _, _, future in late:
            future.set_result(False)

    def _complain(self, text: str) -> None:
        now = self.now_ns()
        if now - self._complained.get(text, -COMPLAINT_PERIOD_NS) >= COMPLAINT_PERIOD_NS:
            self._complained[text] = now
            self._node.get_logger().warning(text)

    def _warn_once(self, key: str, text: str) -> None:
        if key not in self._warned:
            self._warned.add(key)
            self._node.get_logger().warning(text)
