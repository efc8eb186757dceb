# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a script plans with: scene, planner and execution in a thread of their own."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator, Mapping
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYetError
from contextlib import contextmanager
import threading
from typing import Any, TypeVar

import rclpy
from rclpy.context import Context as RosContext
from rclpy.parameter import Parameter
from rclpy.signals import (
    get_current_signal_handlers_options,
    install_signal_handlers,
    SignalHandlerOptions,
    uninstall_signal_handlers,
)
from rclpy.subscription import Subscription

from armsim_ros.cli.environment import announce_often
from armsim_ros.cli.node_arguments import NodeArguments
from armsim_ros.moveit_py.description import described_cell, OPTIONS
from armsim_ros.nodes.executor_program import failures_logged
from armsim_ros.nodes.move_group.execution.trajectory_execution import (
    TrajectoryExecutionEvent,
    TrajectoryExecutionManager,
)
from armsim_ros.nodes.move_group.parameters import ControllerManagerNode, MoveGroupParameters
from armsim_ros.nodes.move_group.planning.planner_services import DisplayPlannedPath
from armsim_ros.nodes.move_group.planning.planning_job import PlanningJob, PlanTopics
from armsim_ros.nodes.move_group.program import make_context
from armsim_ros.nodes.move_group.scene.octomap_monitor import octomap_settings, OctomapMonitor
from armsim_ros.nodes.move_group.scene.scene_services import GetPlanningScene
from armsim_ros.nodes.move_group.scene.scene_topics import (
    AttachedCollisionObjectTopic,
    CollisionObjectTopic,
    MonitoredPlanningScene,
    PlanningSceneTopic,
    PlanningSceneWorldTopic,
)
from armsim_ros.nodes.move_group.scene.transforms import Transforms
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.nodes.upstream.robot_programs import sensor_parameters
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor

Value = TypeVar('Value')
_Topic = PlanningSceneTopic | AttachedCollisionObjectTopic
#: Steps of a wait [s]; time for what was cancelled to end before KeyboardInterrupt is raised [s].
_STEP, _CANCEL_TIME = 0.1, 0.3
#: Time for cancellations to reach controllers when the script ends [s].
_END_TIME = 1.0


class MoveItCpp:
    """
    The parts of move_group that a script uses, without endpoints for clients.

    Everything runs in a thread of its own, in a context of its own: the script may use rclpy
    as it likes.

    :param arguments: name, namespace, parameters and remappings of the node.
    :param provide_planning_service: whether ``get_planning_scene`` is served.
    :raises RuntimeError: a description is missing, or no complete robot state came in time.
    """

    def __init__(self, arguments: NodeArguments, *, provide_planning_service: bool) -> None:
        # As upstream, where no parameter sets it.
        arguments.values.setdefault('moveit_manage_controllers', False)
        self.parameters: Mapping[str, Any] = dict(arguments.values)
        self._name = arguments.name
        announce_often()
        cell, warnings = described_cell(arguments)
        ros = self._ros = RosContext()
        rclpy.init(args=[arguments.name, *arguments.ros_args()], context=ros,
                   signal_handler_options=SignalHandlerOptions.NO)
        self._executor = WaitSetExecutor(context=ros)
        self._closing = False
        self._closed = threading.Lock()
        own = {'use_sim_time': bool(self.parameters.get('use_sim_time')),
               **sensor_parameters(self.parameters)}
        self.node = PollingNode(
            arguments.name, namespace=arguments.namespace, context=ros,
            parameter_overrides=[Parameter(name, value=value) for name, value in own.items()],
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True)
        self._executor.add_node(self.node)
        for text in warnings:
            self.node.get_logger().warning(text)
        self.context = make_context(self.node, self._executor, cell)
        self._make_endpoints(provide_planning_service)
        self._thread = threading.Thread(target=self._spin, name='moveit_py', daemon=True)
        self._thread.start()
        try:
            self._wait_for_state(
                float(self.parameters.get(f'{OPTIONS}.wait_for_initial_state_timeout') or 0.0))
        except BaseException:
            self.close()
            raise

    def _make_endpoints(self, provide_planning_service: bool) -> None:
        context = self.context
        self._kept: list[object] = [MoveGroupParameters(context)]
        self._manager = ControllerManagerNode(context)
        self._executor.add_node(self._manager.node)
        display = DisplayPlannedPath(self.node, context.robot.name, context.pipelines)
        self.job = PlanningJob(context, PlanTopics(context, display))
        self.execution = TrajectoryExecutionManager(context)
        self.octomap = OctomapMonitor(context, octomap_settings(context))
        self._kept += [
            MonitoredPlanningScene(context), TrajectoryExecutionEvent(context, self.execution),
            Transforms(context), PlanningSceneWorldTopic(context), CollisionObjectTopic(context)]
        if provide_planning_service:
            self._kept.append(GetPlanningScene(context))
        #: What can be stopped: kind of topic -> its subscription.
        self._followed: dict[type[_Topic], Subscription] = {}
        self.follow_scene(True)
        self.follow_state(True)

    def follow_scene(self, follow: bool) -> None:
        """Have ``planning_scene`` change the scene, or not; in the node's thread."""
        self._follow(PlanningSceneTopic, follow)

    def follow_state(self, follow: bool) -> None:
        """Have joint states and attached objects change the scene, or not; in that thread."""
        if follow:
            self.context.states.start()
        else:
            self.context.states.stop()
        self._follow(AttachedCollisionObjectTopic, follow)

    def _follow(self, topic: type[_Topic], follow: bool) -> None:
        if follow and topic not in self._followed:
            self._followed[topic] = topic(self.context).subscription
        elif not follow and topic in self._followed:
            self.node.destroy_subscription(self._followed.pop(topic))

    def _wait_for_state(self, timeout: float) -> None:
        states, context = self.context.states, self.context

        async def wait() -> bool:
            deadline = context.clock() + timeout
            while not states.complete and context.clock() < deadline:
                await context.ticker.next()
            states.update_scene()
            return states.complete

        if timeout > 0.0 and not self.call(wait):
            raise RuntimeError(
                f"no complete robot state within {timeout:g} s on {', '.join(states.topics)}: no "
                f"position of {', '.join(states.missing)}; does the joint_state_broadcaster run, "
                'and are the topics those of the robot (remappings=)?')

    # ---------------------------------------------------------------- the thread

    def _spin(self) -> None:
        while not self._closing and self._ros.ok():
            with failures_logged(self.node):
                callback, *_ = self._executor.wait_for_ready_callbacks(
                    None, None, self._is_closing)
                self.node.catch_up()
                self.context.states.update_scene()
                callback()
                if callback.done():
                    callback.result()  # raises what the callback raised

    def _is_closing(self) -> bool:
        # A method: rclpy forgets what else is ready where it is asked with another condition.
        return self._closing

    def submit(self, work: Callable[[], Awaitable[Value]]) -> Future[Value]:
        """
        Run a coroutine in the node's thread.

        :raises RuntimeError: the node has been shut down.
        """
        self.check()
        done: Future[Value] = Future()

        async def run() -> None:
            try:
                done.set_result(await work())
            except Exception as error:  # noqa: BLE001 - raised where it is waited for
                done.set_exception(error)

        self._executor.create_task(run)
        return done

    def call(
        self, work: Callable[[], Awaitable[Value]], cancel: Callable[[], None] | None = None
    ) -> Value:
        """
        Run a coroutine in the node's thread and wait for it.

        :param cancel: called where the wait is interrupted by Ctrl-C.
        :returns: what the coroutine returns; it also raises what that raises.
        :raises RuntimeError: the node is shut down.
        """
        with interruptible():
            done = self.submit(work)
            try:
                return self.wait(done)
            except KeyboardInterrupt:
                if cancel is not None:
                    cancel()
                    self._settle(done)
                raise

    def run(self, work: Callable[[], Value]) -> Value:
        """
        Run a function in the node's thread and wait for it.

        :returns: what the function returns; it also raises what that raises.
        :raises RuntimeError: the node is shut down.
        """
        async def call() -> Value:
            return work()

        return self.call(call)

    def wait(self, done: Future[Value]) -> Value:
        """
        Wait in steps for what was submitted; other threads run meanwhile.

        :raises RuntimeError: the node has been shut down.
        """
        while True:
            try:
                return done.result(_STEP)
            except NotYetError:
                if done.done():
                    raise
                if not self._thread.is_alive():
                    raise RuntimeError(self._ended) from None

    @staticmethod
    def _settle(done: Future[Any]) -> None:
        """Give what was cancelled time to end."""
        finished = threading.Event()
        done.add_done_callback(lambda _: finished.set())
        finished.wait(_CANCEL_TIME)

    def check(self) -> None:
        """
        Do nothing while the node runs.

        :raises RuntimeError: it has been shut down.
        """
        if self._closing or not self._ros.ok() or not self._thread.is_alive():
            raise RuntimeError(self._ended)

    @property
    def _ended(self) -> str:
        return f"node '{self._name}' has been shut down; make another MoveItPy to plan again"

    def close(self) -> None:
        """Cancel what is planned and executed, and leave the graph; may be called again."""
        with self._closed:
            if self._closing:
                return
            if self._ros.ok() and self._thread.is_alive():
                self._end_execution()
            self._closing = True
            self._executor.create_task(lambda: None)
            self._thread.join(_END_TIME)
            self._executor.shutdown(0.0)
            self._manager.node.destroy_node()
            self.node.destroy_node()
            self._ros.try_shutdown()
            self.context.close()
            self.octomap.close()

    def _end_execution(self) -> None:
        """Cancel executions and plans, and wait until their controllers have ended them."""
        context, execution = self.context, self.execution

        async def end() -> None:
            context.end('the script has ended')
            context.ticker.wake()
            deadline = context.clock() + _END_TIME
            while execution.busy and context.clock() < deadline:
                await context.ticker.next()

        finished = threading.Event()
        self.submit(end).add_done_callback(lambda _: finished.set())
        finished.wait(_END_TIME + _STEP)


@contextmanager
def interruptible() -> Iterator[None]:
    """
    Have Ctrl-C raise KeyboardInterrupt inside before it ends the contexts of rclpy.

    The handlers that ``rclpy.init`` installs shut all contexts down at once, and what has to be
    cancelled could be cancelled no more. They are set aside meanwhile; the script's own context
    is shut down after the interrupt, as they do.
    """
    options = SignalHandlerOptions.NO
    if threading.current_thread() is threading.main_thread():
        options = get_current_signal_handlers_options()
    if options not in (SignalHandlerOptions.ALL, SignalHandlerOptions.SIGINT):
        yield
        return
    uninstall_signal_handlers()
    if options == SignalHandlerOptions.ALL:
        install_signal_handlers(SignalHandlerOptions.SIGTERM)
    try:
        yield
    except KeyboardInterrupt:
        rclpy.try_shutdown()
        raise
    finally:
        uninstall_signal_handlers()
        install_signal_handlers(options)
