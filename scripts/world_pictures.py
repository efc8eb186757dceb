# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Draws the pictures of docs/world.md: the feeding place, and what sunday's camera sees of it.

    .venv/bin/python scripts/world_pictures.py
"""

import os
from pathlib import Path

import numpy as np
from PIL import Image

from armsim_ros.nodes.camera.gl_backend import choose_backend, VARIABLE

FOLDER = Path(__file__).parents[1] / 'docs' / 'images'
STATE = 'scan_food'
#: Depths that are drawn black and white [m].
SHADES = (0.37, 0.45)


def main() -> None:
    """Let the things come to rest below the camera, and draw."""
    os.environ[VARIABLE] = choose_backend(os.environ)
    # Only now: MuJoCo is imported, which looks once at what is to draw.
    from armsim_ros.cli.arguments import parse_arguments
    from armsim_ros.cli.settings import cell_of
    from armsim_ros.config.simulation import CameraSettings
    from armsim_ros.sim.assembly import build_simulation
    from armsim_ros.sim.camera.camera import cameras_of
    from armsim_ros.sim.camera.scene_renderer import SceneRenderer
    from armsim_ros.sim.camera.snapshot import take_snapshot
    from armsim_ros.sim.physics.compiler import model_to_bytes

    cell, _ = cell_of(parse_arguments(['robot:=sunday', 'world:=feeding_place']))
    simulation = build_simulation(cell.settings, cell.model)
    simulation.set_positions(cell.model.semantic.named_states['manipulator'][STATE])
    for _ in range(1000):
        simulation.step()
    front = CameraSettings(link='world', xyz=(1.15, 1.15, 1.75), rpy=(0.0, 0.34, -2.4),
                           width=720, height=480, focal_length=1.3)
    cameras = cameras_of({**cell.settings.simulation.cameras, 'front': front}, cell.model)
    renderer = SceneRenderer(cameras)
    renderer.load(model_to_bytes(simulation.mujoco_model))
    plant = simulation.mujoco_model, simulation.mujoco_data
    own, outside = (renderer.draw(take_snapshot(number, 0, *plant)) for number in (0, 1))
    renderer.close()
    near, far = SHADES
    shades = 255.0 * (far - np.clip(own.depth, near, far)) / (far - near)
    for name, pixels in (('world_feeding_place', outside.colour), ('camera_colour', own.colour),
                         ('camera_depth', shades.astype(np.uint8))):
        Image.fromarray(np.ascontiguousarray(pixels)).quantize(128).save(
            FOLDER / f'{name}.png', optimize=True)
        print(FOLDER / f'{name}.png')


if __name__ == '__main__':
    main()
