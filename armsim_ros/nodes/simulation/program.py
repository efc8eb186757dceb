# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation program from start to end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
import sys
import threading
import time

import rclpy
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from armsim_ros.cli.arguments import ProgramArguments, UsageError
from armsim_ros.cli.settings import cell_of
from armsim_ros.control.mailbox import ControllerEvent
from armsim_ros.errors import USAGE_STATUS
from armsim_ros.model.transforms import matrix_from_rpy, pose_from_parts
from armsim_ros.nodes.bringup.domain_lock import DomainLock, lock_domain
from armsim_ros.nodes.camera.link import NAME as CAMERA
from armsim_ros.nodes.camera.link import socket_path
from armsim_ros.nodes.qos import publish_text
from armsim_ros.nodes.robot_program import LAST_ANSWERS_TIME
from armsim_ros.nodes.shutdown import shut_down
from armsim_ros.nodes.simulation.camera_feed import CameraFeed
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.lockstep import Dump, OctomapWait, serve_trigger
from armsim_ros.nodes.simulation.robot_nodes import RobotNodes
from armsim_ros.nodes.simulation.sim_time import Clock, ClockHint, IDLE_PERIOD, SimTime
from armsim_ros.nodes.simulation.threads import (
    ControlThread,
    ExecutorThread,
    prioritize_process,
    PriorityWatch,
    RealTimeThreads,
)
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.nodes.simulation.world.server import WorldServer
from armsim_ros.nodes.upstream.robot_state_publisher import RobotStatePublisher, transform
from armsim_ros.nodes.wait_set_executor import WaitSetExecutor
from armsim_ros.recording.flight_recorder import FlightRecorder
from armsim_ros.sim.assembly import build_control, build_simulation, run_digest
from armsim_ros.sim.camera import Camera, cameras_of
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import Pacer, prefer_latency

#: How long each thread may take to end [s].
_STOP_TIME = 0.3
#: How often goals that are aborted are checked [s].
_CHECK_PERIOD = 0.02
#: How often events, graph and clocks are checked, also while paused [s].
_WATCH_PERIOD = 0.1
#: A slow start may hold up the loop so long without making simulated time late for good [ns].
_LONGEST_START_NS = 3_000_000_000
_DIAGNOSTICS_PERIOD = 1.0
#: Simulated time starts at a multiple of this [ns], so that what is due at the same rate, such as
#: updates and /clock, is due in the same step.
_START_NS = 10_000_000
#: More time than any delay [ns].
_ALL = 10**18


class SimulationProgram:
    """
    Robots, controllers, loop and nodes, and the three threads that run them.

    The control thread moves time, the executor's thread answers services and actions, and the
    thread that calls ``run`` publishes what the loop hands over.

    :param stop_wanted: whether a signal came; read between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot that can run.
    :raises UsageError: a remapping would give several robots the same name.
    :raises DomainTakenError: another simulation has these names on this machine.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        self._stop_wanted = stop_wanted
        self._ros_args = arguments.ros_args
        self._status = 0
        self._dump: Dump | None = None
        self._threads = RealTimeThreads()
        self._time = SimTime(used=arguments.use_sim_time)
        self._cell, self._warnings = cell_of(arguments)
        self._locks = self._lock_names()
        self._cameras = self._lock_cameras() if arguments.camera else ()
        settings = self._cell.settings
        simulation = settings.simulation
        self._dispatcher = Dispatcher(leaves_out=not simulation.deterministic)
        self._clock = SimClock(
            simulation.timestep_ns, 0 if simulation.deterministic else time.time_ns(),
            paused=simulation.paused, real_time_factor=simulation.real_time_factor)
        self._time.now = lambda: self._clock.now_ns
        self._simulation = build_simulation(settings, self._cell.model, clock=self._clock)
        self._managers, controllers, self._faults = build_control(self._cell, self._simulation)
        pace = simulation.pace
        self._loop = ControlLoop(
            self._simulation,
            controllers,
            settings.controller_manager.update_rate,
            pacer=Pacer(
                spin_ns=round(pace.spin * 1e9),
                catch_up_ns=(round(pace.catch_up * 1e9)
                             if settings.controller_manager.overruns.manage else _ALL),
                catch_up_at_start_ns=_LONGEST_START_NS),
            priority=pace.priority)
        self._loop.on_handed_over = self._dispatcher.wake
        self._octomap: OctomapWait | None = None

    def stop(self) -> None:
        """End ``run``; from a signal handler too."""
        self._dispatcher.stop()

    def run(self) -> int:
        """
        Run until ``stop``, or until something fails.

        :returns: the exit status.
        """
        if self._stop_wanted():
            return 0
        simulation = self._cell.settings.simulation
        prioritized = prioritize_process(simulation.pace.priority)
        rclpy.init(
            args=['simulation', *self._ros_args], signal_handler_options=SignalHandlerOptions.NO)
        self._executor = WaitSetExecutor()
        self._control = ControlThread(self._loop)
        nodes: list[Node] = []
        try:
            self._create_nodes()
            self._create_services()
            executor = ExecutorThread(self._executor, self._robots[0].node.get_logger())
            if not self._stop_wanted():
                prefer_latency()
                if not simulation.deterministic:
                    self._clock.reset(time.time_ns() // _START_NS * _START_NS)
                self._time.update()
                self._control.start()
                executor.start()
                if prioritized:
                    PriorityWatch(self._switch_priority,
                                  self._robots[0].node.get_logger().warning).start()
                self._dispatcher.run()
                self._end_goals()
            nodes = self._executor.get_nodes()
            self._control.stop(_STOP_TIME)
            executor.stop(_STOP_TIME)
            if self._dump is not None:
                self._dump.close()
        finally:
            shut_down(*nodes)
            for lock in self._locks:
                lock.release()
        return self._status

    def _switch_priority(self, real_time: bool) -> None:
        self._threads.switch(real_time)
        self._loop.has_priority = real_time

    def _end_goals(self) -> None:
        """Abort the remaining goals, as far as time allows."""
        if not any(nodes.pending for nodes in self._robots):
            return
        for nodes in self._robots:
            self._executor.create_task(nodes.end, 'the simulation is shutting down')
        deadline = time.monotonic() + _STOP_TIME
        while any(nodes.pending for nodes in self._robots) and time.monotonic() < deadline:
            time.sleep(_CHECK_PERIOD)
        for _ in range(2):  # a goal that has ended sends its result in a task of its own
            done = threading.Event()
            self._executor.create_task(done.set)
            done.wait(_STOP_TIME)
        time.sleep(LAST_ANSWERS_TIME)

    def _lock_names(self) -> list[DomainLock]:
        """Lock the namespace of each robot on this machine."""
        robots = self._cell.robots
        for word in self._ros_args:
            if word.startswith('__ns:=') and len(robots) > 1:
                raise UsageError(
                    f"the remapping '{word}' would put the controller managers of {len(robots)} "
                    "robots into one namespace; give each robot its 'namespace' in robots.yaml")
        return [
            lock_domain(
                self._ros_args, program='simulation', namespace=robot.settings.namespace or '/')
            for robot in robots]

    def _lock_cameras(self) -> tuple[Camera, ...]:
        """Return the cameras and lock their socket."""
        settings = self._cell.settings.simulation
        if not settings.cameras:
            raise UsageError(
                f"camera:=true finds no camera: '{self._cell.model.name}' has none under "
                "'cameras' in its simulation.yaml")
        cameras = cameras_of(settings.cameras, self._cell.model)
        self._locks.append(lock_domain(self._ros_args, program=CAMERA))
        return cameras

    def _create_nodes(self) -> None:
        """Create first what others must discover early: controllers, /clock, transforms."""
        self._robots = [
            RobotNodes(
                robot, self._managers[robot.name], self._loop, self._executor, self._dispatcher,
                self._faults, self._time)
            for robot in self._cell.robots]
        self._simulation_node = self._node('simulation', '/')
        settings = self._cell.settings
        period_ns = self._loop.steps_per_update * self._clock.step_ns
        self._clock_publisher = Clock(
            self._simulation_node, period_ns if settings.simulation.deterministic else 0)
        refusals = [text for manager in self._managers.values() for text in manager.refusals]
        logger = self._robots[0].node.get_logger()
        for text in (*self._warnings, *refusals, *self._simulation.warnings):
            logger.warning(text)
        for text in self._simulation.remarks:
            logger.info(text)
        if not self._cell.model.srdf:
            logger.info("without an SRDF the robot's links pass through each other in the physics")
        period_ns = round(1e9 / settings.simulation.clock_rate)
        if settings.simulation.state_publisher:
            self._create_state_publisher(period_ns)
        post = self._dispatcher.bounded()
        self._loop.every(period_ns, lambda time_ns: post(partial(self._publish, time_ns)))

    def _create_state_publisher(self, period_ns: int) -> None:
        """Publish what robot_state_publisher does, from the positions of all joints."""
        model, placement = self._cell.model, self._cell.settings.simulation.placement
        node = self._node('robot_state_publisher', '/')
        fixed = []
        if model.parent_frame:
            pose = pose_from_parts(placement.xyz, matrix_from_rpy(placement.rpy))
            fixed.append(transform(model.parent_frame, model.root_link, pose))
        publisher = RobotStatePublisher(node, model.urdf, fixed)
        self._semantic = publish_text(node, 'robot_description_semantic', model.srdf)
        names, position = model.movable_joints, self._simulation.state.position
        post = self._dispatcher.bounded()
        self._loop.every(period_ns, lambda time_ns: post(partial(
            publisher.take, names, position.copy(), time_ns, now_ns=time_ns)))

    def _create_services(self) -> None:
        """
        Create the rest: services, parameters, diagnostics.

        Not while the loop runs: each new endpoint holds the interpreter for milliseconds.
        """
        states = []
        several = len(self._robots) > 1
        for robot, nodes in zip(self._cell.robots, self._robots, strict=True):
            place = f'{robot.settings.namespace}/'.lstrip('/') if several else ''
            nodes.create_services(f'{place}controller_manager', self._refuse)
            states += [f'{place}{name} [{state}]' for name, state in nodes.controller_states()]
            if robot.model is not self._cell.model and robot.settings.namespace:
                nodes.publish_descriptions()
            self._dispatcher.every(_DIAGNOSTICS_PERIOD, nodes.publish_diagnostics)
        self._world = WorldServer(
            self._simulation_node, self._cell, self._loop, self._dispatcher,
            self._publish_now, self._settle, self.stop)
        for nodes in self._robots:
            nodes.wire(self._world.cups)
        self._create_lockstep_services()
        if self._cameras:
            self._feed = CameraFeed(
                self._loop, self._cameras, socket_path(self._ros_args),
                self._simulation_node.get_logger().error,
                lockstep=self._cell.settings.simulation.deterministic)
            if self._cell.settings.simulation.deterministic:
                node = self._simulation_node
                self._octomap = OctomapWait(
                    node, Work(node, self._loop, self._dispatcher), lambda: self._feed.pictures,
                    self._sync)
        logger = self._robots[0].node.get_logger()
        self._clock_hint = ClockHint(self._clock, logger.warning)
        self._dispatcher.every(_WATCH_PERIOD, self._watch)
        self._dispatcher.every(IDLE_PERIOD, self._time.update)
        logger.info(
            f"simulation of '{self._cell.model.name}' runs; controllers: {', '.join(states)}")

    async def _settle(self) -> None:
        """Wait in lockstep for what programs make of what a step has published."""
        if self._octomap is not None:
            await self._octomap()

    def _create_lockstep_services(self) -> None:
        node = self._simulation_node
        work = Work(node, self._loop, self._dispatcher)
        # Topics have no answer: a client that needs the present state waits for the message with
        # the time that this service returns.
        serve_trigger(node, work, '/simulation/sync', self._sync)
        # Plant, drives, controllers and time; equal runs have equal hashes.
        serve_trigger(node, work, '/simulation/digest',
                      lambda: run_digest(self._simulation, self._managers))
        settings = self._cell.settings.simulation.recorder
        if not settings.seconds:
            return
        recorder = FlightRecorder(
            self._cell, self._simulation, self._managers, seconds=settings.seconds)
        self._loop.every(recorder.period_ns, recorder.sample)
        self._dump = Dump(node, work, recorder, settings, self._recent_events)

    def _recent_events(self) -> list[ControllerEvent]:
        events = [event for nodes in self._robots for event in nodes.recent_events]
        return sorted(events, key=lambda event: event.time_ns)

    def _sync(self) -> int:
        """Queue the current state for publishing; return its time [ns]."""
        for nodes in self._robots:
            nodes.sample_joint_states(self._clock.now_ns)
        return self._publish_now()

    def _publish_now(self) -> int:
        """Publish at once what goes out at the rate of /clock; return its time [ns]."""
        now_ns = self._clock.now_ns
        self._dispatcher.post(lambda: self._publish(now_ns))
        return now_ns

    def _publish(self, time_ns: int) -> None:
        self._clock_publisher.publish(time_ns)
        for nodes in self._robots:
            nodes.publish(time_ns)
        self._tell_faults()

    def _watch(self) -> None:
        if self._control.failed:
            self._fail(1, f'the control loop failed:\n{self._control.failure}')
        if self._clock.paused:
            self._time.update()
            self._clock_publisher.publish(self._clock.now_ns)
        for nodes in self._robots:
            nodes.watch(self._clock.now_ns)
        self._tell_faults()
        if not self._cell.settings.simulation.deterministic:
            self._clock_hint.look()

    def _tell_faults(self) -> None:
        for fault in self._loop.poll_faults():
            self._simulation_node.get_logger().error(fault)
            if self._dump is not None:
                self._dump.write_soon('the fault of the physics')

    def _refuse(self, reason: str) -> None:
        self._fail(USAGE_STATUS, reason)

    def _fail(self, status: int, text: str) -> None:
        with suppress(OSError):  # a full pipe must not block the shutdown
            print(f'simulation: {text}', file=sys.stderr, flush=True)
        self._status = status
        self.stop()

    def _node(self, name: str, namespace: str, **options: bool) -> Node:
        node = self._time.node(name, namespace=namespace, **options)
        self._executor.add_node(node)
        return node
