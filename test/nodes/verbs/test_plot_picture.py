# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A motion as a picture."""

import numpy as np
import pytest

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.verbs.plot import JointRecord, main, read_csv, read_recording, write_picture


@pytest.fixture
def file(tmp_path):
    """Write what the page saves of a motion of one joint."""
    path = tmp_path / 'motion.csv'
    path.write_text('joint,time,desired,actual,error\n'
                    'a,0,0,0,0\na,0.5,0.5,0.4,0.1\na,1,1,1,0\n', encoding='utf-8')
    return path


@pytest.mark.parametrize(('name', 'start'), [('out.png', b'\x89PNG'), ('out.html', b'<!doctype')])
def test_a_saved_motion_becomes_a_picture(file, tmp_path, name, start, capsys):
    """PNG to look at, HTML to read values off."""
    if name.endswith('png'):
        pytest.importorskip('matplotlib')
    assert main([str(file), '--to', str(tmp_path / name)]) == 0
    assert (tmp_path / name).read_bytes().startswith(start)
    assert capsys.readouterr().out == f'{tmp_path / name}\n'


def test_a_violated_tolerance_is_told_with_joint_size_and_time(file):
    """What a person looks for after an abort."""
    (record,) = read_csv(file)
    record = JointRecord(record.name, record.rows, tolerance=0.05)
    assert record.violated == 'error 0.1 is above the tolerance 0.05, first at 0.50 s'
    assert not JointRecord(record.name, record.rows, tolerance=0.2).violated


@pytest.fixture
def recording(arm, tmp_path):
    """Record an arm that moves, as a failed test does."""
    arm.move_to('scan_food')
    return dict(arm.save_artifacts(tmp_path / 'failed'))['recording']


@pytest.mark.parametrize('place', ['failed.mcap', ''])
def test_a_recording_becomes_records_with_the_limits_of_its_robot(recording, place):
    """From the file, or from the folder that a bag is."""
    records = {one.name: one for one in read_recording(recording.parent / place)}
    assert sorted(records) == [f'joint_{number}' for number in range(1, 7)]
    times, desired, actual, error = records['joint_5'].rows.T
    assert times[0] == 0.0
    assert desired[-1] - desired[0] > 0.1
    assert np.allclose(desired - actual, error, atol=1e-6)
    assert len(records['joint_5'].limits) == 2


def test_a_tolerance_is_given_by_hand(file, tmp_path, capsys):
    """Status 1 and the words where it was violated."""
    words = [str(file), '--to', str(tmp_path / 'a.html')]
    assert main([*words, '--tolerance', '1']) == 0
    assert main([*words, '--tolerance', '0.05']) == 1
    assert 'is above the tolerance 0.05' in capsys.readouterr().out


def test_what_is_no_recording_is_answered_with_a_sentence(tmp_path):
    """An empty folder, a text file, a file that is not there."""
    with pytest.raises(ArmsimError, match=r'no \.mcap file'):
        read_recording(tmp_path)
    (tmp_path / 'a.mcap').write_text('text', encoding='utf-8')
    with pytest.raises(ArmsimError, match='not a recording that can be read'):
        read_recording(tmp_path / 'a.mcap')
    with pytest.raises(ArmsimError, match='cannot be read'):
        read_recording(tmp_path / 'b.mcap')


def test_a_joint_cannot_end_the_page(tmp_path):
    """Its name is text of somebody's URDF."""
    record = JointRecord('</script><b>', np.zeros((3, 4)))
    write_picture([record], tmp_path / 'out.html')
    assert '</script><b>' not in (tmp_path / 'out.html').read_text(encoding='utf-8')


@pytest.mark.parametrize(('text', 'message'), [
    ('', 'is not an executed motion'),
    ('time,a position\n', 'is not an executed motion'),
    ('joint,time,desired,actual,error\na,0,0\n', r'csv:2: allowed: a name and four numbers'),
    ('joint,time,desired,actual,error\na,0,0,x,0\n', r'csv:2'),
    ('joint,time,desired,actual,error\n', 'nothing was recorded'),
])
def test_a_wrong_file_is_answered_with_its_line(tmp_path, text, message):
    """No traceback, no empty picture."""
    file = tmp_path / 'a.csv'
    file.write_text(text, encoding='utf-8')
    with pytest.raises(ArmsimError, match=message):
        main([str(file), '--to', str(tmp_path / 'out.html')])


def test_another_ending_is_refused(file, tmp_path):
    """With those that there are."""
    with pytest.raises(ArmsimError, match='allowed endings'):
        main([str(file), '--to', str(tmp_path / 'out.gif')])
