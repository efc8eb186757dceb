# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
A client of rclpy and control_msgs alone, as a user writes one: scripted runs against a controller.

``python plain_client.py CONTROLLER MANAGER JOINT JOINT [SCENARIO ...]`` prints ``ok NAME`` or
``failed NAME: reason`` for each scenario and leaves with 1 where one failed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
import multiprocessing
from pathlib import Path
import sys
import time

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from controller_manager_msgs.srv import SwitchController
from rcl_interfaces.srv import SetParameters
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

Result = FollowJointTrajectory.Result
SUCCEEDED = GoalStatus.STATUS_SUCCEEDED
CANCELED = GoalStatus.STATUS_CANCELED
ABORTED = GoalStatus.STATUS_ABORTED
KEEP_ALL = QoSProfile(history=QoSHistoryPolicy.KEEP_ALL)
TIMEOUT = 60.0
#: Goals of the burst, and the clients that send them at the same time.
BURST, CLIENTS = 200, 4


class Client(Node):
    """One client of a controller; waits by spinning."""

    def __init__(self, controller: str, manager: str, joints: list[str]) -> None:
        super().__init__(f'plain_client_{time.monotonic_ns()}')
        self.controller, self.manager, self.joints = controller, manager, joints
        self.action = ActionClient(
            self, FollowJointTrajectory, f'{controller}/follow_joint_trajectory',
            goal_service_qos_profile=KEEP_ALL, result_service_qos_profile=KEEP_ALL,
        )
        latched = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
        self.publisher = self.create_publisher(
            JointTrajectory, f'{controller}/joint_trajectory', latched
        )
        self.feedback = 0
        self.positions: dict[str, float] = {}
        self.farthest = 0.0
        self.create_subscription(
            JointState, f'{controller.rpartition("/")[0]}/joint_states', self.note, 10
        )
        assert self.action.wait_for_server(TIMEOUT), 'no action server'

    def note(self, state: JointState) -> None:
        """Keep the newest state, and how far the joints have ever been from 0."""
        self.positions = dict(zip(state.name, state.position, strict=True))
        self.farthest = max(self.farthest, *(abs(self.positions[j]) for j in self.joints))

    def wait(self, future: object) -> object:
        """Spin until a future is done."""
        rclpy.spin_until_future_complete(self, future, timeout_sec=TIMEOUT)
        assert future.done(), 'no answer'
        return future.result()

    def until(self, condition: Callable[[], bool], what: str) -> None:
        """Spin until a condition holds."""
        deadline = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < deadline, f'never: {what}'
            rclpy.spin_once(self, timeout_sec=0.1)

    def trajectory(self, *points: tuple[float, list[float]], joints: list[str] | None = None
                   ) -> JointTrajectory:
        """Return a trajectory of (time, positions)."""
        return JointTrajectory(
            joint_names=joints or self.joints,
            points=[
                JointTrajectoryPoint(positions=positions, time_from_start=duration(at))
                for at, positions in points
            ],
        )

    def send(self, trajectory: JointTrajectory, **tolerances: object) -> object:
        """Send a goal; return its handle."""
        goal = FollowJointTrajectory.Goal(trajectory=trajectory, **tolerances)
        return self.wait(self.action.send_goal_async(goal, feedback_callback=self.count))

    def count(self, _: object) -> None:
        """Count feedback."""
        self.feedback += 1

    def result(self, handle: object) -> tuple[int, int, str]:
        """Return status, code and text of the end."""
        assert handle.accepted, 'rejected'
        response = self.wait(handle.get_result_async())
        return response.status, response.result.error_code, response.result.error_string

    def run(self, *points: tuple[float, list[float]], **tolerances: object
            ) -> tuple[int, int, str]:
        """Send a goal and wait for its end."""
        return self.result(self.send(self.trajectory(*points), **tolerances))

    def moving(self, handle: object) -> object:
        """Wait until there is feedback."""
        assert handle.accepted, 'rejected'
        self.feedback = 0
        self.until(lambda: self.feedback > 0, 'feedback')
        return handle

    def call(self, kind: type, service: str, request: object) -> object:
        """Call a service."""
        client = self.create_client(kind, service)
        assert client.wait_for_service(TIMEOUT), f'no service {service}'
        response = self.wait(client.call_async(request))
        self.destroy_client(client)
        return response

    def set(self, node: str, name: str, value: object) -> None:
        """Set a parameter."""
        request = SetParameters.Request(parameters=[Parameter(name, value=value)
                                                    .to_parameter_msg()])
        response = self.call(SetParameters, f'{node}/set_parameters', request)
        assert response.results[0].successful, response.results[0].reason

    def switch(self, *, activate: bool) -> None:
        """Activate or deactivate the controller."""
        name = self.controller.rpartition('/')[2]
        request = SwitchController.Request(strictness=SwitchController.Request.STRICT)
        (request.activate_controllers if activate else request.deactivate_controllers).append(name)
        response = self.call(SwitchController, f'{self.manager}/switch_controller', request)
        assert response.ok, response.message

    def there(self, positions: list[float]) -> None:
        """Wait until the joints are measured at positions."""
        self.until(
            lambda: all(abs(self.positions.get(j, 1e9) - p) < 0.01
                        for j, p in zip(self.joints, positions, strict=True)),
            f'the joints at {positions}',
        )


def duration(value: float) -> Duration:
    """Return a duration message."""
    return Duration(sec=int(value), nanosec=round(value % 1.0 * 1e9))


def success(client: Client) -> None:
    """Check that a goal succeeds with feedback, and that the joints are there."""
    client.feedback = 0
    status, code, text = client.run((0.2, [0.1, 0.1]), (0.4, [0.2, -0.1]))
    assert (status, code) == (SUCCEEDED, 0), text
    assert client.feedback > 0
    client.there([0.2, -0.1])


def cancel(client: Client) -> None:
    """Check that a cancelled goal is CANCELED and that the joints stop on the way."""
    handle = client.moving(client.send(client.trajectory((1.0, [2.0, 2.0]))))
    assert client.wait(handle.cancel_goal_async()).goals_canceling
    status, code, text = client.result(handle)
    assert (status, code, text) == (CANCELED, 0, '')
    assert client.positions[client.joints[0]] < 1.9


def preempt_by_second_client(client: Client) -> None:
    """Check that the goal of a second client aborts the first one's and succeeds."""
    other = Client(client.controller, client.manager, client.joints)
    first = client.moving(client.send(client.trajectory((4.0, [2.0, 2.0]))))
    assert other.run((0.3, [0.1, 0.1]))[:2] == (SUCCEEDED, 0)
    status, code, text = client.result(first)
    assert (status, code) == (ABORTED, Result.INVALID_GOAL), text
    assert 'preempt' in text
    other.destroy_node()


def topic_against_action(client: Client) -> None:
    """Check that a message during a goal moves the arm elsewhere, and that the goal ends."""
    handle = client.moving(client.send(client.trajectory((1.0, [2.0, 2.0]))))
    client.publisher.publish(client.trajectory((0.2, [0.3, 0.1])))
    status, _, text = client.result(handle)
    assert status in (SUCCEEDED, CANCELED), text
    client.there([0.3, 0.1])


def path_tolerance(client: Client) -> None:
    """Check that a joint that does not follow violates the path tolerance of the goal."""
    client.set(client.manager, f'faults.{client.joints[1]}.blocked', True)
    try:
        bounds = [JointTolerance(name=name, position=0.2) for name in client.joints]
        status, code, text = client.run((0.5, [1.0, 1.0]), path_tolerance=bounds)
        assert (status, code) == (ABORTED, Result.PATH_TOLERANCE_VIOLATED), text
        assert client.joints[1] in text
    finally:
        client.set(client.manager, f'faults.{client.joints[1]}.blocked', False)


def goal_tolerance(client: Client) -> None:
    """Check that a joint that ends beside its goal violates the goal tolerance in time."""
    client.set(client.manager, f'faults.{client.joints[0]}.bias', 0.3)
    try:
        bounds = [JointTolerance(name=name, position=0.1) for name in client.joints]
        status, code, text = client.run(
            (0.3, [0.2, 0.2]), goal_tolerance=bounds, goal_time_tolerance=duration(0.2)
        )
        assert (status, code) == (ABORTED, Result.GOAL_TOLERANCE_VIOLATED), text
        assert client.joints[0] in text
    finally:
        client.set(client.manager, f'faults.{client.joints[0]}.bias', 0.0)


def partial_goals(client: Client) -> None:
    """Check that a goal of some joints is rejected, or holds the others where allowed."""
    partial = client.trajectory((0.2, [0.15]), joints=client.joints[:1])
    assert not client.send(partial).accepted
    client.set(client.controller, 'allow_partial_joints_goal', True)
    try:
        before = client.positions[client.joints[1]]
        assert client.result(client.send(partial))[0] == SUCCEEDED
        client.there([0.15, before])
    finally:
        client.set(client.controller, 'allow_partial_joints_goal', False)


def deactivation_while_moving(client: Client) -> None:
    """Check that deactivation aborts the goal, and that activation does not resume it."""
    handle = client.moving(client.send(client.trajectory((2.0, [1.0, 1.0]))))
    client.switch(activate=False)
    status, code, text = client.result(handle)
    assert (status, code) == (ABORTED, Result.INVALID_GOAL), text
    assert not client.send(client.trajectory((0.2, [0.0, 0.0]))).accepted
    client.switch(activate=True)
    assert client.positions[client.joints[0]] < 0.9
    assert client.run((0.3, [0.0, 0.0]))[0] == SUCCEEDED


def burst(client: Client) -> None:
    """Check that 200 goals of four clients have one end each and refused ones move nothing."""
    client.there([0.0, 0.0])
    client.farthest = 0.0
    context = multiprocessing.get_context('forkserver')
    context.set_forkserver_preload([Path(__file__).stem])
    arguments = (client.controller, client.manager, client.joints, BURST // CLIENTS)
    with ProcessPoolExecutor(CLIENTS, context) as pool:
        running = [pool.submit(one_of_the_burst, *arguments) for _ in range(CLIENTS)]
        client.until(lambda: all(one.done() for one in running), 'the end of the burst')
        counts = sum((one.result() for one in running), Counter())
    assert counts['rejected'] == BURST // 5, counts
    assert counts['ended'] == BURST - BURST // 5, counts
    assert counts['succeeded'] >= 1, counts
    # Refused goals name 5 rad, the others 0.05 at most.
    assert client.farthest < 0.1, client.farthest
    client.there([0.0, 0.0])


def one_of_the_burst(
    controller: str, manager: str, joints: list[str], count: int
) -> Counter[str]:
    """Send goals without waiting for one another; return what became of them."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    client = Client(controller, manager, joints)
    counts: Counter[str] = Counter()

    def answered(future: object) -> None:
        handle = future.result()
        counts['accepted' if handle.accepted else 'rejected'] += 1
        if handle.accepted:
            handle.get_result_async().add_done_callback(ended)

    def ended(future: object) -> None:
        counts['ended'] += 1
        counts['succeeded'] += future.result().status == SUCCEEDED

    for i in range(count):
        refused = i % 5 == 4
        points = [(0.1, [0.05 * (i % 2), 0.0]), (0.3, [5.0, 0.0] if refused else [0.0, 0.0])]
        if refused:
            points.append((0.2, [5.0, 0.0]))  # back in time
        goal = FollowJointTrajectory.Goal(trajectory=client.trajectory(*points))
        client.action.send_goal_async(goal).add_done_callback(answered)
        rclpy.spin_once(client, timeout_sec=0.0)
    client.until(
        lambda: counts['rejected'] + counts['ended'] == count, f'{count} ends, only {counts}'
    )
    client.destroy_node()
    rclpy.shutdown()
    return counts


SCENARIOS: dict[str, Callable[[Client], None]] = {
    scenario.__name__: scenario
    for scenario in (
        success, cancel, preempt_by_second_client, topic_against_action, path_tolerance,
        goal_tolerance, partial_goals, deactivation_while_moving, burst,
    )
}


def main(words: list[str]) -> int:
    """Run the scenarios."""
    controller, manager, *rest = words
    joints, names = rest[:2], rest[2:] or list(SCENARIOS)
    rclpy.init()
    client = Client(controller, manager, joints)
    failed = False
    for name in names:
        try:
            SCENARIOS[name](client)
            assert client.run((0.3, [0.0, 0.0]))[0] == SUCCEEDED
            print(f'ok {name}', flush=True)
        except AssertionError as error:
            failed = True
            print(f'failed {name}: {error!r}', flush=True)
    client.destroy_node()
    rclpy.shutdown()
    return int(failed)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
