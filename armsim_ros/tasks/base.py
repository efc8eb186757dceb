# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What all tasks share: observations, scaled actions, success, pictures."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
import math
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector
from armsim_ros.env.actions import ActionKind
from armsim_ros.env.arm_env import ArmEnv
from armsim_ros.env.options import checked_choices
from armsim_ros.env.ranges import drawn, Episode, Quantity, Ranges
from armsim_ros.env.rendering import Renderer, view_from
from armsim_ros.errors import ConfigError, Problem
from armsim_ros.model.cell import Cell
from armsim_ros.model.cell_loading import load_cell
from armsim_ros.stack import ArmSim
from armsim_ros.tasks.expert import Goal, Steering
from armsim_ros.tasks.hand import Hand, HandModel
from armsim_ros.tasks.task_observations import OBS_TYPES, ObsType, TaskObservations
from armsim_ros.tasks.workspace import (
    CAMERAS,
    CUBE,
    decorate,
    LARGEST_PICTURE,
    TARGET,
    task_cell,
    Workspace,
    workspace_of,
)

Color = tuple[float, float, float]
#: A task is done when its condition held in so many steps in a row.
STEPS_OF_SUCCESS = 5
#: What moves slower than this rests [m/s].
REST = 0.05
#: So often a start is drawn again that is solved already, or whose objects overlap.
_MOST_DRAWS = 200
_PICTURE = 480


class TaskEnv(ArmEnv):
    """
    A task for an arm with a suction cup or a gripper.

    An action is scaled to -1..1; ``to_units`` returns what ``ArmEnv`` takes. ``info`` has
    ``is_success``, which ends the episode, and ``target`` where there is one.

    :param robot: a name, a folder, or what ``load_cell`` returned.
    :param action: ``position``, ``velocity`` or ``twist``, see ``ArmEnv``.
    :param obs_type: ``state``, ``environment_state_agent_pos``, ``pixels`` or
        ``pixels_agent_pos``.
    :param cameras: those whose pictures are observed.
    :param image_size: height and width of these [pixels].
    :param period: time of a step [s].
    :param randomize: ``default``, ``none``, or ranges over the default, see ``ArmEnv``; also
        ``target.xyz``, ``camera.NAME.{xyz, rpy, focal}`` and ``light.{xyz, color}``.
    :param reward_type: ``sparse``: 1 in success, else 0; ``dense``: 1 in success, else
        between -1 and 0, growing as the remaining distance shrinks.
    :param render_mode: ``rgb_array`` for pictures.
    :param max_episode_steps: after so many the environment itself truncates the episode; 0 leaves
        that to the wrapper of ``gymnasium.make``.
    :param normalize_actions: whether actions are scaled to -1..1.
    :raises ConfigError: the files, or these arguments, are wrong.
    """

    task: ClassVar[str] = ''
    task_description: ClassVar[str] = ''
    default_steps: ClassVar[int] = 150
    cubes: ClassVar[tuple[tuple[str, Color], ...]] = (('cube', (0.8, 0.15, 0.1)),)
    mark: ClassVar[str] = ''

    def __init__(
        self, robot: str | Path | Cell = 'sunday', *, action: ActionKind = 'position',
        obs_type: ObsType = 'state', cameras: Sequence[str] = ('front',),
        image_size: tuple[int, int] = (96, 96), period: float = 0.05,
        randomize: Literal['default', 'none'] | Mapping[str, Any] = 'default',
        reward_type: Literal['sparse', 'dense'] = 'sparse', render_mode: str | None = None,
        max_episode_steps: int = 0, normalize_actions: bool = True
    ) -> None:
        checked_choices({
            'obs_type': (obs_type, OBS_TYPES), 'reward_type': (reward_type, ('sparse', 'dense')),
            **{f'cameras[{i}]': (name, tuple(CAMERAS)) for i, name in enumerate(cameras)}})
        height, width = image_size
        if not (0 < height <= LARGEST_PICTURE and 0 < width <= LARGEST_PICTURE):
            raise ConfigError(Problem(f'image_size={(height, width)}',
                                      allowed=f'1 to {LARGEST_PICTURE} pixels'))
        cell = robot if isinstance(robot, Cell) else load_cell(str(robot))
        self.place: Workspace = workspace_of(cell)
        self._hand_model = HandModel.of(cell)
        self._streak, self._dense = 0, reward_type == 'dense'
        self._hand: Hand | None = None
        ranges = randomize
        if isinstance(ranges, str):
            checked_choices({'randomize': (ranges, ('default', 'none'))})
            ranges = self.default_ranges() if ranges == 'default' else self.fixed_start()
        else:
            ranges = {**self.default_ranges(), **ranges}
        super().__init__(
            task_cell(cell, self.place, self.cubes), action=action, period=period,
            randomize=ranges, max_steps=max_episode_steps, render_mode=render_mode)
        self._max_episode_steps = max_episode_steps or self.default_steps
        self._scale(normalize_actions)
        self._pictures = Renderer(view_from({'height': height, 'width': width}), tuple(cameras))
        self._film = Renderer(view_from({'height': _PICTURE, 'width': _PICTURE}), ('front',))
        self._task_observations = TaskObservations(
            obs_type, self._actions, self.joints, self._hand_model, self.objects,
            bool(self.mark), tuple(cameras), (height, width))
        self.observation_space = self._task_observations.space
        self._steering = Steering(self._actions, period)

    @abstractmethod
    def default_ranges(self) -> dict[str, Any]:
        """Return what differs between episodes by default: dotted path -> range."""

    @abstractmethod
    def solved(self) -> bool:
        """Return whether the condition of success holds now."""

    @abstractmethod
    def remaining(self) -> float:
        """Return what is left to do, in metres; 0 when solved."""

    @abstractmethod
    def goal(self) -> Goal:
        """Return where the expert moves the hand next, from the state alone."""

    def fixed_start(self) -> dict[str, Any]:
        """Return the middle of the ranges that place objects and target."""
        return {path: np.mean(span, axis=0).tolist()
                for path, span in self.default_ranges().items() if path.endswith('xyz')}

    @property
    def hand(self) -> Hand:
        """What grasps."""
        assert self._hand is not None
        return self._hand

    @property
    def state_names(self) -> tuple[str, ...]:
        """What each number of ``agent_pos`` is."""
        return self._task_observations.state_names

    @property
    def environment_state_names(self) -> tuple[str, ...]:
        """What each number of ``environment_state`` is."""
        return self._task_observations.environment_names

    @property
    def observes_pictures(self) -> bool:
        """Whether pictures are observed."""
        return self._task_observations.pictures

    @property
    def target(self) -> Vector:
        """Where the target is (3,) [m]."""
        position: Vector = self._sim.simulation.mujoco_model.site(TARGET).pos
        return position

    @property
    def hand_yaw(self) -> float:
        """How the hand is turned about the vertical [rad], for what it grasps from two sides."""
        axis = int(np.argmax(np.abs(self._hand_model.offset)))
        side = self.hand.rotation[:, (axis + 1) % 3]
        return math.atan2(side[1], side[0])

    def to_units(self, action: Vector) -> Vector:
        """Return an action in the units of ``ArmEnv``."""
        units: Vector = self._middle + self._half * np.asarray(action, dtype=np.float64)
        return units

    @property
    def commanded(self) -> dict[str, float]:
        """Joint -> its last command [rad or m]."""
        return dict(zip(self.joints, self._target.tolist(), strict=True))

    def command_of(self, joints: Mapping[str, float], level: float) -> Vector:
        """
        Return the action, of kind ``position``, for joints of the arm and the hand.

        :param joints: joint -> position [rad or m]; the others stay where they are commanded.
        :param level: 1 to open the gripper or switch the cup on, 0 to close it or switch it off.
        """
        hand = self._hand_model
        goals = {**self.commanded, **joints}
        if hand.joint:
            goals[hand.joint] = hand.closed + level * (hand.open - hand.closed)
        units = [goals[name] for name in self.joints] + ([level] if hand.cup else [])
        action: Vector = (np.array(units) - self._middle) / self._half
        return action

    def command_by(
        self, way: Sequence[float], level: float, turn: Sequence[float] = (0.0, 0.0, 0.0)
    ) -> Vector:
        """
        Return the action, of kind ``position``, that moves and turns the tip.

        :param way: (3,) in world axes, within a step [m].
        :param level: as for ``command_of``.
        :param turn: (3,) about world axes [rad].
        """
        twist = np.array([*way, *turn]) / self.period
        others = self._target[self._actions.others]
        goals = self._actions.towards(twist, others, self._target)
        return self.command_of(dict(zip(self.joints, goals.tolist(), strict=True)), level)

    def command_in(self, action: Vector) -> tuple[dict[str, float], float]:
        """Return joints of the arm and level of the hand in an action, as in ``command_of``."""
        hand, units = self._hand_model, self.to_units(action)
        goals = dict(zip(self.joints, units.tolist(), strict=False))
        if hand.cup:
            return goals, float(units[-1])
        level = (goals.pop(hand.joint) - hand.closed) / (hand.open - hand.closed)
        return goals, level

    def expert(self) -> NDArray[np.float32]:
        """Return the next action of a scripted expert, from the state alone."""
        units = self._steering.action(self.hand, self.goal(), self._target, self._sim)
        action = (units - self._middle) / self._half
        clipped: NDArray[np.float32] = np.clip(
            action, self.action_space.low, self.action_space.high).astype(np.float32)
        return clipped

    def decorate(self, sim: ArmSim) -> None:
        """Add cameras, light and mark."""
        sim.simulation.decorate(lambda spec: decorate(spec, self.place, self.mark))

    def task_quantities(self) -> Mapping[str, Quantity]:
        """Return the target's position."""
        return {'target.xyz': Quantity(3)} if self.mark else {}

    def task_state(self) -> Mapping[str, Any]:
        """Return the attributes that a task remembers of its episode."""
        return {'_streak': self._streak}

    def step(self, action: Vector) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """
        Do what an action requests for a period; success ends the episode.

        :raises ValueError: it has the wrong length, or a number that is not finite.
        """
        values = self._actions.checked(action)
        if self._normalized:
            values = np.minimum(np.maximum(values, -1.0), 1.0)
        return self._act(self._middle + self._half * values)

    def observe(self) -> Any:
        """Return the present observation, and note whether the condition of success holds."""
        now = self._observations.read(self._sim.simulation)
        if self._steps:
            self._streak = self._streak + 1 if self.solved() else 0
        kind, pictures = self._task_observations, None
        if kind.pictures:
            simulation = self._sim.simulation
            pictures = self._pictures.draw_all(simulation.mujoco_model, simulation.mujoco_data)
        return kind.compose(self._noisy(now), self.hand.level,
                            self.target if self.mark else None, pictures)

    def reward(self, observation: Any) -> float:
        """Return 1 in success; else 0, or how much is done."""
        if self._dense:
            return 1.0 if self.is_success else -math.tanh(5.0 * self.remaining())
        return float(self.is_success)

    def terminated(self, observation: Any) -> bool:
        """Return whether the task is done."""
        return self.is_success

    @property
    def is_success(self) -> bool:
        """Whether the condition of success held long enough."""
        return self._streak >= STEPS_OF_SUCCESS

    def draw_pictures(self) -> dict[str, NDArray[np.uint8]]:
        """Return camera -> what it sees now (height, width, 3)."""
        simulation = self._sim.simulation
        return self._pictures.draw_all(simulation.mujoco_model, simulation.mujoco_data)

    def render(self) -> NDArray[np.uint8] | None:
        """Return the picture of the front camera (480, 480, 3), None without a render mode."""
        if self.render_mode is None:
            return None
        simulation = self._sim.simulation
        return self._film.draw_all(simulation.mujoco_model, simulation.mujoco_data)['front']

    def close(self) -> None:
        """Give back what pictures need."""
        for renderer in (self._pictures, self._film):
            renderer.close()
        super().close()

    def _draw(self, ranges: Ranges) -> None:
        for _ in range(_MOST_DRAWS):
            self._begin(drawn(ranges, self.np_random))
            if not self.solved() and self.is_possible():
                return
        raise ConfigError(Problem(
            f'no start of {self.task} was found in {_MOST_DRAWS} draws in which objects are '
            'apart and the task is not done yet', remedy='choose wider ranges'))

    def is_possible(self) -> bool:
        """Return whether an episode can start like this: objects are apart, by default."""
        spots = [self.item_xyz(name) for name, _ in self.cubes]
        return all(math.dist(first[:2], second[:2]) > 1.6 * CUBE
                   for i, first in enumerate(spots) for second in spots[:i])

    def item_xyz(self, name: str) -> Vector:
        """Return where an object is (3,) [m]."""
        start = self._item(name)[0]
        position: Vector = self._sim.simulation.mujoco_data.qpos[start:start + 3]
        return position

    def item_quat(self, name: str) -> Vector:
        """Return how an object is turned (4,), wxyz."""
        start = self._item(name)[0]
        quaternion: Vector = self._sim.simulation.mujoco_data.qpos[start + 3:start + 7]
        return quaternion

    def item_speed(self, name: str) -> float:
        """Return how fast an object moves [m/s]."""
        start = self._item(name)[1]
        return float(np.linalg.norm(self._sim.simulation.mujoco_data.qvel[start:start + 3]))

    def rests(self, name: str) -> bool:
        """Return whether an object is at rest and not held."""
        return self.item_speed(name) < REST and not self.hand.holds(name)

    def _item(self, name: str) -> tuple[int, int]:
        return self._items[name]

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        if self._hand is None or self._hand.sim is not self._sim:
            self._hand = Hand(self._sim, self._hand_model)
            model = self._sim.simulation.mujoco_model
            joints = {name: model.joint(f'object/{name}') for name, _ in self.cubes}
            self._items = {name: (int(joint.qposadr[0]), int(joint.dofadr[0]))
                           for name, joint in joints.items()}
        self._streak = 0
        if 'target.xyz' in episode.values:
            self._sim.simulation.mujoco_model.site(TARGET).pos[:] = episode.values['target.xyz']
            data = self._sim.simulation.mujoco_data
            data.site(TARGET).xpos[:] = episode.values['target.xyz']

    def _scale(self, normalize: bool) -> None:
        """Set scale and space of actions."""
        from gymnasium.spaces import Box

        low, high = self._actions.low, self._actions.high
        count = len(low)
        self._normalized = normalize
        if normalize:
            self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
            self.action_space = Box(-1.0, 1.0, (count,), np.float32)
        else:
            self._middle, self._half = np.zeros(count), np.ones(count)

    def _info(self) -> dict[str, Any]:
        info = {**super()._info(), 'is_success': self.is_success}
        if self.mark:
            info['target'] = self.target.copy()
        return info
