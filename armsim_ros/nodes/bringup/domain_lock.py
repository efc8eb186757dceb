# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Keeps a second bringup off a ROS domain that already has a bringup.

Two stacks in one graph double every topic and answer every goal twice. A lock on a file is
exact, free of races, and costs no discovery time, but knows this machine only (and one user,
or all users where the file's folder is shared); the stack of another machine is seen only in
the ROS graph, by the programs themselves once their nodes have discovered it.
"""

from __future__ import annotations

from collections.abc import Sequence
import errno
import fcntl
import os
from pathlib import Path
import re
import stat
import tempfile

from armsim_ros.errors import ArmsimError

_NAMESPACE_RULE = re.compile(r'^(?:[^:=]*:)?__ns:=(.*)$')


class DomainTakenError(ArmsimError):
    """The same program runs in the same domain and namespace."""


class UnsafeFolderError(ArmsimError):
    """The folder of the lock files is not this user's alone."""


class DomainLock:
    """
    The right to run a program in a ROS domain and namespace; kept until the process ends.

    The lock vanishes with the process, also after SIGKILL; the file may stay.

    :param domain: the number in ``ROS_DOMAIN_ID``.
    :param namespace: the namespace that all nodes are remapped into, ``/`` for none.
    :param folder: where the lock files lie.
    :param program: ``bringup`` for a whole stack.
    :raises DomainTakenError: where another process holds it.
    :raises UnsafeFolderError: where another user could have created the files.
    """

    def __init__(
        self, domain: str, namespace: str, folder: Path, program: str = 'bringup'
    ) -> None:
        self.path = _lock_file(domain, namespace, folder, program)
        _make_private(folder)
        self._file = open(self.path, 'a+', encoding='utf-8', opener=_open_itself)  # noqa: SIM115
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._file.seek(0)
            holder = self._file.read().strip() or 'unknown'
            self._file.close()
            where = f' in namespace {namespace}' if namespace.strip('/') else ''
            raise DomainTakenError(
                f'another {program} (pid {holder}) already runs on ROS_DOMAIN_ID {domain}{where} '
                'and both would publish the same topics; stop it first, or set another '
                'ROS_DOMAIN_ID for this bringup (and for its clients)') from None
        self._file.truncate(0)
        self._file.write(f'{os.getpid()}\n')
        self._file.flush()

    def release(self) -> None:
        """Give the right back."""
        self._file.close()


def lock_domain(
    ros_args: Sequence[str], *, program: str = 'bringup', namespace: str = '/'
) -> DomainLock:
    """
    Take the lock that belongs to this process's environment and ROS arguments.

    :param ros_args: ``--ros-args`` sections; a ``__ns`` remapping in them counts.
    :param program: ``bringup`` for a whole stack.
    :param namespace: of the nodes where nothing remaps it.
    :raises DomainTakenError: where another process holds it.
    """
    return DomainLock(*_place(ros_args, namespace), runtime_folder(), program)


def lock_path(ros_args: Sequence[str], *, program: str = 'bringup', namespace: str = '/') -> Path:
    """Return the file of the lock that ``lock_domain`` takes."""
    return _lock_file(*_place(ros_args, namespace), runtime_folder(), program)


def _place(ros_args: Sequence[str], namespace: str) -> tuple[str, str]:
    """Return domain and namespace of this process's environment and ROS arguments."""
    if namespace == '/':
        namespace = os.environ.get('ROS_NAMESPACE', namespace)
    for word in ros_args:
        match = _NAMESPACE_RULE.match(word)
        if match:
            namespace = match.group(1)
    return os.environ.get('ROS_DOMAIN_ID') or '0', namespace


def _lock_file(domain: str, namespace: str, folder: Path, program: str) -> Path:
    place = namespace.strip('/').replace('/', '.')
    return folder / f'{program}-domain{domain}{"-" + place if place else ""}.lock'


def _make_private(folder: Path) -> None:
    """Make a folder of this user's; in a shared folder, another user may have been first."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    status = os.lstat(folder)
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        raise UnsafeFolderError(
            f'{folder} is a link or belongs to another user, so that no lock can be kept there; '
            'remove it, or set XDG_RUNTIME_DIR to a folder of your own')


def _open_itself(path: str, flags: int) -> int:
    """Open a file, but not what a link of its name leads to."""
    try:
        return os.open(path, flags | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    except OSError as error:
        if error.errno != errno.ELOOP:
            raise
        raise UnsafeFolderError(f'{path} is a link; remove it') from None


def runtime_folder() -> Path:
    """Return the folder for files that live no longer than the user's session."""
    given = os.environ.get('XDG_RUNTIME_DIR', '')
    if given and os.access(given, os.W_OK):
        return Path(given, 'armsim_ros')
    return Path(tempfile.gettempdir(), f'armsim_ros-{os.getuid()}')
