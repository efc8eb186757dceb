# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The drawing program's end of its link to the simulation."""

from __future__ import annotations

from collections.abc import Sequence
from multiprocessing.connection import Client, Connection

from armsim_ros.nodes.camera.link import FAMILY, read_greeting, SNAPSHOT, socket_path
from armsim_ros.sim.camera.camera import Camera
from armsim_ros.sim.camera.snapshot import Snapshot


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
