# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The streaming thread: a cycle every period, from what has come in to what goes out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import math
import threading
import time
import traceback

from rclpy.subscription import Subscription

from armsim_ros.config.servo import ServoParameters
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.servo.inputs import CommandTopics, JointPositions, StreamClock
from armsim_ros.nodes.servo.output import ControllerWatch, JointCommands, StatusTopic
from armsim_ros.servo.commands import (
    Command,
    CommandInbox,
    Finding,
    InvalidCommandError,
    NOTHING,
    ServoStatus,
    weightiest,
)
from armsim_ros.servo.stream import Cycle, ServoStream
from armsim_ros.sim.pacer import prioritize_thread

#: Rate of reading the topics while there are subscribers; commands are read in every cycle [Hz].
_LOOKS = 10.0
#: While the arm is streamed to, once in so many cycles: the joints that others move, and what
#: may end the stream in favour of others or is only to be complained about.
_JOINTS_EVERY, _OTHERS_EVERY = 2, 4
#: So many cycles that were missed are made up for; more make the motion slower for a moment.
_MADE_UP = 3.0


@dataclass(eq=False, kw_only=True)
class Streaming:
    """
    Runs cycles in a thread of its own.

    :param ready: called once, when everything is there that the first motion needs.
    """

    node: PollingNode
    clock: StreamClock
    inbox: CommandInbox
    commands: CommandTopics
    states: JointPositions
    controller: ControllerWatch
    stream: ServoStream
    output: JointCommands
    status: StatusTopic
    parameters: ServoParameters
    ready: Callable[[], None]

    def __post_init__(self) -> None:
        """Prepare the thread."""
        self.failure = ''
        self._paused = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name='servo', daemon=True)
        self._is_ready = False
        #: The time that of the newest cycle of the stream [ns].
        self._stream_ns = 0
        self._quiet = 0
        self._changes: list[tuple[ServoParameters, ServoStream]] = []

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for it."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(1.0)

    def pause(self, paused: bool) -> None:
        """Come to rest and stay there, or go on; from any thread."""
        self.inbox.forget()
        self._paused = paused

    def change(self, parameters: ServoParameters, stream: ServoStream) -> None:
        """Work with other parameters from the next cycle on; from any thread."""
        self._changes.append((parameters, stream))

    def _run(self) -> None:
        prioritize_thread(self.parameters.thread_priority)
        self.stream.warm_up(self.states.q, self.parameters)
        period = self.parameters.publish_period
        looks = max(1, round(1.0 / (_LOOKS * period)))
        awaited = self.node.waiter(*self.commands.subscriptions.values())
        due = time.monotonic()
        cycle = 0
        busy = True
        try:
            while not self._stop.is_set():
                if self._rests():
                    # What comes in meanwhile stays with the middleware, which keeps the newest.
                    busy = awaited(1.0 / _LOOKS)
                    if not busy:
                        # Who has a goal is known only while its publisher is still there.
                        self.node.catch_up(self.controller.own, *self.controller.subscriptions)
                        continue
                    due = time.monotonic()
                    cycle = 0
                if cycle % looks == 0 or (busy and self.clock.parted):
                    self._look()
                elif busy:
                    self.node.catch_up(*self._due(cycle))
                    if self.stream.streaming and cycle % _JOINTS_EVERY == 0:
                        self.states.read()
                self._cycle()
                cycle += 1
                due = max(due + period, time.monotonic() - _MADE_UP * period)
                busy = self.stream.streaming or not self.inbox.silent
                if busy:
                    # The cycle that finds a command too old does not wait for its turn.
                    left = math.inf
                    if not self.clock.parted:
                        left = self.inbox.left(self.clock.now_ns())
                    time.sleep(max(0.0, min(due - time.monotonic(), left)))
                elif awaited(due - time.monotonic()):
                    # A command that finds the arm at rest is taken up when it comes.
                    busy = True
                    due = time.monotonic()
                    cycle = 0
        except Exception:  # noqa: BLE001 - whatever it is, the program must report it and end
            if not self._stop.is_set():
                self.failure = traceback.format_exc()

    def _look(self) -> None:
        """Read the states; commands last, as the clock determines what stamps mean."""
        commands = tuple(self.commands.subscriptions.values())
        apart = (*commands, self.controller.state, *self.states.subscriptions)
        self.node.catch_up(*(each for each in self.node.polled if each not in apart))
        self.states.read()
        self.clock.look(self.states.stamp_ns)
        self.node.catch_up(*commands)

    def _due(self, cycle: int) -> Iterator[Subscription]:
        """Yield what to read in a cycle; each topic costs time, also where nothing has come."""
        streaming = self.stream.streaming
        others_due = cycle % _OTHERS_EVERY == 0 or not streaming
        yield self.controller.own
        for kind, subscription in self.commands.subscriptions.items():
            if kind is self.inbox.type or others_due:
                yield subscription
        if streaming and others_due:
            yield from self.controller.subscriptions

    def _rests(self) -> bool:
        """Whether there is nothing to do and no subscriber."""
        return (
            self._is_ready
            and not self.stream.streaming
            and self.inbox.silent
            and not self.status.heard)

    def _cycle(self) -> None:
        if not self._is_ready:
            if self.states.missing:
                self.status.publish(Finding(ServoStatus.INVALID, 'no joint states of '
                                            + ', '.join(self.states.missing)))
                return
            self._is_ready = True
            self.ready()
        now = self.clock.now_ns()
        if self._changes:
            self.parameters, stream = self._changes[-1]
            if self.stream.streaming:
                stream.take_over(self.stream)
            self.stream = stream
            self.inbox.timeout_ns = round(self.parameters.incoming_command_timeout * 1e9)
            self._changes.clear()
        findings = self._findings(now)
        complaint = self.inbox.complaint(now)
        if complaint:
            findings.append(Finding(ServoStatus.INVALID, complaint))
        self.status.publish(weightiest(findings))

    def _findings(self, now: int) -> list[Finding]:
        """Do a cycle and return its status."""
        others = self._others()
        if others is not None:
            self.inbox.forget()
            if self.controller.goal_runs or self.controller.inactive:
                self.stream.stop()
        command = self.inbox.command(now)
        if self._paused:
            self.inbox.forget()
            command = None
        findings = [] if others is None else [others]
        if self._paused:
            findings.append(Finding(NOTHING.code, 'paused'))
        if not self.stream.streaming and not self._begin(command, now, findings):
            return findings
        if not self._go_on_to(now):
            return findings
        findings += self._step(command, now)
        return findings

    def _go_on_to(self, now: int) -> bool:
        """
        Take the next cycle's time; False where it has not come, or the stream has to begin anew.

        A delayed cycle counts as of the time at which it was due: what it sends is as fast
        as commanded, not as fast as the cycles followed each other.
        """
        period = round(self.parameters.publish_period * 1e9)
        ahead = self._stream_ns + period - now
        if self.clock.parted and 2 * ahead > period and ahead <= 2 * period:
            return False  # simulated time is paused, or slower than ours
        if ahead > 2 * period:
            # Time was set back, or cycles went on before it was noticed that time was paused.
            if not self.output.go_back(now, self.stream):
                self.stream.stop()
                return False
            ahead = 0
        self._stream_ns = now + max(ahead, -round(_MADE_UP * period))
        return True

    def _others(self) -> Finding | None:
        """Return what else moves the arm, None if nothing does."""
        if self.controller.goal_runs:
            return Finding(NOTHING.code, 'the controller follows a goal; commands wait')
        if self.controller.plan_runs:
            return Finding(NOTHING.code, 'move_group plans or moves; commands wait')
        if self.controller.inactive and self.stream.streaming:
            return Finding(ServoStatus.INVALID, self.controller.inactive)
        return None

    def _begin(self, command: Command | None, now: int, findings: list[Finding]) -> bool:
        """Start to stream where there is a command, and a controller that takes what is sent."""
        if command is None:
            return False
        obstacle = self.controller.inactive
        if not obstacle and not self.output.heard:
            obstacle = f"'{self.output.topic}' has no subscriber"
        if obstacle:
            findings.append(Finding(ServoStatus.INVALID, obstacle))
            return False
        if not self._is_valid(command, now):
            return False
        reference = self.controller.reference(now)
        if reference is None:
            if self.controller.awaited:
                return False
            self.states.read()
            reference = self.states.q[self.stream.target.indices]
        self.stream.start(reference)
        self.output.start(now, self.stream)
        self._stream_ns = now - round(self.parameters.publish_period * 1e9)
        self._quiet = 0
        return True

    def _is_valid(self, command: Command, now: int) -> bool:
        """Return whether a command can be followed."""
        try:
            self.stream.target.wanted(command, self.states.q, self.parameters)
        except InvalidCommandError as error:
            self.inbox.reject(str(error), now)
            return False
        return True

    def _step(self, command: Command | None, now: int) -> list[Finding]:
        try:
            cycle = self._follow(command, now)
        except InvalidCommandError as error:
            self.inbox.reject(str(error), now)
            command = None
            cycle = self._follow(command, now)
        findings = list(cycle.findings)
        if self.inbox.ceased:
            findings.append(Finding(NOTHING.code, 'no command has come for '
                                    f'{self.inbox.timeout_ns * 1e-9:g} s; the arm comes to rest'))
        self._quiet = self._quiet + 1 if cycle.at_rest else 0
        # The last point must have gone out, and not only as the newest.
        if command is not None or self._quiet <= 2:
            self.output.publish(self._stream_ns, cycle, self.stream, self.parameters)
        # The arm is not at rest before the points that were sent are behind it.
        elif self._quiet * self.parameters.publish_period > self.parameters.max_expected_latency:
            self.stream.stop()
        if not self.output.heard:
            findings.append(
                Finding(ServoStatus.INVALID, f"'{self.output.topic}' has no subscriber"))
        return findings

    def _follow(self, command: Command | None, now: int) -> Cycle:
        """Advance by a cycle; what ends or resumes the motion takes effect at once."""
        def step() -> Cycle:
            return self.stream.step(command, self.states.q, self.parameters)

        if self.stream.turns(command):
            self.output.replan(now, self._stream_ns, self.stream, step)
        return step()
