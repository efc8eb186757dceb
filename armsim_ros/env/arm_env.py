# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm as an environment: reset, act, observe."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.control.hardware_interface import POSITION
from armsim_ros.control.manager.switching import Strictness
from armsim_ros.env.actions import ActionKind, Actions, KINDS, PositionCommands
from armsim_ros.env.gym_base import Env
from armsim_ros.env.observations import Observations
from armsim_ros.env.ranges import checked, drawn, Episode, merged, ranges_from
from armsim_ros.env.rendering import Renderer, View
from armsim_ros.errors import ConfigError, nearest, Problem, SimulationError
from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.physics.saved_state import SimulationState
from armsim_ros.stack import ArmSim

OPTIONS = ('objects', 'joints')


@dataclass(frozen=True, eq=False)
class EnvState:
    """The state of an environment; opaque, may be pickled."""

    episode: Episode
    simulation: SimulationState
    target: Vector
    steps: int
    random: Mapping[str, Any]


class ArmEnv(Env):
    """
    A robot in its world, moved by actions instead of controllers.

    A Gymnasium environment where Gymnasium is installed; it works without, too. Equal seeds and
    actions give equal bytes, see ``digest``. For a task, a subclass defines ``reward`` and
    ``terminated``. All poses are in the world.

    :param robot: a name, a folder, or what ``load_cell`` returned.
    :param action: ``position``, ``velocity`` or ``twist``; ``action_names`` lists the numbers.
    :param period: time of a step [s]; a whole number of control periods.
    :param group: whose tip is observed and moved by a twist; the first group where not given.
    :param twist: fastest linear [m/s] and angular [rad/s] velocity of a twist.
    :param randomize: what differs from episode to episode: ``objects``: name -> ``xyz``, ``rpy``,
        ``mass``, ``friction``, ``color``; ``joints``: name -> start. Each is (low, high).
    :param max_steps: after so many an episode is truncated; 0 is never.
    :param render_mode: ``rgb_array`` for pictures.
    :param view: words of ``View``, for pictures.
    :param world: a world's name or file in place of the robot's own.
    :param overrides: dotted path -> value over the robot's files.
    :raises ConfigError: the files, or these arguments, are wrong.
    """

    metadata: ClassVar[dict[str, Any]] = {'render_modes': ['rgb_array'], 'render_fps': 50}
    _target: Vector
    _steps: int

    def __init__(
        self,
        robot: str | Path | Cell = 'sunday',
        *,
        action: ActionKind = 'position',
        period: float = 0.02,
        group: str = '',
        twist: tuple[float, float] = (0.25, 1.0),
        randomize: Mapping[str, Any] | None = None,
        max_steps: int = 0,
        render_mode: str | None = None,
        view: Mapping[str, Any] | None = None,
        world: str | Path | None = None,
        overrides: Mapping[str, object] | None = None,
    ) -> None:
        if not isinstance(robot, Cell):
            robot = load_cell(str(robot), world=world, overrides=overrides)
        _check_words({'action': (action, KINDS),
                      'render_mode': (render_mode, (None, *self.metadata['render_modes']))})
        self.cell, self.render_mode, self.max_steps = robot, render_mode, max_steps
        settings, model = robot.settings, robot.model
        rate = settings.controller_manager.update_rate
        self._periods = round(period * rate)
        if self._periods < 1 or abs(self._periods - period * rate) > 1e-6:
            raise ConfigError(Problem(
                f'a step of {period:g} s does not fit the controllers', allowed='a whole number '
                f'of control periods of {1.0 / rate:g} s'))
        self._ranges = ranges_from(randomize or {}, settings.world, model)
        self._renderer = Renderer(checked(View, view or {}, 'view'))
        group = group or next(iter(model.semantic.groups), '')
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
        self._begin(Episode(settings.world, {}, 0))

    @property
    def sim(self) -> ArmSim:
        """The stack of this episode, to read, and to plan with; ``reset`` makes another."""
        return self._sim

    @property
    def action_names(self) -> tuple[str, ...]:
        """What each number of an action is."""
        return self._actions.names

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[dict[str, Vector], dict[str, Any]]:
        """
        Begin an episode; what differs from others is drawn from the ranges.

        :param seed: begins the random numbers anew.
        :param options: ``objects`` and ``joints`` as in ``randomize``, over it, for this episode;
            each may be a value, too.
        :returns: observation and info.
        :raises ConfigError: an option that there is not, or a value that cannot be.
        """
        super().reset(seed=seed)
        for word in options or {}:
            if word not in OPTIONS:
                raise ConfigError(Problem(f"reset has no option '{word}'",
                                          allowed=', '.join(OPTIONS),
                                          remedy=nearest(word, OPTIONS)))
        world = self.cell.settings.world
        ranges = merged(self._ranges, ranges_from(options or {}, world, self.cell.model))
        self._begin(drawn(ranges, world, self.np_random))
        return self._observations.read(self._sim.simulation), self._info()

    def step(
        self, action: Vector
    ) -> tuple[dict[str, Vector], float, bool, bool, dict[str, Any]]:
        """
        Do what an action requests for a period.

        :param action: as ``action_names`` has it; beyond the action space its bound is taken.
        :returns: observation, reward, terminated, truncated, info.
        :raises SimulationError: it is not an action, or the physics became unstable.
        """
        target, cups = self._actions.read(action, self._target)
        self._motion.suck(cups)
        self._motion.go(self._target, target, self._periods)
        self._target = target
        self._steps += 1
        observation = self._observations.read(self._sim.simulation)
        truncated = bool(self.max_steps) and self._steps >= self.max_steps
        return (observation, self.reward(observation), self.terminated(observation), truncated,
                self._info())

    def reward(self, observation: Mapping[str, Vector]) -> float:
        """Return the reward of a step; 0 by default."""
        return 0.0

    def terminated(self, observation: Mapping[str, Vector]) -> bool:
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
        return EnvState(self._episode, self._sim.simulation.save_state(), self._target.copy(),
                        self._steps, self.np_random.bit_generator.state)

    def restore_state(self, state: EnvState) -> None:
        """
        Be exactly what was saved, here or in another environment with the same arguments.

        :raises SimulationError: the world has other objects than it had then.
        """
        if state.episode != self._episode:
            self._begin(state.episode)
        self._sim.simulation.restore_state(state.simulation)
        self._target, self._steps = state.target.copy(), state.steps
        self.np_random.bit_generator.state = state.random

    def close(self) -> None:
        """Give back what pictures need."""
        self._renderer.close()

    def _begin(self, episode: Episode) -> None:
        settings = self.cell.settings
        start = {**settings.simulation.initial_positions, **episode.joints}
        settings = settings.model_copy(update={
            'world': episode.world,
            'simulation': settings.simulation.model_copy(update={'initial_positions': start}),
        })
        self._episode = episode
        cell = Cell(settings, self.cell.model, self.cell.robots)
        self._sim = sim = ArmSim(cell, seed=episode.seed)
        for manager in sim.managers.values():
            active = [name for name, controller in manager.controllers.items()
                      if controller.active and controller.required_command_interfaces]
            result = manager.switch(deactivate=active, strictness=Strictness.STRICT)
            if not result.ok:
                raise SimulationError(f'the controllers cannot be stopped: {result.message}')
        simulation = sim.simulation
        simulation.perform_command_mode_switch(
            {name: frozenset({POSITION}) for name in self.joints})
        self._motion = PositionCommands(simulation, self.joints, sim.loop.steps_per_update)
        self._target = simulation.state.position[
            [simulation.index[name] for name in self.joints]].copy()
        self._steps = 0

    def _info(self) -> dict[str, Any]:
        return {'time': self._sim.time, 'steps': self._steps}


def _check_words(words: Mapping[str, tuple[object, tuple[object, ...]]]) -> None:
    for name, (value, allowed) in words.items():
        if value not in allowed:
            raise ConfigError(Problem(f'{name}={value!r}', allowed=', '.join(map(str, allowed))))
