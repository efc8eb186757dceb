# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm as an environment: reset, act, observe."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
import copy
from pathlib import Path
from typing import Any

from gymnasium import Env
import numpy as np
from numpy.typing import ArrayLike, NDArray

from armsim_ros.arrays import Vector
from armsim_ros.control.hardware_interface import POSITION
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.env.actions import ActionKind, Actions, KINDS, Observations
from armsim_ros.env.motion import JointMotion, Motion
from armsim_ros.env.options import checked_choices, EnvState, own_options
from armsim_ros.env.ranges import drawn, Episode, Quantity, Ranges, ranges_from, stream
from armsim_ros.env.rendering import Renderer, View, view_from
from armsim_ros.env.variation import Pushes, Variation
from armsim_ros.errors import ConfigError, Problem, SimulationError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.assembly import watch
from armsim_ros.stack import ArmSim

#: Observations that get noise, with the stream of each.
_NOISY = ('joint_positions', 'joint_velocities', 'object_poses')


class ArmEnv(Env[Any, Any]):
    """
    A robot in its world, moved by actions instead of controllers.

    Equal seeds and actions give equal bytes, see ``digest``. For a task, a subclass defines
    ``reward`` and ``terminated``. All poses are in the world.

    :param robot: a name, a folder, or what ``load_cell`` returned.
    :param action: ``position``, ``velocity`` or ``twist``; ``action_names`` lists the numbers.
    :param period: time of a step [s]; a whole number of control periods.
    :param group: whose tip is observed and moved by a twist; the first group where not given.
    :param twist: fastest linear [m/s] and angular [rad/s] velocity of a twist.
    :param randomize: what differs from episode to episode, nested or by dotted path:
        ``objects.NAME.{xyz, rpy, mass, friction, color, size}``, ``joints.NAME`` (its start) and
        ``joints.NAME.{damping, friction, armature}``, ``gains``, ``gravity``, ``latency``,
        ``noise.{joint_positions, joint_velocities, object_poses}``, ``pushes.{force, interval}``.
        Each is (low, high), or a fixed value.
    :param end_on_stop: whether what would stop the arm ends an episode: speed, position, and
        collisions beyond the limits of ``hardware``; ``info['stop']`` has the cause.
    :param max_steps: after so many an episode is truncated; 0 is never.
    :param render_mode: ``rgb_array`` for pictures.
    :param view: arguments of ``View``, for pictures.
    :param world: a world's name or file in place of the robot's own.
    :param overrides: dotted path -> value over the robot's files.
    :raises ConfigError: the files, or these arguments, are wrong.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as in Gymnasium; each environment has its own
        'render_modes': ['rgb_array'], 'render_fps': 50}
    _target: Vector
    _steps: int
    _latency: int
    _waiting: deque[Vector]
    _noise: np.random.Generator

    def __init__(
        self, robot: str | Path | Cell = 'sunday', *, action: ActionKind = 'position',
        period: float = 0.02, group: str = '', twist: tuple[float, float] = (0.25, 1.0),
        randomize: Mapping[str, Any] | None = None, end_on_stop: bool = False, max_steps: int = 0,
        render_mode: str | None = None, view: Mapping[str, Any] | None = None,
        world: str | Path | None = None, overrides: Mapping[str, object] | None = None
    ) -> None:
        checked_choices({'action': (action, KINDS),
                         'render_mode': (render_mode, (None, *self.metadata['render_modes']))})
        if not isinstance(robot, Cell):
            robot = load_cell(str(robot), world=world, overrides=overrides)
        self.cell, self.render_mode, self.max_steps = robot, render_mode, max_steps
        self.period, self._end_on_stop = period, end_on_stop
        self._stop = ''
        settings, model = robot.settings, robot.model
        self._renderer = Renderer(view_from(view or {}))
        group = group or model.semantic.first_group
        tip = model.group(group).tips[0] if group else tuple(model.links)[-1]
        cups = tuple(settings.simulation.vacuum_grippers)
        placement = settings.simulation.placement
        self.joints: tuple[str, ...] = model.active_joints
        self.objects = tuple(
            name for name, settings_of in settings.world.objects.items()
            if settings_of.mass is not None)
        self._actions = Actions(
            action, KinematicModel(model), self.joints, group, tip,
            pose_matrix(placement.xyz, placement.rpy)[:3, :3], twist=twist, cups=cups,
            period=period)
        self._observations = Observations(self.joints, tip, self.objects, cups)
        self.action_space: Any = self._actions.space
        self.observation_space: Any = self._observations.space
        self.metadata = {**self.metadata, 'render_fps': round(1.0 / period)}
        self._build()
        self._known = {**self._variation.known(), **Pushes.KNOWN, **self.task_quantities()}
        self._pushes = Pushes(tip, period)
        self._ranges = ranges_from(randomize or {}, self._known, 'randomize')
        self._begin(Episode({}, 0))

    def _build(self) -> None:
        """Make the stack with all joints following positions of this environment."""
        rate = self.cell.settings.controller_manager.update_rate
        periods = round(self.period * rate)
        if periods < 1 or abs(periods - self.period * rate) > 1e-6:
            raise ConfigError(Problem(
                f'a step of {self.period:g} s does not fit the controllers', allowed='a whole '
                f'number of control periods of {1.0 / rate:g} s'))
        self._sim = sim = ArmSim(self.cell)
        for manager in sim.managers.values():
            active = [name for name, controller in manager.controllers.items()
                      if controller.active and controller.required_command_interfaces]
            result = manager.switch(deactivate=active, strictness=Strictness.STRICT)
            if not result.ok:
                raise SimulationError(f'the controllers cannot be stopped: {result.message}')
        sim.simulation.perform_command_mode_switch(
            {name: frozenset({POSITION}) for name in self.joints})
        if self._end_on_stop:
            for part in self.cell.robots:
                watch(part, sim.managers[part.name], sim.simulation, always=True)
        self.decorate(sim)
        steps = periods * sim.loop.steps_per_update
        self._motion: Motion = JointMotion(sim.simulation, self.joints, steps)
        self._places = np.array([sim.simulation.index[name] for name in self.joints])
        self._variation = Variation(sim, self.joints)

    def decorate(self, sim: ArmSim) -> None:
        """Add cameras, lights and marks to the stack of a task; nothing by default."""

    def task_quantities(self) -> Mapping[str, Quantity]:
        """Return what else a task draws: dotted path -> quantity; nothing by default."""
        return {}

    @property
    def sim(self) -> ArmSim:
        """The stack, to read, and to plan with; its planner begins anew with each episode."""
        return self._sim

    @property
    def action_names(self) -> tuple[str, ...]:
        """What each number of an action is."""
        return self._actions.names

    def move_by(self, motion: Motion) -> None:
        """Have something else move the arm, which shows in ``sim`` where that has led."""
        self._motion = motion

    def checked_action(self, action: ArrayLike) -> Vector:
        """
        Return an action as float64 numbers.

        :raises ValueError: it has the wrong length, or a number that is not finite; it is named.
        """
        return self._actions.checked(action)

    @property
    def episode(self) -> Episode:
        """What was drawn for this episode."""
        return self._episode

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """
        Begin an episode; what differs from others is drawn from the ranges.

        :param seed: begins the random numbers anew.
        :param options: values or ranges as in ``randomize``, over it, for this episode; keys that
            resemble none of them are ignored.
        :returns: observation and info.
        :raises ConfigError: a misspelled option, or a value that is not possible.
        """
        super().reset(seed=seed)
        given = own_options(options or {}, self._known)
        ranges = {**self._ranges, **ranges_from(given, self._known, 'options')}
        self._draw(ranges)
        values = {path: list(value) if isinstance(value, tuple) else value
                  for path, value in self._episode.values.items()}
        return self.observe(), {**self._info(), 'randomization': values}

    def _draw(self, ranges: Ranges) -> None:
        """Draw an episode and begin it."""
        self._begin(drawn(ranges, self.np_random))

    def step(self, action: Vector) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """
        Do what an action requests for a period.

        :param action: as ``action_names`` has it; beyond the action space its bound is taken.
        :returns: observation, reward, terminated, truncated, info.
        :raises ValueError: it has the wrong length, or a number that is not finite.
        :raises SimulationError: the physics became unstable.
        """
        return self._act(self._actions.checked(action))

    def _act(self, action: Vector) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Do what ``step`` does with a checked action, in units."""
        values: Vector | None = action
        if self._latency:
            self._waiting.append(action.copy())
            waited = len(self._waiting) > self._latency
            values = self._waiting.popleft() if waited else None
        if values is not None:
            self._target, cups = self._actions.read(values, self._target)
            self._motion.suck(cups)
        self._pushes.act(self._sim.simulation, self._steps)
        self._motion.go(self._target)
        self._steps += 1
        observation = self.observe()
        truncated = 0 < self.max_steps <= self._steps
        self._stop = self._stop_cause()
        terminated = self.terminated(observation) or bool(self._stop)
        return observation, self.reward(observation), terminated, truncated, self._info()

    def _stop_cause(self) -> str:
        """Return why an arm would stop, '' where none would, or where that does not count."""
        if not self._end_on_stop:
            return ''
        monitors = [manager.stops.monitor for manager in self._sim.managers.values()]
        causes = [monitor.check(self._sim.simulation.time_ns) for monitor in monitors
                  if monitor is not None]
        return next((str(cause) for cause in causes if cause is not None), '')

    def observe(self) -> Any:
        """Return the present observation."""
        return self._noisy(self._observations.read(self._sim.simulation))

    def reward(self, observation: Any) -> float:
        """Return the reward of a step; 0 by default."""
        return 0.0

    def terminated(self, observation: Any) -> bool:
        """Return whether the task has ended; never, by default."""
        return False

    def render(self) -> NDArray[np.uint8] | None:
        """
        Return a picture (height, width, 3), None without a render mode.

        :raises ResourceError: there is no OpenGL to draw with.
        """
        if self.render_mode is None:
            return None
        simulation = self._sim.simulation
        return self._renderer.draw(simulation.mujoco_model, simulation.mujoco_data)

    def digest(self) -> str:
        """Return a hash of the state of plant, drives and time."""
        return self._sim.digest()

    def save_state(self) -> EnvState:
        """Return all that the future depends on."""
        return EnvState(
            self._episode, self._sim.simulation.save_state(), self._target.copy(), self._steps,
            tuple(self._waiting),
            tuple(random.bit_generator.state for random in self._randoms),
            copy.deepcopy(self.task_state()))

    def restore_state(self, state: EnvState) -> None:
        """
        Be exactly what was saved, here or in another environment with the same arguments.

        :raises SimulationError: the world has other objects than it had then.
        """
        if state.episode != self._episode:
            self._begin(state.episode)
        self._sim.simulation.restore_state(state.simulation)
        self._target, self._steps = state.target.copy(), state.steps
        self._waiting = deque(state.waiting)
        for random, known in zip(self._randoms, state.random, strict=True):
            random.bit_generator.state = known
        vars(self).update(copy.deepcopy(dict(state.task)))

    def branch(
        self, state: EnvState, actions: Sequence[Sequence[Vector]]
    ) -> list[list[tuple[Any, float, bool, bool, dict[str, Any]]]]:
        """
        Return what several sequences of actions lead to from a saved state.

        The environment is where it was, afterwards.

        :param actions: (k, t, n), a sequence for each future.
        :returns: for each future what ``step`` returns, up to its end.
        """
        present, futures = self.save_state(), []
        for sequence in actions:
            self.restore_state(state)
            future: list[tuple[Any, float, bool, bool, dict[str, Any]]] = []
            for action in sequence:
                future.append(self.step(action))
                if future[-1][2] or future[-1][3]:
                    break
            futures.append(future)
        self.restore_state(present)
        return futures

    def task_state(self) -> Mapping[str, Any]:
        """Return the attributes that a task remembers of its episode; none by default."""
        return {}

    def close(self) -> None:
        """Give back what pictures need."""
        self._renderer.close()

    def _begin(self, episode: Episode) -> None:
        if self._sim.simulation.mujoco_model is not self._variation.model:
            self._build()  # the caller has edited the world of the last episode
        self._episode = episode
        self._variation.apply(episode)
        self._target = self._sim.simulation.state.position[self._places].copy()
        self._steps, self._stop = 0, ''
        self._latency = int(episode.get('latency', 0.0))
        self._waiting = deque()
        self._noise = stream(episode.seed, 'noise')
        self._pushes.begin(episode)
        self._deviations = {name: std for name in _NOISY
                            if (std := episode.get(f'noise.{name}', 0.0))}

    @property
    def _randoms(self) -> tuple[np.random.Generator, ...]:
        return self.np_random, self._noise, self._pushes.random

    def _noisy(self, observation: dict[str, Vector]) -> dict[str, Vector]:
        for name, std in self._deviations.items():
            if name in observation:
                values = observation[name]
                observation[name] = values + self._noise.normal(0.0, std, values.shape)
        return observation

    def _info(self) -> dict[str, Any]:
        stop = {'stop': self._stop} if self._end_on_stop else {}
        return {'time': self._sim.time, 'steps': self._steps, **stop}


__all__ = ['ArmEnv', 'View']
