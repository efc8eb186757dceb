# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The folder for LeRobot's EnvHub."""

import runpy

import pytest

from armsim_ros.tasks.hub import main


@pytest.mark.parametrize('parallel', [False, True])
def test_the_folder_makes_a_vector_of_the_task(tmp_path, parallel):
    """``make_env`` of its ``env.py`` gives environments with pictures and joints."""
    assert main([str(tmp_path / 'hub'), '--task', 'Reach-v1']) == 0
    assert main([str(tmp_path / 'hub'), '--task', 'Reach-v1']) == 0
    envs = runpy.run_path(str(tmp_path / 'hub/env.py'))['make_env'](
        n_envs=2, use_async_envs=parallel)
    observation, info = envs.reset(seed=[0, 1])
    envs.close()
    assert observation['pixels']['front'].shape == (2, 96, 96, 3)
    assert observation['agent_pos'].shape[0] == 2
    assert not info['is_success'].any()


@pytest.mark.parametrize(('arguments', 'words'), [
    (['--task', 'PickCub-v1'], "did you mean 'PickCube-v1'"), ([], 'notes.txt')])
def test_what_is_refused(tmp_path, capsys, arguments, words):
    """An unknown task, and a folder with other files; nothing is written."""
    (tmp_path / 'notes.txt').touch()
    assert main([str(tmp_path), *arguments]) == 2
    assert words in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ['notes.txt']
