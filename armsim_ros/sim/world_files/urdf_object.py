# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A URDF as a rigid object."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import ModelError
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.inertia import combined, inertial_of
from armsim_ros.model.robot_model import Inertial, JointType, LinkGeometry
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.world_files.loaded import Fault, LoadedObject, ResourceFaultError, Unused

MeshReader = Callable[[str, tuple[float, float, float]], Mesh]


def urdf_object(text: str, file: str, read_mesh: MeshReader) -> LoadedObject:
    """
    Return a URDF as an object that moves freely; its joints are fixed at 0.

    :raises ResourceFaultError: the text is wrong; with its line.
    """
    try:
        content = parse_urdf(text, file, read_mesh=read_mesh)
    except ModelError as error:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, str(error)) from None
    unused = Unused()
    for problem in content.problems:
        unused.add(str(problem))
    poses: dict[str, Matrix] = {content.root_link: np.eye(4)}
    for joint in content.joints.values():
        poses[joint.child] = poses[joint.parent] @ joint.origin
        if joint.type is not JointType.FIXED:
            unused.add(f"joint '{joint.name}' of type '{joint.type.value}': its links hold "
                       'together')
    parts: list[LinkGeometry] = []
    inertials: list[Inertial] = []
    for name, link in content.links.items():
        color = next((shape.rgba for shape in link.visuals if shape.rgba), None)
        parts += [LinkGeometry(shape.geometry, poses[name] @ shape.origin,
                               rgba=shape.rgba or color) for shape in link.collisions]
        if link.inertial is not None:
            inertials.append(Inertial(link.inertial.mass, poses[name] @ link.inertial.origin,
                                      link.inertial.inertia))
    if not parts:
        raise ResourceFaultError(
            Fault.RESOURCE_PARSE_ERROR, f"{file}: '{content.name}' has no <collision>")
    whole = combined(inertials) if inertials else inertial_of(parts)
    item = WorldObject(content.name, np.eye(4), tuple(parts), whole.mass, inertial=whole)
    return LoadedObject(item, unused.lines)
