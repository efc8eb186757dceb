# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Between the simulation and the program that draws: a socket of this user's on this machine.

The simulation sends a greeting once, the plant whenever it changes, and a snapshot when
a requested picture is due. The other side sends the number of a camera to request its next
picture. In lockstep snapshots come without a request, and the number confirms that a picture was
published.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
import json
from pathlib import Path

from armsim_ros.nodes.bringup.domain_lock import lock_path
from armsim_ros.sim.camera.camera import Camera

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
