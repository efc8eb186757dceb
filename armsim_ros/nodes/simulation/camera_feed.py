# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Sends what is to be rendered to the camera program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing.connection import Client, Connection, Listener
from pathlib import Path
from queue import Empty, SimpleQueue
import threading
from typing import Any

from armsim_ros.nodes.camera.link import FAMILY, greeting, PLANT, SNAPSHOT
from armsim_ros.sim.camera import Camera, Snapshot, take_snapshot
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.physics.compiler import model_to_bytes

#: Wall time after which lockstep gives up a camera program that does not answer [s].
_LONGEST_DRAWING = 60.0
#: Wall time between checks that it is still there [s].
_LOOK = 0.1


class CameraFeed:
    """
    Serves a single camera program at a time.

    The loop copies joints and bodies, some kilobytes, when a picture is due that was asked for;
    all else happens in threads of its own that mostly wait. In lockstep the loop waits until
    the picture is out.

    :param path: of the socket; the creator of a feed holds the lock beside it.
    :param complain: takes a line where a picture that is waited for does not come.
    """

    def __init__(
        self, loop: ControlLoop, cameras: Sequence[Camera], path: Path,
        complain: Callable[[str], object], *, lockstep: bool
    ) -> None:
        self._complain = complain
        self._simulation = loop.simulation
        self._lockstep = lockstep
        self._greeting = greeting(cameras, lockstep=lockstep)
        self._asked: set[int] = set()
        self._due: SimpleQueue[tuple[Snapshot, Any] | None] = SimpleQueue()
        self._drawn: SimpleQueue[int] = SimpleQueue()
        self._connected = self._closed = False
        #: Pictures that lockstep has waited for.
        self.pictures = 0
        path.unlink(missing_ok=True)
        self._listener = Listener(str(path), FAMILY)
        for number, camera in enumerate(cameras):
            loop.every(camera.period_ns, partial(self._look, number))
        self._thread = threading.Thread(target=self._accept, name='camera', daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Remove the socket."""
        self._closed = True
        with suppress(OSError):
            Client(self._listener.address, FAMILY).close()  # ends the wait for a connection
        self._thread.join()

    def _look(self, number: int, time_ns: int) -> None:
        """Take a snapshot if requested; in the loop's thread."""
        if self._lockstep:
            if self._connected:
                self._post(number, time_ns)
                self._await_picture(number)
        elif number in self._asked:
            self._asked.discard(number)
            self._post(number, time_ns)

    def _post(self, number: int, time_ns: int) -> None:
        model, data = self._simulation.mujoco_model, self._simulation.mujoco_data
        self._due.put((take_snapshot(number, time_ns, model, data), model))

    def _await_picture(self, number: int) -> None:
        waited = 0.0
        while self._connected and waited < _LONGEST_DRAWING:
            with suppress(Empty):
                if self._drawn.get(timeout=_LOOK) == number:
                    self.pictures += 1
                    return
                continue
            waited += _LOOK
        if self._connected:
            self._connected = False
            self._complain(f'the camera program has drawn nothing for {_LONGEST_DRAWING:g} s; '
                           'steps do not wait for it any more')

    def _accept(self) -> None:
        """Serve connections in sequence."""
        with self._listener:
            while True:
                connection = self._listener.accept()
                if self._closed:
                    return
                with connection:
                    self._connected = True
                    sender = threading.Thread(
                        target=self._send, args=(connection,), name='pictures', daemon=True)
                    sender.start()
                    self._receive(connection)
                    self._connected = False
                    self._due.put(None)
                    sender.join()
                self._asked.clear()
                self._due, self._drawn = SimpleQueue(), SimpleQueue()

    def _receive(self, connection: Connection) -> None:
        """Read requests and acknowledgements until the other side disconnects."""
        with suppress(OSError, EOFError):
            while message := connection.recv_bytes():
                if self._lockstep:
                    self._drawn.put(message[0])
                else:
                    self._asked.add(message[0])

    def _send(self, connection: Connection) -> None:
        """Send the plant and due snapshots; a changed plant goes before its snapshots."""
        known = self._simulation.mujoco_model
        with suppress(OSError):
            connection.send_bytes(self._greeting)
            connection.send_bytes(PLANT + model_to_bytes(known))
            while (due := self._due.get()) is not None:
                snapshot, model = due
                if model is not known:
                    connection.send_bytes(PLANT + model_to_bytes(model))
                    known = model
                connection.send_bytes(SNAPSHOT + snapshot.to_bytes())
