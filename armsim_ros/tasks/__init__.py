# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Manipulation tasks as Gymnasium environments.

``gymnasium.make('armsim_ros.tasks:armsim/PickCube-v1')`` makes a task in any process.
"""

from gymnasium import register

from armsim_ros.tasks.base import TaskEnv
from armsim_ros.tasks.manipulation import PickCube, PlaceCube, PushCube, Reach, StackCubes

#: Part of the id after ``armsim/`` -> its class.
TASKS: dict[str, type[TaskEnv]] = {
    f'{task.__name__}-v1': task for task in (Reach, PushCube, PickCube, PlaceCube, StackCubes)}

for _name, _task in TASKS.items():
    register(
        f'armsim/{_name}', entry_point=f'{_task.__module__}:{_task.__name__}',
        vector_entry_point=f'armsim_ros.tasks.vectors:{_task.__name__}',
        max_episode_steps=_task.default_steps)

__all__ = ['TASKS', 'PickCube', 'PlaceCube', 'PushCube', 'Reach', 'StackCubes', 'TaskEnv']
