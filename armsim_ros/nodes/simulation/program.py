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

from armsim_ros.cli.arguments import ProgramArguments
from armsim_ros.cli.settings import robot_of
from armsim_ros.control.controller_manager import ControllerManager
from armsim_ros.control.faults import FaultInjector, FaultyControllers
from armsim_ros.errors import USAGE_STATUS
from armsim_ros.nodes.bringup.domain_lock import lock_domain
from armsim_ros.nodes.parameters import SettingsParameters
from armsim_ros.nodes.simulation.activity import Activity
from armsim_ros.nodes.simulation.clock import Clock
from armsim_ros.nodes.simulation.clock_hint import ClockHint
from armsim_ros.nodes.simulation.controller_descriptions import ControllerDescriptions
from armsim_ros.nodes.simulation.controller_manager_queries import ControllerManagerQueries
from armsim_ros.nodes.simulation.controller_manager_services import ControllerManagerServices
from armsim_ros.nodes.simulation.controller_registry import ControllerRegistry
from armsim_ros.nodes.simulation.diagnostics import Diagnostics
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.domain_watch import DomainWatch
from armsim_ros.nodes.simulation.event_log import EventLog
from armsim_ros.nodes.simulation.fault_parameters import FaultParameters
from armsim_ros.nodes.simulation.robot_state_publisher import RobotStatePublisher
from armsim_ros.nodes.simulation.simulation_state import SimulationStateServices
from armsim_ros.nodes.simulation.threads import (
    ControlThread,
    ExecutorThread,
    prioritize_process,
)
from armsim_ros.sim.assembly import build_manager, build_simulation
from armsim_ros.sim.clock import SimClock
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.pacer import Pacer
from armsim_ros.sim.realtime import prefer_latency
from armsim_ros.sim.simulation import Simulation

#: How long each thread gets to end [s].
_STOP_TIME = 0.3
#: Events, the graph and the clocks are looked at this often, also while paused [s].
_WATCH_PERIOD = 0.1
_DIAGNOSTICS_PERIOD = 1.0


class SimulationProgram:
    """
    Robot, controllers, loop, nodes, and the three threads that run them.

    The control thread moves time, the executor's thread answers services and actions, and the
    thread that calls ``run`` publishes what the loop hands over.

    :param arguments: the command line.
    :param stop_wanted: whether a signal came; looked at between the steps of the start.
    :raises ConfigError: the user's files do not describe a robot that can run.
    :raises DomainTakenError: another simulation has these names on this machine.
    """

    def __init__(self, arguments: ProgramArguments, stop_wanted: Callable[[], bool]) -> None:
        """Read the files and build the robot; no node exists yet."""
        self._stop_wanted = stop_wanted
        self._ros_args = arguments.ros_args
        self._status = 0
        self._dispatcher = Dispatcher()
        self._settings, self._model, self._warnings = robot_of(arguments)
        self._lock = lock_domain(
            self._ros_args, program='simulation', namespace=self._settings.namespace or '/'
        )
        simulation = self._settings.simulation
        self._clock = SimClock(
            simulation.timestep_ns,
            time.time_ns(),
            paused=simulation.paused,
            real_time_factor=simulation.real_time_factor,
        )
        self._simulation: Simulation = build_simulation(
            self._settings, self._model, clock=self._clock
        )
        self._faults = FaultInjector(self._simulation) if simulation.fault_injection else None
        self._manager: ControllerManager = build_manager(
            self._settings, self._model, self._faults or self._simulation
        )
        pace = simulation.pace
        self._loop = ControlLoop(
            self._simulation,
            FaultyControllers(self._manager, self._faults) if self._faults else self._manager,
            self._settings.controller_manager.update_rate,
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
        prioritize_process(self._settings.simulation.pace.priority)
        rclpy.init(
            args=['simulation', *self._ros_args], signal_handler_options=SignalHandlerOptions.NO
        )
        self._executor = SingleThreadedExecutor()
        self._control = ControlThread(self._loop)
        try:
            self._create_nodes()
            self._create_services()
            executor = ExecutorThread(self._executor, self._manager_node.get_logger())
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
            self._lock.release()
        return self._status

    def _create_nodes(self) -> None:
        """Create first what others must discover early: controllers, /clock, transforms."""
        namespace = self._settings.namespace or '/'
        self._manager_node = self._node(
            'controller_manager', namespace, allow_undeclared_parameters=True
        )
        self._registry = ControllerRegistry(
            self._manager,
            ControllerDescriptions(self._manager_node, self._settings),
            self._executor,
            self._dispatcher,
            namespace,
        )
        for controller in self._manager.controllers.values():
            self._registry.add(controller)
        self._simulation_node = self._node('simulation', '/', start_parameter_services=False)
        self._clock_publisher = Clock(self._simulation_node)
        self._events = EventLog(self._manager_node, self._manager, self._loop, self._registry)
        for text in (*self._warnings, *self._simulation.warnings):
            self._manager_node.get_logger().warning(text)
        RobotStatePublisher(
            self._node('robot_state_publisher', '/'), self._model, self._simulation
        ).follow(self._loop, self._dispatcher)
        self._loop.every(
            round(1e9 / self._settings.simulation.clock_rate),
            lambda time_ns: self._dispatcher.post(partial(self._publish, time_ns)),
        )

    def _create_services(self) -> None:
        """
        Create the rest: parameters, the manager's services, diagnostics.

        Not while the loop runs: each new endpoint holds the interpreter for milliseconds.
        """
        node = self._manager_node
        rate = self._settings.controller_manager.update_rate
        for side in self._registry.sides:
            side.declare_parameters()
        SettingsParameters(node, self._settings.controller_manager)
        if self._faults is not None:
            FaultParameters(node, self._faults)
        ControllerManagerQueries(node, self._manager, rate)
        ControllerManagerServices(node, self._manager, self._registry, self._dispatcher)
        SimulationStateServices(self._simulation_node, self._loop, self._dispatcher, self.stop)
        self._activity = Activity(node, self._manager)
        self._watch_domain = DomainWatch(node, self._refuse)
        self._clock_hint = ClockHint(self._clock, node.get_logger().warning)
        diagnostics = Diagnostics(node, self._manager, self._loop, self._faults)
        self._dispatcher.every(_WATCH_PERIOD, self._watch)
        self._dispatcher.every(_DIAGNOSTICS_PERIOD, diagnostics.publish)
        node.get_logger().info(
            f"simulation of '{self._model.name}' runs; controllers: "
            + ', '.join(f'{info.name} [{info.state}]' for info in self._manager.list_controllers())
        )

    def _publish(self, time_ns: int) -> None:
        self._clock_publisher.publish(time_ns)
        for side in self._registry.sides:
            side.publish(time_ns)
        self._events.drain()

    def _watch(self) -> None:
        if self._control.failed:
            self._fail(1, f'the control loop failed:\n{self._control.failure}')
        if self._clock.paused:
            self._clock_publisher.publish(self._clock.now_ns)
        self._events.drain()
        self._activity.publish_if_changed(self._clock.now_ns)
        self._watch_domain.look()
        self._clock_hint.look()

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
