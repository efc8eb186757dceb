# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Draws red balls at random places; run as a program, as MUJOCO_GL counts at the first import.

    MUJOCO_GL=egl python test/support/draw_balls.py FILE.npz
"""

import sys

import mujoco
import numpy as np

from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.camera import Camera, take_snapshot, TO_OPTICAL
from armsim_ros.sim.physics.compiler import model_to_bytes
from armsim_ros.sim.scene_renderer import SceneRenderer

RADIUS = 0.012
SIZES = ((640, 480), (320, 200))


def main(path):
    """Write pictures, and the balls' centres in the cameras' optical frames."""
    mount = pose_matrix((0.3, -0.2, 0.8), (0.2, -0.3, 0.5)) @ TO_OPTICAL
    cameras = [
        Camera('camera', 'world', tuple(mount.ravel()), '', width, height, 0.9666 * height,
               (0.1, 3.0), 1)
        for width, height in SIZES
    ]
    rng = np.random.default_rng(1)
    depth = rng.uniform(0.3, 2.5, 12)
    centres = np.column_stack([depth * np.linspace(-0.45, 0.45, 12),
                               depth * rng.uniform(-0.35, 0.35, 12), depth])
    spec = mujoco.MjSpec()
    for centre in centres:
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0.0, 0.0], rgba=[1.0, 0.0, 0.0, 1.0],
            pos=mount[:3, :3] @ centre + mount[:3, 3])
    model = spec.compile()
    renderer = SceneRenderer(cameras)
    renderer.load(model_to_bytes(model))
    data, found = mujoco.MjData(model), {}
    for number in range(len(cameras)):
        picture = renderer.draw(take_snapshot(number, 0, model, data))
        again = renderer.draw(take_snapshot(number, 0, model, data))
        found[f'colour{number}'], found[f'depth{number}'] = picture
        found[f'same{number}'] = (picture.colour == again.colour).all()
    renderer.close()
    np.savez(path, centres=centres, **found)


if __name__ == '__main__':
    main(sys.argv[1])
