# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The examples that collect episodes."""

import filecmp
import importlib.util
import json
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pyarrow as pa
from pyarrow import parquet
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope='module')
def example():
    """Return examples/collect_episodes.py as a module."""
    spec = importlib.util.spec_from_file_location(
        'collect_episodes', ROOT / 'examples' / 'collect_episodes.py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def test_the_data_set_is_what_its_meta_files_say(example, tmp_path, capsys):
    """Columns, widths, frames and statistics agree with info.json, and the cube is picked up."""
    env = example.PickCube()
    episodes = [example.run_episode(env, seed) for seed in (0, 1)]
    example.collect(tmp_path / 'set', env, episodes)
    assert '2 episodes, ' in capsys.readouterr().out
    meta = tmp_path / 'set' / 'meta'
    info = json.loads((meta / 'info.json').read_text())
    lines, stats = ([json.loads(line) for line in (meta / name).read_text().splitlines()]
                    for name in ('episodes.jsonl', 'episodes_stats.jsonl'))
    first = 0
    for number, episode in enumerate(episodes):
        assert episode.success
        path = info['data_path'].format(episode_chunk=0, episode_index=number)
        table = parquet.read_table(tmp_path / 'set' / path)
        assert set(table.column_names) == set(info['features'])
        for name, feature in info['features'].items():
            values = np.array(table[name].to_pylist()).reshape(len(table), -1)
            assert [values.shape[1]] == feature['shape']
            kind = table.schema.field(name).type
            kind = kind.value_type if pa.types.is_fixed_size_list(kind) else kind
            assert feature['dtype'] == str(np.dtype(kind.to_pandas_dtype()))
            largest = values.max(axis=0).tolist()
            assert stats[number]['stats'][name]['max'] == pytest.approx(largest)
        assert len(table) == lines[number]['length'] == len(episode.actions)
        assert table['index'].to_pylist() == list(range(first, first + len(table)))
        first += len(table)
    assert info['total_frames'] == first


def test_an_episode_depends_on_its_seed_alone(example):
    """Whatever the environment did before, a seed gives one digest; another seed another."""
    env, other = example.PickCube(), example.PickCube()
    digests = [example.run_episode(env, seed).digest for seed in (4, 5)]
    assert example.run_episode(other, 5).digest == digests[1] != digests[0]


def test_a_folder_with_files_is_refused(example, tmp_path):
    """What is there is not written over."""
    (tmp_path / 'notes').write_text('mine')
    with pytest.raises(example.ArmsimError, match='is not empty; name a new folder'):
        example.DataSet(tmp_path, None)


def test_ray_collects_the_same_data_set(tmp_path):
    """Two workers write the files that one process writes."""
    pytest.importorskip('ray')
    environment = {**os.environ, 'PYTHONPATH': str(ROOT), 'RAY_USAGE_STATS_ENABLED': '0'}
    for script in ('collect_episodes', 'collect_on_ray'):
        subprocess.run(
            [sys.executable, ROOT / 'examples' / f'{script}.py', tmp_path / script,
             '--episodes', '12'], check=True, env=environment)
    one, ray = (sorted(path.relative_to(tmp_path / name)
                       for path in (tmp_path / name).rglob('*') if path.is_file())
                for name in ('collect_episodes', 'collect_on_ray'))
    assert one == ray
    same, different, missing = filecmp.cmpfiles(
        tmp_path / 'collect_episodes', tmp_path / 'collect_on_ray', one, shallow=False)
    assert (len(same), different, missing) == (len(one), [], [])
