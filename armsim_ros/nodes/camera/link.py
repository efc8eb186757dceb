# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The link of simulation and camera program: a socket of this user's on this machine.

The simulation sends a greeting once, the plant whenever it changes, and a snapshot when
a requested picture is due. The other side sends the number of a camera to request its next
picture. In lockstep snapshots come without a request, and the number confirms that a picture was
published.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
import json
from multiprocessing.connection import Client, Connection
from pathlib import Path

from armsim_ros.nodes.bringup.domain_lock import lock_path
from armsim_ros.sim.camera import Camera, Snapshot

#: First byte of what follows the greeting.
PLANT, SNAPSHOT = b'P', b'S'
FAMILY = 'AF_UNIX'
#: What the lock and the socket of a simulation with cameras are called.
NAME = 'camera'


def socket_path(ros_args: Sequence[str]) -> Path:
    """Return where the simulation of this process's domain and namespace listens."""
    return lock_path(ros_args, program=NAME).with_suffix('.socket')


def greeting(cameras: Sequence[Camera], *, lockstep: bool) -> bytes:
    """Return the first message: the cameras, and whether pictures are waited for."""
    words = {'cameras': [asdict(camera) for camera in cameras], 'lockstep': lockstep}
    return json.dumps(words).encode()


def read_greeting(message: bytes) -> tuple[tuple[Camera, ...], bool]:
    """Return the content of a greeting."""
    words = json.loads(message)
    cameras = (Camera(**{**entry, 'mount': tuple(entry['mount']), 'range': tuple(entry['range'])})
               for entry in words['cameras'])
    return tuple(cameras), bool(words['lockstep'])


class PictureSource:
    """
    Where snapshots of the simulation come from.

    :param ros_args: of the command line; they select the simulation.
    """

    def __init__(self, ros_args: Sequence[str]) -> None:
        self._path = socket_path(ros_args)
        self._connection: Connection | None = None
        self.lockstep = False
        """Whether the simulation waits for each picture."""

    @property
    def connected(self) -> bool:
        """Whether a simulation is there."""
        return self._connection is not None

    def connect(self) -> tuple[tuple[Camera, ...], bytes]:
        """Return the simulation's cameras and plant; no camera while there is none."""
        try:
            self._connection = Client(str(self._path), FAMILY)
            cameras, self.lockstep = read_greeting(self._connection.recv_bytes())
            plant = self._connection.recv_bytes()[1:]
        except (OSError, EOFError):
            self.close()
            return (), b''
        return cameras, plant

    def confirm(self, camera: int) -> None:
        """Ask for the camera's next picture; in lockstep, confirm that it was published."""
        try:
            if self._connection is not None:
                self._connection.send_bytes(bytes([camera]))
        except OSError:
            self.close()

    def receive(self, timeout: float) -> Snapshot | bytes | None:
        """
        Return what is to be drawn: a snapshot, or the bytes of a plant that later ones are of.

        :param timeout: wall time after which None is returned [s].
        """
        try:
            if self._connection is None or not self._connection.poll(timeout):
                return None
            message = self._connection.recv_bytes()
        except (OSError, EOFError):
            self.close()
            return None
        kind, content = message[:1], message[1:]
        return Snapshot.from_bytes(content) if kind == SNAPSHOT else content

    def close(self) -> None:
        """Leave the simulation."""
        if self._connection is not None:
            self._connection.close()
        self._connection = None
