# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A task whose arm runs in a simulation of its own and is observed and moved over ROS alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
import json
import signal
import subprocess
import tempfile
import time
from typing import Any, cast, IO

import gymnasium
import numpy as np
from rcl_interfaces.srv import GetParameters
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from simulation_interfaces.srv import (
    GetEntitiesStates,
    LoadWorld,
    SetSimulationState,
    StepSimulation,
)
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import Empty, Trigger
import yaml

from armsim_ros.arrays import Vector
from armsim_ros.cli.environment import (
    BRINGUP_PID,
    child_environment,
    die_with_parent,
    program_command,
)
from armsim_ros.clients.client_node import ClientNode, JointStates
from armsim_ros.clients.controller_manager import ControllerManagerClient, ParameterClient
from armsim_ros.clients.simulation import SimulationClient
from armsim_ros.data.evaluate import MEASURED_AT
from armsim_ros.env.motion import Mirror
from armsim_ros.env.ranges import Episode
from armsim_ros.errors import ConfigError, ControllerError, Problem, SimulationError
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.tasks.base import TaskEnv

#: The forward controller of all joints that the evaluation loads.
CONTROLLER = 'policy'
_KIND = 'position_controllers/JointGroupPositionController'
#: Time for the simulation to start [s].
_START = 60.0
#: Time for commands to arrive.
_DELIVERED = Duration(seconds=10)
#: In real time: of commands within a step [Hz].
_RATE = 250
#: What an episode may differ in: of objects, and of what does not concern the running arm.
_OBJECTS = ('xyz', 'rpy', 'mass', 'friction', 'color')
_OWN = ('target', 'latency', 'noise')


@dataclass
class Timing:
    """
    How a run in real time went.

    :param latencies: from each observation to the command [s].
    :param late: number of commands that came a period or more after the observation.
    """

    latencies: list[float] = field(default_factory=list)
    late: int = 0


class RunningTaskArm:
    """
    Moves a running arm and shows a task what is measured of it; in place of ``JointMotion``.

    :param task: gets the measurements.
    :param client: a node in the domain of the simulation.
    :param namespace: of the arm, with a slash before it, or ''.
    :param lockstep: whether time advances with the steps of the task only.
    """

    def __init__(
        self, task: TaskEnv, client: ClientNode, namespace: str, *, lockstep: bool
    ) -> None:
        self.timing = Timing()
        self._task, self._client, self._namespace = task, client, namespace
        self._lockstep = lockstep
        self._simulation = SimulationClient(client)
        self._states = JointStates(
            client, f'{namespace}/joint_states', 'the simulation does not run')
        self._mirror = Mirror(task.sim.simulation, task.objects)
        self._cups = task.sim.simulation.vacuum_grippers
        self._places = [task.sim.simulation.index[name] for name in task.joints]
        self._filter = f'^({"|".join(task.objects)})$'
        #: Commands in a step: in lockstep the controllers run once in it.
        self._parts = 1 if lockstep else max(1, round(task.period * _RATE))
        self._last = np.zeros(len(task.joints))
        self._due = self._observed = 0.0
        self._begun_ns = self._stamp_ns = 0
        self._publisher = client.node.create_publisher(
            Float64MultiArray, f'{namespace}/{CONTROLLER}/commands', 1)
        self._take_over()
        client.connect({
            '/load_world': LoadWorld, '/get_entities_states': GetEntitiesStates,
            '/step_simulation': StepSimulation, '/simulation/sync': Trigger,
            '/set_simulation_state': SetSimulationState,
            f'{namespace}/{CONTROLLER}/get_parameters': GetParameters,
            **{f'{namespace}/{name}/{word}': Empty
               for name in self._cups for word in ('on', 'off')}})

    def begin(self, episode: Episode) -> None:
        """
        Put robot and world to the start of an episode.

        :raises ConfigError: the episode differs in what cannot be set over ROS.
        """
        text = yaml.safe_dump(_world_of(self._task, episode), sort_keys=False)
        self._simulation.ask('/load_world', LoadWorld, LoadWorld.Request(resource_string=text))
        self._last = self._task.sim.simulation.state.position[self._places].copy()
        if not self._lockstep:
            self._simulation.play()
        self._read()
        self._begun_ns, self._due = self._stamp_ns, self._observed

    @property
    def time(self) -> float:
        """Simulated time of the last measurement since the episode began [s]."""
        return 1e-9 * (self._stamp_ns - self._begun_ns)

    def suck(self, on: Sequence[bool]) -> None:
        """Switch the cups on or off."""
        for (name, cup), requested in zip(self._cups.items(), on, strict=True):
            if requested != cup.on:
                word = 'on' if requested else 'off'
                self._client.call(f'{self._namespace}/{name}/{word}', Empty)
                (cup.switch_on if requested else cup.switch_off)()

    def go(self, end: Vector) -> None:
        """Move from the last command to the next within a step (n,) [rad or m]."""
        if self._lockstep:
            self._publish(end)
            # The node that has answered has read what it had before the request.
            self._await(lambda: self._publisher.wait_for_all_acked(_DELIVERED))
            self._client.call(f'{self._namespace}/{CONTROLLER}/get_parameters', GetParameters)
            period_ns = round(self._task.period * 1e9)
            self._simulation.step(period_ns // self._task.sim.simulation.clock.step_ns)
        else:
            self._go_in_real_time(end)
        self._last = end.copy()
        self._read()

    def _go_in_real_time(self, end: Vector) -> None:
        now, period = time.monotonic(), self._task.period
        latency = now - self._observed
        self.timing.latencies.append(latency)
        if latency > period:
            self.timing.late += 1
            self._due = now
        for part in range(1, self._parts + 1):
            share = part / self._parts
            self._publish(self._last + share * (end - self._last))
            left = self._due + share * period - time.monotonic()
            if left > 0.0:
                time.sleep(left)
        self._due += period

    def _publish(self, positions: Vector) -> None:
        self._publisher.publish(Float64MultiArray(data=positions.tolist()))

    def _read(self) -> None:
        """Show the task joints and objects as they are measured now."""
        joints = self._measured()
        now_ns, objects = ns_from_time(joints.header.stamp), {}
        if self._task.objects:
            request = GetEntitiesStates.Request()
            request.filters.filter = self._filter
            answer = self._simulation.ask('/get_entities_states', GetEntitiesStates, request)
            objects = {name: _object(state) for name, state in
                       zip(answer.entities, answer.states, strict=True)}
            now_ns = ns_from_time(answer.states[0].header.stamp)
        positions, velocities, efforts = (
            dict(zip(joints.name, values, strict=False))
            for values in (joints.position, joints.velocity, joints.effort))
        # Where the joints are when the objects are measured, a few milliseconds later.
        passed = 1e-9 * (now_ns - ns_from_time(joints.header.stamp))
        positions = {name: at + passed * velocities.get(name, 0.0)
                     for name, at in positions.items()}
        self._mirror.show(positions, velocities, efforts, objects)
        self._stamp_ns = now_ns
        self._observed = time.monotonic()

    def _measured(self) -> JointState:
        """Return the joint states of now."""
        now_ns = int(self._client.call('/simulation/sync', Trigger).message)
        message = self._states.get()
        while ns_from_time(message.header.stamp) < now_ns:
            message = self._states.take()
        return cast(JointState, message)

    def _take_over(self) -> None:
        """Load and activate the forward controller in place of all that moves the robot."""
        manager = f'{self._namespace}/controller_manager'
        joints = ', '.join(self._task.joints)
        refused = ParameterClient(self._client, manager).set_all({
            f'{CONTROLLER}.type': _KIND,
            f'{CONTROLLER}.node_options_args': ['-p', f'joints:=[{joints}]']})
        controllers = ControllerManagerClient(self._client, manager)
        if any(refused.values()) or not controllers.load(CONTROLLER) or (
                not controllers.configure(CONTROLLER)):
            raise ControllerError(
                f"'{CONTROLLER}', a forward controller of {joints}, cannot be loaded"
                + ''.join(f'; {reason}' for reason in refused.values() if reason))
        active = [name for name, state in controllers.controllers().items()
                  if state.state == 'active' and state.claimed_interfaces]
        answer = controllers.switch(activate=[CONTROLLER], deactivate=active)
        if not answer.ok:
            raise ControllerError(answer.message)
        self._await(self._publisher.get_subscription_count)

    def _await(self, arrived: Callable[[], Any]) -> None:
        """Wait until commands arrive at the controller."""
        deadline = time.monotonic() + _DELIVERED.nanoseconds * 1e-9
        while not arrived():
            if time.monotonic() > deadline:
                raise ControllerError(f"'{CONTROLLER}' does not receive its commands")
            time.sleep(0.005)


class TaskOverRos(gymnasium.Wrapper[Any, Any, Any, Any]):
    """
    A task's environment that moves a running arm.

    :param env: of the task; its own physics only shows what is measured.
    :param arm: moves.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], arm: RunningTaskArm) -> None:
        super().__init__(env)
        self.arm = arm
        self._task = cast(TaskEnv, env.unwrapped)
        self._task.move_by(arm)

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, here and in the simulation."""
        _, info = self.env.reset(**arguments)
        self.arm.begin(self._task.episode)
        return self._task.observe(), info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Do what an action requests; ``info`` has the time of the measurements."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, {**info, MEASURED_AT: self.arm.time}


@contextmanager
def task_over_ros(
    env: gymnasium.Env[Any, Any], robot: str, *, lockstep: bool
) -> Iterator[TaskOverRos]:
    """
    Start the simulation of a task's robot and give the task's environment over ROS.

    :param env: what ``gymnasium.make`` returned for a task.
    :param robot: the robot of the task: its name or folder.
    :param lockstep: whether time advances with the steps of the task only.
    :raises SimulationError: the simulation does not start.
    :raises ConfigError: the task observes pictures.
    """
    task = cast(TaskEnv, env.unwrapped)
    if task.observes_pictures:
        raise ConfigError(Problem('over ROS a task does not observe pictures',
                                  allowed='state, environment_state_agent_pos'))
    with tempfile.TemporaryFile('w+') as output:
        process = subprocess.Popen(
            program_command('simulation', _arguments(task, robot, lockstep=lockstep)),
            stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            env=_environment(), start_new_session=True, preexec_fn=die_with_parent())
        try:
            namespace = task.cell.robots[0].settings.namespace
            with ClientNode(name='evaluate') as client:
                _await_start(client, process, output)
                yield TaskOverRos(env, RunningTaskArm(task, client, namespace, lockstep=lockstep))
        except AssertionError as error:  # of the client: no answer in time
            raise SimulationError(str(error)) from None
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _environment() -> dict[str, str]:
    """Return the environment of a program whose messages are for people."""
    environment = child_environment()
    del environment[BRINGUP_PID]
    return environment


def _await_start(client: ClientNode, process: subprocess.Popen[Any], output: IO[str]) -> None:
    """Wait until the simulation answers."""
    deadline = time.monotonic() + _START
    service = client.service(LoadWorld, '/load_world')
    while not service.wait_for_service(0.2):
        if process.poll() is not None or time.monotonic() > deadline:
            output.seek(0)
            raise SimulationError(
                'the simulation of the task does not start:\n' + output.read().rstrip())
    client.settle()


def _arguments(task: TaskEnv, robot: str, *, lockstep: bool) -> list[str]:
    """Return the arguments of ``armsim simulation`` for the robot of a task."""
    starts = task.cell.settings.simulation.initial_positions
    arguments = [
        f'robot:={robot}',
        'initial_positions:=' + ','.join(f'{name}={at!r}' for name, at in starts.items())]
    if lockstep:
        # Once a step, as the task itself moves the arm.
        overrides = {'controller_manager.update_rate': round(1.0 / task.period)}
        arguments += ['mode:=lockstep', f'overrides:={json.dumps(overrides)}']
    return arguments


def _world_of(task: TaskEnv, episode: Episode) -> dict[str, Any]:
    """Return the world of an episode as a world file has it."""
    world: dict[str, Any] = task.cell.settings.world.model_dump(mode='json')
    for path, value in episode.values.items():
        kind, _, rest = path.partition('.')
        name, _, quantity = rest.rpartition('.')
        if kind == 'objects' and quantity in _OBJECTS:
            item = world['objects'][name]
            alpha = item['color'][3:] if quantity == 'color' else []
            item[quantity] = [*value, *alpha] if isinstance(value, tuple) else value
        elif kind not in _OWN:
            raise ConfigError(Problem(
                f"'{path}' cannot be set over ROS", allowed=', '.join(
                    (*(f'objects.NAME.{each}' for each in _OBJECTS), *_OWN))))
    return world


def _object(state: Any) -> tuple[Vector, Vector]:
    """Return pose (7,) with w first and velocity (6,) of an entity's state."""
    at, turn, twist = state.pose.position, state.pose.orientation, state.twist
    return (np.array([at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z]),
            np.array([getattr(part, axis) for part in (twist.linear, twist.angular)
                      for axis in 'xyz']))

