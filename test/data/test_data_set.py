# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Data sets in LeRobot's layout: content, interruptions, errors."""

from functools import cache
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import numpy as np
from pyarrow import parquet
import pytest

from armsim_ros.cli.main import main
from armsim_ros.data import collect, DataSet, EpisodeData, Feature, Plan, replay
from armsim_ros.data.episodes import EpisodeRunner, made, PolicyError, Source
from armsim_ros.data.features import picture_stats, stats_of, together
from armsim_ros.data.video import decoded, encoded
from armsim_ros.errors import ConfigError

SOURCE = Source('armsim/Reach-v1', {'obs_type': 'environment_state_agent_pos'})
FEATURES = {'observation.state': Feature('float32', (2,), ('a', 'b')),
            'observation.images.front': Feature('video', (16, 16, 3))}


@cache
def episode(number, length=5):
    """Return a small episode."""
    pictures = [np.full((16, 16, 3), 10 * number + frame, np.uint8) for frame in range(length)]
    return EpisodeData(
        {'observation.state': np.full((length, 2), number, np.float32)},
        {'observation.images.front': encoded(pictures, 20)},
        {'observation.images.front': picture_stats(pictures)}, 'Do it.',
        {'seed': number, 'success': True})


def opened(folder):
    """Return the small set in a folder."""
    return DataSet(folder, FEATURES, 20, 'bot', {'policy': 'expert'})


def consistent(folder, count):
    """Assert that a reader finds so many episodes: what info.json counts is there."""
    info = json.loads((folder / 'meta/info.json').read_text())
    assert info['total_episodes'] == count
    rows = parquet.read_table(folder / 'data', partitioning=None).to_pylist()
    table = parquet.read_table(folder / 'meta/episodes', partitioning=None).to_pylist()
    assert len(rows) >= info['total_frames']
    for number in range(count):
        row = table[number]
        assert row['episode_index'] == number
        part = rows[row['dataset_from_index']:row['dataset_to_index']]
        assert {frame['episode_index'] for frame in part} == {number}
        path = info['video_path'].format(
            video_key='observation.images.front',
            chunk_index=row['videos/observation.images.front/chunk_index'],
            file_index=row['videos/observation.images.front/file_index'])
        assert len(decoded((folder / path).read_bytes())) == row['length']


def files(folder):
    """Return path -> content."""
    return {str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob('*')) if path.is_file()}


def test_columns_and_counts_are_what_info_says(tmp_path):
    """Types, shapes, counters, tasks, splits and statistics agree."""
    data = opened(tmp_path / 'set')
    for number in range(3):
        data.add(episode(number))
    consistent(tmp_path / 'set', 3)
    info = json.loads((tmp_path / 'set/meta/info.json').read_text())
    assert (info['codebase_version'], info['total_frames'], info['splits']) == (
        'v3.0', 15, {'train': '0:3'})
    table = parquet.read_table(tmp_path / 'set/data/chunk-000/file-000.parquet')
    assert set(table.column_names) == {
        name for name, feature in info['features'].items() if feature['dtype'] != 'video'}
    assert table['index'].to_pylist() == list(range(15))
    np.testing.assert_allclose(
        table['timestamp'].to_pylist(), [k / 20 for k in range(5)] * 3, atol=1e-6)
    stats = json.loads((tmp_path / 'set/meta/stats.json').read_text())
    assert stats['observation.state']['max'] == [2.0, 2.0]
    assert np.shape(stats['observation.images.front']['q50']) == (3, 1, 1)
    tasks = parquet.read_table(tmp_path / 'set/meta/tasks.parquet').to_pylist()
    assert tasks == [{'task_index': 0, 'task': 'Do it.'}]


@pytest.mark.parametrize('last', range(1, 7))
def test_every_moment_leaves_a_readable_set(tmp_path, monkeypatch, last):
    """Wherever the third episode is cut off, two are there; going on gives the same bytes."""
    whole, cut = opened(tmp_path / 'whole'), opened(tmp_path / 'cut')
    for number in range(3):
        whole.add(episode(number))
    for number in range(2):
        cut.add(episode(number))
    replace, left = os.replace, [last]

    def failing(source, target):
        left[0] -= 1
        if not left[0]:
            raise OSError(28, 'No space left on device')
        replace(source, target)

    monkeypatch.setattr(os, 'replace', failing)
    renames = 6
    if last <= renames:
        with pytest.raises(OSError, match='No space'):
            cut.add(episode(2))
    monkeypatch.undo()
    consistent(tmp_path / 'cut', 2)
    again = opened(tmp_path / 'cut')
    assert again.episodes == 2
    again.add(episode(2))
    assert files(tmp_path / 'cut') == files(tmp_path / 'whole')


def test_statistics_of_parts_are_those_of_the_whole():
    """Extremes, mean and deviation of two parts together equal those of all values."""
    values = np.random.default_rng(1).normal(size=(30, 2))
    both, whole = together(stats_of(values[:10]), stats_of(values[10:])), stats_of(values)
    for name in ('min', 'max', 'mean', 'std', 'count'):
        np.testing.assert_allclose(both[name], whole[name], rtol=1e-12)


def test_equal_pictures_give_equal_files_of_good_quality():
    """A coloured gradient that moves comes back with more than 30 dB."""
    ramp = np.linspace(0, 200, 96)
    pictures = [np.stack(np.broadcast_arrays(
        ramp[None, :, ], ramp[:, None], 20.0 * k), axis=-1).astype(np.uint8) for k in range(6)]
    content = encoded(pictures, 20)
    assert content == encoded(pictures, 20)
    for picture, shown in zip(pictures, decoded(content), strict=True):
        error = np.mean((picture.astype(float) - shown) ** 2)
        assert 10 * np.log10(255**2 / error) > 30


def test_another_set_is_refused_and_nothing_changes(tmp_path):
    """All differences are named; a folder with other files is left alone."""
    opened(tmp_path / 'set').add(episode(0))
    before = files(tmp_path / 'set')
    with pytest.raises(ConfigError) as told:
        DataSet(tmp_path / 'set', {}, 50, 'arm', {'policy': 'random'})
    for text in ('fps 20, not 50', "robot_type 'bot', not 'arm'", "policy 'expert', not 'random'",
                 'features.observation.state'):
        assert text in str(told.value)
    assert files(tmp_path / 'set') == before
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine/notes').write_text('mine')
    with pytest.raises(ConfigError, match='is not empty and is not a data set'):
        opened(tmp_path / 'mine')


def test_collected_episodes_are_those_of_their_seeds(tmp_path):
    """One process and two write the same bytes; the actions give the same states again."""
    for workers in (1, 2):
        found = collect(Plan(SOURCE, 3, seed=5, workers=workers), tmp_path / str(workers))
        assert (found.episodes, found.successes) == (3, 3)
    assert files(tmp_path / '1') == files(tmp_path / '2')
    assert [again.same for again in replay(tmp_path / '1')] == [True] * 3
    info = json.loads((tmp_path / '1/meta/info.json').read_text())
    assert info['features']['action']['names'][-1] == 'vacuum_gripper'


def test_only_successes_are_kept(tmp_path):
    """Episodes of random actions fail; after many the collection says so, with status 1."""
    source = Source('armsim/Reach-v1', {'obs_type': 'state', 'max_episode_steps': 2}, 'random')
    from armsim_ros.errors import ArmsimError

    with pytest.raises(ArmsimError, match='no success in 200 episodes'):
        collect(Plan(source, 1, only_successes=True), tmp_path / 'set')


def test_a_failing_policy_leaves_what_is_finished(tmp_path, monkeypatch, capsys):
    """Its exception is named, the status is 1, and the finished episodes are counted."""
    (tmp_path / 'my_policy.py').write_text(
        'calls = 0\n\ndef act(observation):\n    global calls\n    calls += 1\n'
        '    return [0.0] * 7 if calls <= 5 else 1 / 0\n')
    monkeypatch.chdir(tmp_path)
    status = main(['collect', 'armsim/Reach-v1', 'set', '--episodes', '3', '--obs-type', 'state',
                   '--max-episode-steps', '4', '--policy', 'my_policy:act'])
    assert status == 1
    told = capsys.readouterr().err
    assert 'ZeroDivisionError: division by zero' in told
    assert '1 of 3 episodes' in told
    monkeypatch.setattr(sys, 'path', sys.path[:])
    with pytest.raises(PolicyError):
        EpisodeRunner(Source('armsim/Reach-v1', {'obs_type': 'state'}, 'my_policy:act')).run(0)


@pytest.mark.parametrize(('arguments', 'complaint'), [
    (['armsim/Rech-v1', 'set', '--episodes', '1'], "did you mean 'Reach-v1'"),
    (['armsim/Reach-v1', 'set', '--episodes', '0'], 'at least 1'),
    (['armsim/Reach-v1', 'set', '--episodes', '1', '--image-size', '97', '96'], 'even width'),
    (['armsim/Reach-v1', 'set', '--episodes', '1', '--period', '0.03'], 'frames per second'),
    (['armsim/Reach-v1', 'set', '--episodes', '1', '--policy', 'no_such:act'], 'cannot be impor'),
])
def test_wrong_arguments_change_nothing(tmp_path, monkeypatch, capsys, arguments, complaint):
    """One message, status 2, no folder."""
    monkeypatch.chdir(tmp_path)
    assert main(['collect', *arguments]) == 2
    assert complaint in capsys.readouterr().err
    assert not Path('set').exists()


def test_a_terminated_collection_goes_on(tmp_path):
    """SIGTERM ends it with 143 and a count; the same command completes the set."""
    command = [sys.executable, '-m', 'armsim_ros', 'collect', 'armsim/Reach-v1',
               str(tmp_path / 'set'), '--episodes', '60', '--obs-type', 'state']
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not (tmp_path / 'set/meta/info.json').exists() and time.monotonic() < deadline:
        child.poll()
    child.send_signal(signal.SIGTERM)
    _, told = child.communicate(timeout=60)
    assert child.returncode == 143
    assert 'of 60 episodes are in' in told
    count = json.loads((tmp_path / 'set/meta/info.json').read_text())['total_episodes']
    assert 1 <= count < 60
    found = collect(Plan(Source('armsim/Reach-v1', {'robot': 'sunday', 'obs_type': 'state'}),
                         count + 1), tmp_path / 'set')
    assert found.episodes == count + 1


def test_frame_k_shows_state_k(tmp_path):
    """Against the state rendered again: more than 30 dB, and nearer than to its neighbours."""
    arguments = {'obs_type': 'pixels_agent_pos'}
    collect(Plan(Source('armsim/Reach-v1', arguments), 1), tmp_path / 'set')
    (video,) = (tmp_path / 'set/videos').rglob('*.mp4')
    shown = [np.asarray(frame, dtype=np.float64) for frame in decoded(video.read_bytes())]
    env = made(Source('armsim/Reach-v1', arguments))
    facts = json.loads((tmp_path / 'set/meta/armsim.json').read_text())['episodes'][0]
    rows = parquet.read_table(tmp_path / 'set/data', partitioning=None).to_pylist()
    observation, _ = env.reset(seed=facts['seed'])
    rendered = []
    for row in rows:
        rendered.append(observation['pixels']['front'].astype(np.float64))
        observation, *_ = env.step(np.array(row['action'], dtype=np.float32))
    env.close()

    def error(frame, picture):
        return float(np.mean((shown[frame] - rendered[picture]) ** 2))

    assert all(10.0 * np.log10(255.0**2 / error(k, k)) > 30.0 for k in range(len(rows)))
    moving = [k for k in range(1, len(rows) - 1)
              if min(float(np.mean((rendered[k] - rendered[other]) ** 2))
                     for other in (k - 1, k + 1)) > 20.0]
    assert len(moving) > 3
    assert all(error(k, k) < min(error(k, k - 1), error(k, k + 1)) for k in moving)
