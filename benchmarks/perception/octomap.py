# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Adding a cloud of 640 x 480 points to a map, beside OctoMap's insertion; with ``--report``.

Processor time of the third cloud of the same table with three boxes. Ours is the whole message:
ten capsules of a robot are left out, cells that rays cross are missed, and coal's tree is made.
"""

from __future__ import annotations

import json
from pathlib import Path
import subprocess
import tempfile
import time

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.geometry import Capsule
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.collision.octree_shapes import octree_shapes
from armsim_ros.planning.occupancy.occupancy_map import Measurement, OccupancyMap
from armsim_ros.planning.occupancy.solids import Solid
from benchmarks.options import Options
from benchmarks.planning.planning import environment, Peer
from benchmarks.tables import machine_load, replace_section, Table

RESOLUTIONS = (0.05, 0.025, 0.02)
PEER = Peer('pyoctomap_insertion.py', ('pyoctomap==1.2.2', 'numpy>=2'))
#: Middle, half edge and height of the boxes on the table [m].
BOXES = ((0.5, 0.2, 0.1, 0.3), (0.7, -0.2, 0.15, 0.2), (1.0, 0.3, 0.1, 0.4))
SENSOR = pose_matrix((-0.3, 0.0, 1.2))


def main(options: Options) -> None:
    """Print the times."""
    points, sensor = table()
    body = Solid(Capsule(0.07, 0.3), 1.0, 0.02)
    bodies = [(body, pose_matrix((0.1 * k, 0.0, 0.1 * k), (0.0, 0.3 * k, 0.0))) for k in range(10)]
    peer = _peer(points @ sensor[:3, :3].T + sensor[:3, 3], sensor[:3, 3])
    rows = []
    for resolution in RESOLUTIONS:
        octomap = OccupancyMap(resolution)
        for _ in range(3):
            begin = time.process_time()
            octomap, _ = octomap.inserted(Measurement(points, sensor, 5.0), bodies)
            added = time.process_time() - begin
            made = octomap.octomap()
            assert made is not None
            octree_shapes(made)
            whole = time.process_time() - begin
        plain, discrete = (peer.get(f'{resolution:g} {kind}') for kind in (False, True))
        rows.append((f'{resolution:g} m', str(len(octomap.occupied)), f'{1e3 * added:.0f}',
                     f'{1e3 * whole:.0f}', *(f'{each:.0f}' if each else '-'
                                             for each in (plain, discrete))))
    table_of_times = Table(f'{len(points)} points [ms of processor time]', (
        'cells', 'occupied', 'added', 'with the tree', 'insertPointCloud', 'discretize=True'),
        rows)
    table_of_times.print()
    if options.report:
        replace_section(Path(options.report), 'octomap', [
            machine_load(), '', *table_of_times.markdown()])


def table() -> tuple[np.ndarray, Matrix]:
    """Return points (k, 3) [m] in the frame of a camera, and its pose (4, 4)."""
    tilt = np.deg2rad(50.0)
    forward = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    right = np.array([0.0, -1.0, 0.0])
    sensor = SENSOR.copy()
    sensor[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    u, v = np.meshgrid(np.arange(640) - 319.5, np.arange(480) - 239.5)
    ways = np.stack([u / 525.0, v / 525.0, np.ones_like(u)], axis=-1)
    turned, origin = ways @ sensor[:3, :3].T, sensor[:3, 3]
    with np.errstate(divide='ignore', invalid='ignore'):
        depth = np.where(turned[..., 2] < 0.0, -origin[2] / turned[..., 2], np.inf)
        for x, y, half, height in BOXES:
            ends = np.array([[x - half, y - half, 0.0], [x + half, y + half, height]])
            first, second = ((end - origin) / turned for end in ends)
            enter = np.minimum(first, second).max(axis=-1)
            leave = np.maximum(first, second).min(axis=-1)
            depth = np.where((enter < leave) & (enter > 0.0) & (enter < depth), enter, depth)
    seen = depth < 3.0
    return (ways[seen] * depth[seen, None]).astype(np.float32), sensor


def _peer(points: np.ndarray, origin: np.ndarray) -> dict[str, float]:
    """Return OctoMap's times [ms]; none where it cannot be installed."""
    python = environment('pyoctomap', PEER)
    if python is None:
        return {}
    script = Path(__file__).parent / 'peers' / PEER.script
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / 'cloud.npz'
        np.savez(file, points=points, sensor=origin)
        done = subprocess.run(
            [python, str(script), str(file), *map(str, RESOLUTIONS)], check=True,
            capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found
