# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The bench of single joints under test, and a client of each of its controllers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from builtin_interfaces.msg import Duration, Time
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance, JointTrajectoryControllerState, SpeedScalingFactor
from control_msgs.srv import QueryTrajectoryState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from armsim_ros.clients.client_node import ClientNode, LATCHED
from armsim_ros.clients.controller_manager import ControllerManagerClient, ParameterClient
from armsim_ros.clients.trajectory import Goal, Outcome, SUCCEEDED, TrajectoryClient
from armsim_ros.testing.program import Program

#: So many clients of controllers live at a time.
KEPT = 2
BROADCASTER = 'joint_state_broadcaster'
#: So many messages may be under way: one in the reader, one on the wire.
STALE = 2
#: Update period of the bench's controller manager [s].
PERIOD = 0.01

Result = FollowJointTrajectory.Result


def nanoseconds(stamp: Time | Duration) -> int:
    """Return a time or duration message in ns."""
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def seconds(stamp: Time | Duration) -> float:
    """Return a time or duration message in s."""
    return nanoseconds(stamp) * 1e-9


def duration(value: float) -> Duration:
    """Return a duration message; negative values as ROS normalizes them."""
    sec, nanosec = divmod(round(value * 1e9), 1_000_000_000)
    return Duration(sec=sec, nanosec=nanosec)


def stamp_at(time_ns: int) -> Time:
    """Return a time message."""
    sec, nanosec = divmod(time_ns, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)


def point(
    time_from_start: float,
    positions: Sequence[float] = (),
    velocities: Sequence[float] = (),
    accelerations: Sequence[float] = (),
    effort: Sequence[float] = (),
) -> JointTrajectoryPoint:
    """Return a waypoint."""
    return JointTrajectoryPoint(
        positions=[float(value) for value in positions],
        velocities=[float(value) for value in velocities],
        accelerations=[float(value) for value in accelerations],
        effort=[float(value) for value in effort],
        time_from_start=duration(time_from_start),
    )


def tolerance(
    name: str, position: float = 0.0, velocity: float = 0.0, acceleration: float = 0.0
) -> JointTolerance:
    """Return the tolerances of a joint."""
    return JointTolerance(
        name=name, position=position, velocity=velocity, acceleration=acceleration
    )


@dataclass(frozen=True)
class Sample:
    """Reference of a trajectory at a time since its start [s]."""

    time: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    accelerations: tuple[float, ...]


def stands(state: JointTrajectoryControllerState) -> bool:
    """Return whether all joints stand at the reference."""
    velocities = (*state.feedback.velocities, *state.reference.velocities)
    return all(abs(e) < 2e-3 for e in state.error.positions) and all(
        abs(v) < 1e-2 for v in velocities
    )


class TrajectoryController(TrajectoryClient):
    """
    One trajectory controller of the bench.

    :param joints: in the order of all arrays.
    """

    def __init__(self, client: ClientNode, controller: str, joints: Sequence[str]) -> None:
        super().__init__(client, controller)
        self.joints = list(joints)
        self.states = client.collect(
            f'{controller}/controller_state', JointTrajectoryControllerState, 1
        )
        self.parameters = ParameterClient(client, controller)
        self._speed: Any = None

    def trajectory(
        self, *points: JointTrajectoryPoint, joints: Sequence[str] | None = None, stamp_ns: int = 0
    ) -> JointTrajectory:
        """Return a trajectory of this controller's joints."""
        names = self.joints if joints is None else list(joints)
        message = JointTrajectory(joint_names=names, points=list(points))
        message.header.stamp = stamp_at(stamp_ns)
        return message

    def to(
        self, positions: Sequence[float], time_from_start: float = 0.2, stamp_ns: int = 0
    ) -> JointTrajectory:
        """Return a trajectory of one point."""
        return self.trajectory(point(time_from_start, positions), stamp_ns=stamp_ns)

    def goal(self, trajectory: JointTrajectory, **tolerances: Any) -> Goal:
        """Send a goal with the message's own fields for tolerances."""
        return self.send_goal(FollowJointTrajectory.Goal(trajectory=trajectory, **tolerances))

    def run(self, trajectory: JointTrajectory, **tolerances: Any) -> Outcome:
        """Send a goal and wait for its end."""
        return self.goal(trajectory, **tolerances).result()

    def go(self, positions: Sequence[float], time_from_start: float = 0.12) -> None:
        """Move there and stand still."""
        outcome = self.run(self.to(positions, time_from_start))
        assert outcome.status == SUCCEEDED, outcome
        self.settle()

    def home(self) -> None:
        """Bring all joints to 0, where they are not there yet."""
        state = self.newest()
        if max(map(abs, state.reference.positions)) > 1e-9:
            self.go([0.0] * len(self.joints))
        elif not stands(state):
            self.settle()

    def settle(self) -> None:
        """Wait until all joints stand at the reference."""
        self.next_state(stands)

    def newest(self) -> JointTrajectoryControllerState:
        """Return a state from now on."""
        return self.watch(1)[0]

    def next_state(
        self, matches: Callable[[JointTrajectoryControllerState], bool], timeout: float = 30.0
    ) -> JointTrajectoryControllerState:
        """Wait for a state that matches, from now on."""
        self.watch(1)
        return self.states.wait_for(matches, timeout)

    def reaches(self, positions: Sequence[float]) -> bool:
        """Wait until the reference is at positions; it is an error if that never happens."""

        def there(state: JointTrajectoryControllerState) -> bool:
            pairs = zip(state.reference.positions, positions, strict=True)
            return max(abs(a - b) for a, b in pairs) < 1e-6

        self.next_state(there)
        return True

    def watch(self, count: int) -> list[JointTrajectoryControllerState]:
        """Return so many states from now on; those that were under way are left out."""
        self.states.clear()
        return self.states.wait(count + STALE)[STALE:]

    def now_ns(self) -> int:
        """Return the controller's time."""
        return nanoseconds(self.newest().header.stamp)

    def query(self, time_ns: int) -> QueryTrajectoryState.Response:
        """Ask for the state at an absolute time."""
        request = QueryTrajectoryState.Request(time=stamp_at(time_ns))
        return self.client.call(f'{self.controller}/query_state', QueryTrajectoryState, request)

    def scale_speed(self, factor: float) -> None:
        """Publish a pace, latched as upstream's documentation asks."""
        topic = f'{self.controller}/speed_scaling_input'
        if self._speed is None:
            self._speed = self.client.node.create_publisher(SpeedScalingFactor, topic, LATCHED)
        self._speed.publish(SpeedScalingFactor(factor=factor))

    def close(self) -> None:
        """Take the endpoints away."""
        self.states.close()
        super().close()
        if self._speed is not None:
            self.client.in_executor(lambda: self.client.node.destroy_publisher(self._speed))

    def set_speed(self, factor: float) -> None:
        """Change the pace and wait until the controller shows it."""
        for _ in range(10):
            # A best-effort reader gets nothing of what was published before the two had met.
            self.scale_speed(factor)
            if any(s.speed_scaling_factor == factor for s in self.watch(10)):
                return
        raise AssertionError(f'the pace did not become {factor}')


def feedback_samples(goal: Goal) -> list[Sample]:
    """Return the references that a goal's feedback showed."""
    return [
        Sample(
            seconds(message.desired.time_from_start),
            tuple(message.desired.positions),
            tuple(message.desired.velocities),
            tuple(message.desired.accelerations),
        )
        for message in goal.feedback
    ]


class Bench:
    """
    The server under test with the bench as its robot.

    :param namespace: of the controller manager, without a slash at the end.
    :param program: None where the server ran before.
    """

    def __init__(
        self, domain: int, namespace: str, client: ClientNode, program: Program | None
    ) -> None:
        self.domain = domain
        self.namespace = namespace
        self.client = client
        self.program = program
        self.manager = ControllerManagerClient(client, f'{namespace}/controller_manager')
        self._controllers: dict[str, TrajectoryController] = {}

    def name(self, relative: str) -> str:
        """Return the full name of an endpoint."""
        return f'{self.namespace}/{relative}'

    def activate(self, *names: str) -> None:
        """Let exactly these controllers run beside the broadcaster."""
        states = self.manager.states()
        for name in names:
            if name not in states:
                assert self.manager.load(name), f'{name} cannot be loaded'
            if states.get(name, 'unconfigured') == 'unconfigured':
                assert self.manager.configure(name), f'{name} cannot be configured'
        wanted = {BROADCASTER, *names}
        active = {name for name, state in states.items() if state == 'active'}
        if wanted != active:
            response = self.manager.switch(
                activate=sorted(wanted - active), deactivate=sorted(active - wanted)
            )
            assert response.ok, response.message

    def use(self, name: str, *, home: bool = True) -> TrajectoryController:
        """Let one trajectory controller run, with its joints at rest at 0."""
        self.activate(name)
        controller = self.trajectory_controller(name)
        controller.wait_for_server()
        if home:
            controller.home()
        return controller

    def trajectory_controller(self, name: str) -> TrajectoryController:
        """Return the client of a trajectory controller that is configured."""
        if name not in self._controllers:
            # Every endpoint slows this process' executor down: keep few.
            while len(self._controllers) >= KEPT:
                self._controllers.pop(next(iter(self._controllers))).close()
            states = self.manager.controllers()[name].required_state_interfaces
            joints = [one.removesuffix('/position') for one in states if one.endswith('/position')]
            self._controllers[name] = TrajectoryController(self.client, self.name(name), joints)
        return self._controllers[name]

    def forget(self, name: str) -> None:
        """Forget the client of a controller that is no more."""
        client = self._controllers.pop(name, None)
        if client is not None:
            client.close()
