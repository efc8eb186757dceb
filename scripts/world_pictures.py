# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Draws the pictures of docs/world.md: the feeding place, what sunday's camera sees, what it avoids.

    .venv/bin/python scripts/world_pictures.py
"""

import itertools
import os
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.nodes.camera.program import choose_backend, VARIABLE

FOLDER = Path(__file__).parents[1] / 'docs' / 'images'
STATE = 'scan_food'
#: Depths that are drawn black and white [m].
SHADES = (0.37, 0.45)


#: What only the camera sees, and between which states of the arm it is in the way.
POST, PLACE = Box((0.05, 0.05, 0.28)), (0.166, 0.16, 1.155)
SIDES = [{f'joint_{number}': value for number, value in enumerate(
    (turn, 0.3, 1.6, 0.27, 1.57, 0.0), 1)} for turn in (-0.8, 0.8)]
#: Radius of the line of the tool [m], and its colour.
LINE, BLUE = 0.004, (0.26, 0.52, 0.96, 1.0)


def main() -> None:
    """Draw all."""
    os.environ[VARIABLE] = choose_backend(os.environ)
    feeding_place()
    octomap()


def octomap() -> None:
    """Let the arm see a post, and draw the cells and the way around it."""
    import mujoco

    from armsim_ros import ArmSim
    from armsim_ros.model.world_objects import WorldObject
    from armsim_ros.nodes.web.parts.octomap import height_colors

    sim = ArmSim('sunday', overrides={'planning_parameters.scene_from_world': 'false'})
    sim.simulation.world.add(WorldObject.of_shape('post', POST, pose_matrix(PLACE)))
    sim.execute(sim.plan(STATE))
    sim.look('camera')
    view = mujoco.MjvCamera()
    view.lookat[:], view.distance, view.azimuth, view.elevation = (0.1, 0.1, 1.2), 1.0, 235, -25

    def draw(name: str, motion: Any) -> None:
        model = sim.simulation.mujoco_model
        model.vis.headlight.ambient[:], model.vis.headlight.diffuse[:] = 0.45, 0.5
        model.vis.global_.offwidth, model.vis.global_.offheight = 720, 480
        with mujoco.Renderer(model, 480, 720, max_geom=20000) as renderer:
            renderer.update_scene(sim.simulation.mujoco_data, view)
            scene, octomap = renderer.scene, sim.scene.octomap
            assert octomap is not None
            centres, edges = octomap.boxes

            def add(kind: int, size: np.ndarray, place: np.ndarray, rgba: np.ndarray) -> object:
                geom = scene.geoms[scene.ngeom]
                mujoco.mjv_initGeom(geom, kind, size, place, np.eye(3).ravel(), rgba)
                scene.ngeom += 1
                return geom

            for place, edge, color in zip(
                    centres, edges, height_colors(centres[:, 2]), strict=True):
                add(mujoco.mjtGeom.mjGEOM_BOX, np.full(3, 0.48 * edge), place,
                    np.append(color / 255.0, 1.0).astype(np.float32))
            places = [] if motion is None else [sim.scene.kinematic_model.link_pose(
                sim.scene.kinematic_model.vector(dict(zip(
                    motion.joint_names, q, strict=True)), sim.scene.q), 'link_6')[:3, 3]
                for q in motion.positions]
            for begin, end in itertools.pairwise(places):
                geom = add(mujoco.mjtGeom.mjGEOM_CAPSULE, np.zeros(3), np.zeros(3),
                           np.array(BLUE, dtype=np.float32))
                mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_CAPSULE, LINE, begin, end)
            save(name, renderer.render())

    draw('octomap_cells', None)
    sim.execute(sim.plan(SIDES[0]))
    draw('octomap_path', sim.plan(SIDES[1]))


def save(name: str, pixels: np.ndarray) -> None:
    """Write a picture."""
    Image.fromarray(np.ascontiguousarray(pixels)).quantize(128).save(
        FOLDER / f'{name}.png', optimize=True)
    print(FOLDER / f'{name}.png')


def feeding_place() -> None:
    """Let the things come to rest below the camera, and draw."""
    # Only now: MuJoCo is imported, which looks once at what is to draw.
    from armsim_ros.cli.arguments import parse_arguments
    from armsim_ros.cli.settings import cell_of
    from armsim_ros.config.simulation import CameraSettings
    from armsim_ros.sim.assembly import build_simulation
    from armsim_ros.sim.camera import cameras_of, take_snapshot
    from armsim_ros.sim.physics.compiler import model_to_bytes
    from armsim_ros.sim.scene_renderer import SceneRenderer

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
        save(name, pixels)


if __name__ == '__main__':
    main()
