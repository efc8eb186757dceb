# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""One stack a ROS domain."""

import os

import pytest

from armsim_ros.nodes.bringup.domain_lock import (
    DomainLock,
    DomainTakenError,
    lock_domain,
    UnsafeFolderError,
)


@pytest.fixture(autouse=True)
def runtime_folder(tmp_path, monkeypatch):
    """Keep the locks of these tests apart from those of real stacks."""
    monkeypatch.setenv('XDG_RUNTIME_DIR', str(tmp_path))
    monkeypatch.setenv('ROS_DOMAIN_ID', '7')
    return tmp_path


def test_a_second_stack_in_the_domain_is_refused():
    """The message names the first one's pid, the domain and the way out."""
    first = lock_domain([])
    with pytest.raises(DomainTakenError) as caught:
        lock_domain([])
    first.release()
    text = str(caught.value)
    assert f'pid {os.getpid()}' in text
    assert 'ROS_DOMAIN_ID 7' in text
    assert '\n' not in text


def test_the_lock_is_in_the_folder_of_the_session(runtime_folder):
    """It is where XDG_RUNTIME_DIR points to, which is emptied when the session ends."""
    lock = lock_domain([])
    assert list((runtime_folder / 'armsim_ros').iterdir())
    lock.release()


def test_the_end_of_the_first_makes_room():
    """A released lock can be taken again."""
    lock_domain([]).release()
    lock_domain([]).release()


def test_another_domain_is_another_stack(monkeypatch):
    """Domains do not see each other; no ROS_DOMAIN_ID is domain 0."""
    locks = [lock_domain([])]
    monkeypatch.setenv('ROS_DOMAIN_ID', '8')
    locks.append(lock_domain([]))
    monkeypatch.delenv('ROS_DOMAIN_ID')
    locks.append(lock_domain([]))
    for lock in locks:
        lock.release()


def test_a_namespace_for_all_nodes_is_another_stack():
    """Two stacks whose every name differs do not double anything."""
    first = lock_domain([])
    second = lock_domain(['--ros-args', '-r', '__ns:=/left', '--'])
    with pytest.raises(DomainTakenError, match='in namespace /left'):
        lock_domain(['--ros-args', '-r', '__ns:=/left', '--'])
    first.release()
    second.release()


def test_a_lock_file_left_behind_locks_nothing(runtime_folder):
    """After a crash the file stays, the lock does not."""
    (runtime_folder / 'armsim_ros').mkdir()
    (runtime_folder / 'armsim_ros' / 'bringup-domain7.lock').write_text('1\n')
    lock_domain([]).release()


def test_a_link_in_place_of_the_file_is_not_followed(tmp_path):
    """Whoever puts it there cannot have this user's files written to."""
    victim = tmp_path / 'victim'
    victim.write_text('precious')
    folder = tmp_path / 'locks'
    folder.mkdir()
    (folder / 'bringup-domain7.lock').symlink_to(victim)
    with pytest.raises(UnsafeFolderError, match='is a link'):
        DomainLock('7', '/', folder)
    assert victim.read_text() == 'precious'


def test_a_link_in_place_of_the_folder_is_not_followed(tmp_path):
    """The folder for temporary files is everybody's."""
    (tmp_path / 'elsewhere').mkdir()
    folder = tmp_path / 'locks'
    folder.symlink_to(tmp_path / 'elsewhere')
    with pytest.raises(UnsafeFolderError, match='XDG_RUNTIME_DIR'):
        DomainLock('7', '/', folder)
    assert not list((tmp_path / 'elsewhere').iterdir())
