# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Steps, resets, vectors, pictures of tasks beside bare MuJoCo with the same model; memory.

A ratio is a median of the processor time of ours by that of the peer, which take turns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from multiprocessing import active_children
import os
from pathlib import Path
from statistics import median
import time
from typing import Any

import gymnasium
import numpy as np

from armsim_ros.tasks import PickCube
from benchmarks.options import Options
from benchmarks.tables import machine_load, publish, Table

HEAD = ('what', 'ours us', 'bare us', 'ratio', 'goal')
ROUNDS, STEPS = 15, 40
ROBOTS = ('sunday', 'panda')


def main(options: Options) -> None:
    """Print the table; write it where ``--report`` says."""
    rows = [row for robot in ROBOTS for row in (*_steps(robot), *_resets(robot))]
    rows += [_pictures(), *_vectors()]
    publish(options.report, 'learning', Table('Tasks beside bare MuJoCo', HEAD, rows),
            _memory(), machine_load())


def _steps(robot: str) -> list[tuple[str, ...]]:
    import mujoco

    rows = []
    for action, goal in (('position', '1.5'), ('twist', '2')):
        env: Any = _task(robot, action=action)
        env.reset(seed=0)
        random = np.random.default_rng(0)
        actions = _wandering(env, random)
        model, data = env.sim.simulation.mujoco_model, env.sim.simulation.mujoco_data
        copy, count, pairs = mujoco.MjData(model), _physics_steps(env), []
        whole = int(mujoco.mjtState.mjSTATE_INTEGRATION)
        states = np.empty((STEPS, mujoco.mj_stateSize(model, whole)))
        for begin in range(0, ROUNDS * STEPS, STEPS):
            mujoco.mj_copyData(copy, model, data)
            ours = bare = 0.0
            for each, state in zip(actions[begin:begin + STEPS], states, strict=True):
                mujoco.mj_getState(model, data, state, whole)
                ours += _cost(env.step, (each,))
            # From the same states: an arm at rest would cost the peer less. Not in between:
            # each side would find the other's data in its caches.
            for state in states:
                mujoco.mj_setState(model, copy, state, whole)
                bare += _cost(partial(mujoco.mj_step, model, copy), (count,))
            pairs.append((ours / STEPS, bare / STEPS))
        rows.append(_row(f'{robot}: step, {action}', pairs, f'<= {goal}'))
        env.close()
    return rows


def _resets(robot: str) -> list[tuple[str, ...]]:
    heavy = {'objects.cube.mass': (0.05, 0.15), 'objects.cube.friction': (0.5, 1.0),
             'objects.cube.color': ((0, 0, 0), (1, 1, 1))}
    rows = []
    for title, randomize, goal in (('no randomisation', 'none', '5'),
                                   ('masses, friction, colours, poses', heavy, '10')):
        env: Any = _task(robot, randomize=randomize)
        env.reset(seed=0)
        bare = _bare(env)
        pairs = [(_cost(partial(_reset, env), range(STEPS)),
                  _cost(bare, range(STEPS))) for _ in range(ROUNDS)]
        rows.append(_row(f'{robot}: reset, {title}', pairs, f'<= {goal}'))
        env.close()
    return rows


def _task(robot: str, **arguments: Any) -> Any:
    return PickCube(robot, **arguments)


def _reset(env: Any, seed: int) -> None:
    env.reset(seed=seed)


def _pictures() -> tuple[str, ...]:
    import mujoco

    env: Any = PickCube('sunday', obs_type='pixels')
    env.reset(seed=0)
    model, data = env.sim.simulation.mujoco_model, env.sim.simulation.mujoco_data
    renderer = mujoco.Renderer(model, 96, 96)

    def bare(_: int) -> None:
        renderer.update_scene(data, 'front')
        renderer.render()

    pairs = [(_cost(lambda _: env.observe(), range(STEPS)), _cost(bare, range(STEPS)))
             for _ in range(ROUNDS)]
    renderer.close()
    env.close()
    return _row('sunday: observed picture 96 x 96', pairs, '<= 1.25')


def _vectors() -> list[tuple[str, ...]]:
    """Return steps per second of a vector beside those of one environment and of a rollout."""
    import mujoco
    import mujoco.rollout

    cores = len(os.sched_getaffinity(0))
    count = 4 * cores
    single: Any = PickCube('sunday')
    single.reset(seed=0)
    steps = 100
    actions = _wandering(single, np.random.default_rng(0))[:steps]
    one = _wall(single.step, actions)
    vector = gymnasium.make_vec('armsim_ros.tasks:armsim/PickCube-v1', num_envs=count,
                                vectorization_mode='vector_entry_point')
    vector.reset(seed=0)
    many = _wall(vector.step, [np.stack([action] * count) for action in actions]) / count
    vector.close()
    model, data = single.sim.simulation.mujoco_model, single.sim.simulation.mujoco_data
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    control = np.tile(data.ctrl, (count, steps * _physics_steps(single), 1))
    datas = [mujoco.MjData(model) for _ in range(cores)]
    begin = time.perf_counter()
    mujoco.rollout.rollout(model, datas, np.tile(state, (count, 1)), control)
    bare = (time.perf_counter() - begin) / (count * steps)
    single.close()
    rows = [(f'{count} environments, per core', many * cores, one, '<= 1.25'),
            (f'{count} environments by mujoco.rollout', many, bare, '<= 2')]
    return [(title, f'{1e6 * ours:.0f}', f'{1e6 * peer:.0f}', f'{ours / peer:.2f}', goal)
            for title, ours, peer, goal in rows]


def _memory() -> str:
    """Return by how much the memory of all workers grows with an environment."""
    # Of the own vector's environments, those of the first processor are in this process.
    elsewhere = 1.0 - 1.0 / len(os.sched_getaffinity(0))
    own, processes = (
        (_memory_of(mode, many) - _memory_of(mode, few)) / (1024 * share * (many - few))
        for mode, few, many, share in (
            ('vector_entry_point', 4, 20, elsewhere), ('async', 2, 4, 1.0)))
    return (f'One more environment takes {own:.1f} MB in the own vector (goal: 20) and '
            f'{processes:.0f} MB in an AsyncVectorEnv (goal: 150).')


def _memory_of(mode: str, count: int) -> int:
    """Return the memory of the workers of a vector, shared pages by their share [KiB]."""
    more: dict[str, Any] = {'vector_kwargs': {'context': 'spawn'}} if mode == 'async' else {}
    vector = gymnasium.make_vec('armsim_ros.tasks:armsim/PickCube-v1', num_envs=count,
                                vectorization_mode=mode, **more)
    vector.reset(seed=0)
    vector.step(np.zeros(vector.action_space.shape))
    texts = [Path(f'/proc/{child.pid}/smaps_rollup').read_text() for child in active_children()]
    vector.close()
    return sum(int(line.split()[1]) for text in texts for line in text.splitlines()
               if line.startswith('Pss:'))


def _wandering(env: Any, random: np.random.Generator) -> list[Any]:
    """Return actions that wander as a policy's do; the cup stays off, the fingers open."""
    if env.action_space.shape[0] != len(env.joints) + bool(env.hand.model.cup):
        actions = [0.3 * env.action_space.high * random.uniform(-1.0, 1.0, env.action_space.shape)
                   for _ in range(ROUNDS * STEPS)]
        for action in actions:
            action[-1] = -1.0 if env.hand.model.cup else 1.0
        return actions
    target, found = env._target.copy(), []
    for _ in range(ROUNDS * STEPS):
        target = np.clip(target + random.uniform(-0.02, 0.02, len(target)),
                         env._target - 0.1, env._target + 0.1)
        units = np.append(target, 0.0) if env.hand.model.cup else target
        found.append((units - env._middle) / env._half)
    return found


def _physics_steps(env: Any) -> int:
    timestep: float = env.sim.simulation.mujoco_model.opt.timestep
    period: float = env.period
    return round(period / timestep)


def _bare(env: Any) -> Callable[[Any], None]:
    """Return what does a period of bare physics from the present state."""
    import mujoco

    model, data = env.sim.simulation.mujoco_model, env.sim.simulation.mujoco_data
    copy, count = mujoco.MjData(model), _physics_steps(env)
    mujoco.mj_copyData(copy, model, data)

    def step(_: Any) -> None:
        mujoco.mj_step(model, copy, count)

    return step


def _cost(function: Callable[[Any], object], arguments: Sequence[Any]) -> float:
    """Return the processor time of a call [s]."""
    begin = time.process_time()
    for argument in arguments:
        function(argument)
    return (time.process_time() - begin) / len(arguments)


def _wall(function: Callable[[Any], object], arguments: Sequence[Any]) -> float:
    begin = time.perf_counter()
    for argument in arguments:
        function(argument)
    return (time.perf_counter() - begin) / len(arguments)


def _row(title: str, pairs: Sequence[tuple[float, float]], goal: str) -> tuple[str, ...]:
    ours, bare = (median(pair[i] for pair in pairs) for i in (0, 1))
    ratio = median(first / second for first, second in pairs)
    return title, f'{1e6 * ours:.0f}', f'{1e6 * bare:.0f}', f'{ratio:.2f}', goal
