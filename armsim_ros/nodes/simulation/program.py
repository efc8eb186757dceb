# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation program from start to end."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
import sys
import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from armsim_ros.cli.arguments import ProgramArguments, UsageError
from armsim_ros.cli.settings import cell_of
from armsim_ros.control.faults import FaultInjector, FaultyControllers
from armsim_ros.errors import USAGE_STATUS
from armsim_ros.nodes.bringup.domain_lock import DomainLock, lock_domain
from armsim_ros.nodes.simulation.clock import Clock
from armsim_ros.nodes.simulation.clock_hint import ClockHint
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.robot_nodes import RobotNodes
from armsim_ros.nodes.simulation.robot_state_publisher import RobotStatePublisher
from armsim_ros.nodes.simulation.simulation_state import SimulationStateServices
from armsim_ros.nodes.simulation.threads import (
    ControlThread,
    ExecutorThread,
    prioritize_process,
)
from armsim_ros.sim.assembly import as_one, build_managers, build_simulation
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import Pacer
from armsim_ros.sim.realtime import prefer_latency

#: How long each thread gets to end [s].
_STOP_TIME = 0.3
#: Events, the graph and the clocks are looked at this often, also while paused [s].
_WATCH_PERIOD = 0.1
_DIAGNOSTICS_PERIOD = 1.0


class SimulationProgram:
    """
    Robots, controllers, loop, nodes, and the three threads that run them.

    The control thread moves time, the executor's thread answers services and actions, and the
    thread that calls ``run`` publishes what the loop hands over.

    :param arguments: the command line.
    :param stop_wanted: whether a signal came; looked at between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot that can run.
    :raises UsageError: a remapping would give several robots one name.
    :raises DomainTakenError: another simulation has these names on this machine.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        """Read the files and build the robot; no node exists yet."""
        self._stop_wanted = stop_wanted
        self._ros_args = arguments.ros_args
        self._status = 0
        self._dispatcher = Dispatcher()
        self._cell, self._warnings = cell_of(arguments)
        self._locks = self._lock_names()
        settings = self._cell.settings
        simulation = settings.simulation
        self._clock = SimClock(
            simulation.timestep_ns,
            time.time_ns(),
            paused=simulation.paused,
            real_time_factor=simulation.real_time_factor,
        )
        self._simulation = build_simulation(settings, self._cell.model, clock=self._clock)
        self._faults = FaultInjector(self._simulation) if simulation.fault_injection else None
        self._managers = build_managers(self._cell, self._faults or self._simulation)
        controllers = as_one(self._managers)
        pace = simulation.pace
        self._loop = ControlLoop(
            self._simulation,
            FaultyControllers(controllers, self._faults) if self._faults else controllers,
            settings.controller_manager.update_rate,
            pacer=Pacer(
                spin_ns=round(pace.spin * 1e9), catch_up_ns=round(pace.catch_up * 1e9)
            ),
            priority=pace.priority,
        )

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
        prioritize_process(self._cell.settings.simulation.pace.priority)
        rclpy.init(
            args=['simulation', *self._ros_args], signal_handler_options=SignalHandlerOptions.NO
        )
        self._executor = SingleThreadedExecutor()
        self._control = ControlThread(self._loop)
        try:
            self._create_nodes()
            self._create_services()
            executor = ExecutorThread(self._executor, self._robots[0].node.get_logger())
            if not self._stop_wanted():
                prefer_latency()
                self._clock.reset(time.time_ns())
                self._control.start()
                executor.start()
                self._dispatcher.run()
            self._control.stop(_STOP_TIME)
            executor.stop(_STOP_TIME)
        finally:
            for node in self._executor.get_nodes():
                node.destroy_node()
            rclpy.try_shutdown()
            for lock in self._locks:
                lock.release()
        return self._status

    def _lock_names(self) -> list[DomainLock]:
        """Keep the namespace of each robot for us, as far as this machine goes."""
        robots = self._cell.robots
        for word in self._ros_args:
            if word.startswith('__ns:=') and len(robots) > 1:
                raise UsageError(
                    f"the remapping '{word}' would put the controller managers of {len(robots)} "
                    "robots into one namespace; give each robot its 'namespace' in robots.yaml"
                )
        return [
            lock_domain(
                self._ros_args, program='simulation', namespace=robot.settings.namespace or '/'
            )
            for robot in robots
        ]

    def _create_nodes(self) -> None:
        """Create first what others must discover early: controllers, /clock, transforms."""
        self._robots = [
            RobotNodes(
                robot,
                self._managers[robot.name],
                self._loop,
                self._executor,
                self._dispatcher,
                self._faults,
            )
            for robot in self._cell.robots
        ]
        self._simulation_node = self._node('simulation', '/', start_parameter_services=False)
        self._clock_publisher = Clock(self._simulation_node)
        for text in (*self._warnings, *self._simulation.warnings):
            self._robots[0].node.get_logger().warning(text)
        RobotStatePublisher(
            self._node('robot_state_publisher', '/'), self._cell.model, self._simulation
        ).follow(self._loop, self._dispatcher)
        self._loop.every(
            round(1e9 / self._cell.settings.simulation.clock_rate),
            lambda time_ns: self._dispatcher.post(partial(self._publish, time_ns)),
        )

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
        SimulationStateServices(self._simulation_node, self._loop, self._dispatcher, self.stop)
        logger = self._robots[0].node.get_logger()
        self._clock_hint = ClockHint(self._clock, logger.warning)
        self._dispatcher.every(_WATCH_PERIOD, self._watch)
        logger.info(
            f"simulation of '{self._cell.model.name}' runs; controllers: {', '.join(states)}"
        )

    def _publish(self, time_ns: int) -> None:
        self._clock_publisher.publish(time_ns)
        for nodes in self._robots:
            nodes.publish(time_ns)
        self._tell_faults()

    def _watch(self) -> None:
        if self._control.failed:
            self._fail(1, f'the control loop failed:\n{self._control.failure}')
        if self._clock.paused:
            self._clock_publisher.publish(self._clock.now_ns)
        for nodes in self._robots:
            nodes.watch(self._clock.now_ns)
        self._tell_faults()
        self._clock_hint.look()

    def _tell_faults(self) -> None:
        for fault in self._loop.poll_faults():
            self._simulation_node.get_logger().error(fault)

    def _refuse(self, reason: str) -> None:
        self._fail(USAGE_STATUS, reason)

    def _fail(self, status: int, text: str) -> None:
        print(f'simulation: {text}', file=sys.stderr, flush=True)
        self._status = status
        self.stop()

    def _node(self, name: str, namespace: str, **options: bool) -> Node:
        node = Node(name, namespace=namespace, **options)
        self._executor.add_node(node)
        return node
