# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Writes a folder from which LeRobot makes a task: ``python -m armsim_ros.tasks.hub DIR``.

LeRobot's EnvHub imports ``env.py`` of such a folder and calls ``make_env``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.errors import ArmsimError, ConfigError, nearest, Problem
from armsim_ros.resources import own_version
from armsim_ros.tasks import TASKS

_ENV = '''"""A task of armsim_ros for LeRobot's EnvHub."""

from functools import partial

import gymnasium

ARGUMENTS = {{'robot': '{robot}', 'obs_type': 'pixels_agent_pos'}}


def make_env(n_envs=1, use_async_envs=False, cfg=None):
    """Return a vector of environments, as LeRobot's own are."""
    vector = gymnasium.vector.AsyncVectorEnv if use_async_envs else gymnasium.vector.SyncVectorEnv
    options = {{'context': 'spawn'}} if use_async_envs else {{}}
    # The processes of an asynchronous vector cannot import this file.
    one = partial(gymnasium.make, 'armsim_ros.tasks:armsim/{task}', **ARGUMENTS)
    return vector([one] * n_envs, autoreset_mode=gymnasium.vector.AutoresetMode.SAME_STEP,
                  **options)
'''

_README = """# {task} of armsim_ros

A simulated arm ({robot}) whose task is: {description}

`pip install -r requirements.txt`; LeRobot makes it by `make_env` of `env.py`.
"""


def write_hub(folder: Path, task: str = 'PickCube-v1', robot: str = 'sunday') -> None:
    """
    Write ``env.py``, ``requirements.txt`` and ``README.md``.

    :param folder: is made; may have no other files.
    :param task: part of the id after ``armsim/``.
    :param robot: a name or a folder.
    :raises ConfigError: an unknown task, or a folder with other files.
    """
    if task not in TASKS:
        raise ConfigError(Problem(f"there is no task '{task}'", allowed=', '.join(TASKS),
                                  remedy=nearest(task, tuple(TASKS))))
    files = {
        'env.py': _ENV.format(task=task, robot=robot),
        'requirements.txt': f'armsim_ros[gym]=={own_version()}\n',
        'README.md': _README.format(task=task, robot=robot,
                                    description=TASKS[task].task_description),
    }
    folder.mkdir(parents=True, exist_ok=True)
    others = sorted(path.name for path in folder.iterdir()
                    if path.name not in files and not path.name.startswith('.'))
    if others:
        raise ConfigError(Problem(f"'{folder}' has other files: {', '.join(others)}",
                                  remedy='name a new folder'))
    for name, text in files.items():
        (folder / name).write_text(text)


def main(argv: Sequence[str] | None = None) -> int:
    """Write a folder; return 0, or 2 where an argument is wrong."""
    parser = argparse.ArgumentParser(
        prog='python -m armsim_ros.tasks.hub',
        description="Write a folder from which LeRobot's EnvHub makes a task.")
    parser.add_argument('folder', type=Path, metavar='DIR')
    parser.add_argument('--task', default='PickCube-v1', help='%(default)s')
    parser.add_argument('--robot', default='sunday', help='its name or folder (%(default)s)')
    options = parser.parse_args(argv)
    try:
        write_hub(options.folder, options.task, options.robot)
    except ArmsimError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == '__main__':
    sys.exit(main())
