# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""mplib: OMPL's RRTConnect and FCL in C++, toppra on a spline; everything at its default."""

from __future__ import annotations

import os
import pathlib
import tempfile
from typing import Any
import xml.etree.ElementTree as ElementTree

import mplib
from mplib.collision_detection import fcl
import numpy as np
from worker import serve


class Planner:
    """mplib's planner."""

    def __init__(self, robot: dict[str, Any]) -> None:
        """Read the robot; its last joint's link is the end effector."""
        folder = tempfile.mkdtemp()
        tree = ElementTree.parse(robot['urdf'])
        root = tree.getroot()
        for mesh in root.iter('mesh'):  # it puts the folder before every path
            path = without_lines(pathlib.Path(mesh.attrib['filename']), folder)
            mesh.set('filename', os.path.relpath(path, folder))
        urdf = pathlib.Path(folder, 'mplib.urdf')
        tree.write(urdf)
        tip = next(
            child.get('link') for joint in root.findall('joint')
            if joint.get('name') == robot['joints'][-1] for child in joint.findall('child'))
        count = len(robot['joints'])
        self.planner = mplib.Planner(
            urdf, tip, srdf=robot['srdf'],
            joint_vel_limits=np.full(count, robot['velocity']),
            joint_acc_limits=np.full(count, robot['acceleration']))
        self.present: list[str] = []

    def prepare(self, problem: dict[str, Any]) -> None:
        """Replace the obstacles."""
        world = self.planner.planning_world
        for name in self.present:
            world.remove_object(name)
        self.present = []
        for each in problem['obstacles']:
            x, y, z, w = each['quat_xyzw']
            shape = (
                fcl.Box(*each['size']) if each['type'] == 'box'
                else fcl.Cylinder(each['radius'], each['length']))
            pose = mplib.Pose(np.array(each['position']), np.array([w, x, y, z]))
            world.add_object(each['id'], fcl.CollisionObject(shape, pose))
            self.present.append(each['id'])

    def plan(self, problem: dict[str, Any], seed: int, seconds: float) -> dict[str, Any]:
        """Plan with a range of 0.1 rad, simplify, time."""
        answer = self.planner.plan_qpos(
            [np.array(problem['goal'])], np.array(problem['start']), time_step=0.01,
            planning_time=float(seconds))
        if answer['status'] != 'Success':
            return {'message': str(answer['status'])}
        return {'times': answer['time'], 'positions': answer['position']}


def without_lines(path: pathlib.Path, folder: str) -> pathlib.Path:
    """Return an OBJ file without faces of two corners, which it refuses; others as they are."""
    if path.suffix.lower() != '.obj':
        return path
    copy = pathlib.Path(folder, path.name)
    copy.write_text(''.join(
        line for line in path.read_text(encoding='utf-8').splitlines(keepends=True)
        if not line.startswith(('l ', 'mtllib', 'usemtl'))
        and not (line.startswith('f ') and len(line.split()) < 4)), encoding='utf-8')
    return copy


if __name__ == '__main__':
    serve(Planner)
