# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Objects and worlds in MJCF, MuJoCo's own format: bodies, geoms, free joints, materials, gravity.

MuJoCo itself reads the text, so defaults and orientations mean what they mean there. It gets no
files: meshes are read here, from the folders that are allowed, and handed over.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.errors import SimulationError
from armsim_ros.model.description.xml_tree import xml_text, XmlElement
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Geometry, Mesh, Plane, Sphere
from armsim_ros.model.inertia import combined
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import inverse_pose, matrix_from_quat_wxyz, pose_from_parts
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.sim.physics.compiler import compile_model
from armsim_ros.sim.world.loaded_world import (
    ASSET_FAULTS,
    check_names,
    Fault,
    LoadedObject,
    LoadedWorld,
    parse,
    ResourceFaultError,
    Unused,
)

MeshReader = Callable[[str, tuple[float, float, float]], Mesh]

#: Elements at the top that shape what is read.
_READ = ('compiler', 'default', 'asset', 'worldbody')
_IN_ASSET = ('mesh', 'material')
_PATHS = ('meshdir', 'texturedir', 'assetdir', 'strippath')
_KINDS = mujoco.mjtGeom
#: What a floor has in any world: MuJoCo's own default.
_FLOOR_FRICTION = 1.0


def mjcf_object(text: str, file: str, read_mesh: MeshReader) -> LoadedObject:
    """
    Return the first body of an MJCF text as an object.

    :raises ResourceFaultError: the text is wrong, or it has no body.
    """
    model, unused = _compiled(text, file, read_mesh)
    reader = _Reader(model, unused)
    tops = [body for body in range(1, model.nbody) if model.body_parentid[body] == 0]
    if not tops:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, f'{file}: it has no <body>')
    if _tells_gravity(text, file):
        unused.add('gravity of <option>: an object has none')
    for body in tops[1:]:
        unused.add(f"body '{model.body(body).name}': an object is a single body")
    item = reader.item(tops[0])
    return LoadedObject(replace(item, name=model.body(tops[0]).name), unused.lines)


def mjcf_world(text: str, file: str, read_mesh: MeshReader, *, ignore_assets: bool = False
               ) -> LoadedWorld:
    """
    Return the world of an MJCF text.

    :param ignore_assets: leave out meshes that are missing or cannot be read.
    :raises ResourceFaultError: the text is wrong.
    """
    model, unused = _compiled(text, file, read_mesh, ignore_assets)
    reader = _Reader(model, unused)
    x, y, z = (float(value) for value in model.opt.gravity)
    items = [reader.item(body) for body in range(1, model.nbody) if model.body_parentid[body] == 0]
    floor: float | None = None
    for name, part, friction in reader.geoms(0, np.eye(4)):
        if floor is None and _is_level(part):
            floor = float(part.origin[2, 3])
            if friction != _FLOOR_FRICTION:
                unused.add(f"friction of geom '{name}': it is the floor")
            continue
        items.append(WorldObject(name, part.origin, (
            LinkGeometry(part.geometry, np.eye(4), rgba=part.rgba),), friction=friction))
    check_names(items)
    gravity = (x, y, z) if _tells_gravity(text, file) else None
    name = parse(text, file).get('model') or 'world'
    return LoadedWorld(name, tuple(items), floor, unused.lines, gravity)


class _Shape(NamedTuple):
    """A geom that touches."""

    name: str
    part: LinkGeometry
    friction: float


def _is_level(part: LinkGeometry) -> bool:
    """Return whether a shape is a plane that faces up."""
    return isinstance(part.geometry, Plane) and np.allclose(part.origin[:3, 2], (0.0, 0.0, 1.0))


class _Reader:
    """Takes a compiled model apart; it is in its first pose."""

    def __init__(self, model: Any, unused: Unused) -> None:
        self._model, self._unused = model, unused
        self._data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, self._data)

    def item(self, top: int) -> WorldObject:
        """Return a body at the top with all that hangs on it as an object."""
        model = self._model
        name = model.body(top).name or f'body_{top}'
        inside = [body for body in range(top, model.nbody) if model.body_rootid[body] == top]
        free = False
        for body in inside:
            start = int(model.body_jntadr[body])
            for joint in range(start, start + int(model.body_jntnum[body])):
                if body == top and model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
                    free = True
                else:
                    self._unused.add(f"joint '{model.joint(joint).name}' of body '{name}': its "
                                     'bodies hold together')
        pose = pose_from_parts(
            self._data.xpos[top], matrix_from_quat_wxyz(self._data.xquat[top]))
        to_top = inverse_pose(pose)
        found = [geom for body in inside for geom in self.geoms(body, to_top)]
        if not found:
            raise ResourceFaultError(
                Fault.RESOURCE_PARSE_ERROR, f"body '{name}' has no <geom> that touches anything")
        parts, friction = tuple(shape.part for shape in found), found[0].friction
        if not free:
            return WorldObject(name, pose, parts, None, friction)
        heavy = [body for body in inside if model.body_mass[body] > 0.0]
        if not heavy:
            raise ResourceFaultError(
                Fault.RESOURCE_PARSE_ERROR, f"body '{name}' is free and has no mass")
        whole = combined([self._inertial(body, to_top) for body in heavy])
        floating = float(model.body_mass[heavy] @ model.body_gravcomp[heavy])
        return WorldObject(
            name, pose, parts, whole.mass, friction, whole, floating / whole.mass)

    def geoms(self, body: int, frame: Matrix) -> list[_Shape]:
        """
        Return the shapes of a body that touch.

        :param frame: (4, 4) from the world to the frame of the poses.
        """
        model, found = self._model, list[_Shape]()
        start = int(model.body_geomadr[body])
        for geom in range(start, start + int(model.body_geomnum[body])):
            name = model.geom(geom).name or f'geom_{geom}'
            if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
                self._unused.add(f"geom '{name}': it touches nothing")
                continue
            geometry = self._geometry(geom)
            if geometry is None:
                self._unused.add(f"geom '{name}' of type {_KINDS(model.geom_type[geom]).name}")
                continue
            pose = pose_from_parts(
                self._data.geom_xpos[geom], self._data.geom_xmat[geom].reshape(3, 3))
            red, green, blue, alpha = (float(value) for value in model.geom_rgba[geom])
            material = int(model.geom_matid[geom])
            if material >= 0:
                red, green, blue, alpha = (float(v) for v in model.mat_rgba[material])
            part = LinkGeometry(geometry, frame @ pose, rgba=(red, green, blue, alpha))
            found.append(_Shape(name, part, float(model.geom_friction[geom, 0])))
        return found

    def _geometry(self, geom: int) -> Geometry | None:
        model, kind = self._model, int(self._model.geom_type[geom])
        x, y, z = (float(value) for value in model.geom_size[geom])
        if kind == _KINDS.mjGEOM_BOX:
            return Box((2.0 * x, 2.0 * y, 2.0 * z))
        if kind == _KINDS.mjGEOM_SPHERE:
            return Sphere(x)
        if kind == _KINDS.mjGEOM_CYLINDER:
            return Cylinder(x, 2.0 * y)
        if kind == _KINDS.mjGEOM_CAPSULE:
            return Capsule(x, 2.0 * y)
        if kind == _KINDS.mjGEOM_PLANE:
            return Plane(0.0, 0.0, 1.0, 0.0)
        if kind != _KINDS.mjGEOM_MESH:
            return None
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        return Mesh(np.array(model.mesh_vert[first:first + count], dtype=np.float64),
                    np.array(model.mesh_face[face:face + faces], dtype=np.int64))

    def _inertial(self, body: int, frame: Matrix) -> Inertial:
        pose = pose_from_parts(self._data.xipos[body], self._data.ximat[body].reshape(3, 3))
        return Inertial(float(self._model.body_mass[body]), frame @ pose,
                        np.diag(self._model.body_inertia[body]))


def _compiled(text: str, file: str, read_mesh: MeshReader, ignore_assets: bool = False
              ) -> tuple[Any, Unused]:
    """Return the ``MjModel`` of a text without what is not read, and what that was."""
    root = parse(text, file)
    unused, meshes = Unused(), list[tuple[str, Mesh]]()
    for child in list(root.children):
        if child.tag == 'option':
            for word in sorted({*child.attributes, *(inner.tag for inner in child.children)}):
                if word != 'gravity':
                    unused.add(
                        f'{word} of <option>: the simulation keeps its own, see simulation.yaml')
                    child.attributes.pop(word, None)
            child.children.clear()
        elif child.tag not in _READ:
            unused.add(f'<{child.tag}>')
            root.children.remove(child)
    folder = ''
    for compiler in root.all('compiler'):
        folder = compiler.get('meshdir') or compiler.get('assetdir') or folder
        for word in _PATHS:
            compiler.attributes.pop(word, None)
    for asset in root.all('asset'):
        missing = _take_meshes(asset, folder, read_mesh, meshes, unused, ignore_assets)
        if missing:
            _leave_out(root, missing)
    _clean(root, unused)
    try:
        spec = mujoco.MjSpec.from_string(xml_text(root))
        for name, mesh in meshes:
            added = spec.add_mesh(name=name)
            added.uservert = np.asarray(mesh.vertices, dtype=np.float64).ravel()
            added.userface = np.asarray(mesh.triangles, dtype=np.int32).ravel()
            added.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        return compile_model(spec), unused
    except (ValueError, RuntimeError, mujoco.FatalError, SimulationError) as error:
        text = ' '.join(str(error).split())
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, f'{file}: {text}') from None


def _take_meshes(asset: XmlElement, folder: str, read_mesh: MeshReader,
                 meshes: list[tuple[str, Mesh]], unused: Unused, ignore_assets: bool
                 ) -> set[str]:
    """Read meshes and take them out of the text; return the names of those that are left out."""
    missing: set[str] = set()
    for child in list(asset.children):
        if child.tag not in _IN_ASSET:
            unused.add(f"<{child.tag} name='{child.get('name')}'>")
            asset.children.remove(child)
        elif child.tag == 'mesh' and child.get('file'):
            file = child.get('file')
            name = child.get('name') or file.rsplit('/', 1)[-1].rsplit('.', 1)[0]
            words = child.get('scale', '1 1 1').split()
            try:
                x, y, z = (float(word) for word in words)
            except ValueError:
                raise ResourceFaultError(
                    Fault.RESOURCE_PARSE_ERROR,
                    f"{child.where}: scale is '{' '.join(words)}'; allowed: 3 numbers") from None
            asset.children.remove(child)
            try:
                meshes.append((name, read_mesh(f'{folder}/{file}' if folder else file, (x, y, z))))
            except ResourceFaultError as error:
                if not ignore_assets or error.fault not in ASSET_FAULTS:
                    raise
                unused.add(f'left out: {error}')
                missing.add(name)
    return missing


def _leave_out(element: XmlElement, meshes: set[str]) -> None:
    """Take out the shapes that are made of some meshes, and bodies without any other."""
    for child in list(element.children):
        _leave_out(child, meshes)
        gone = child.tag == 'geom' and child.get('mesh') in meshes
        shapes = any(inner.tag in ('geom', 'body') for inner in child.children)
        if gone or (child.tag == 'body' and not shapes):
            element.children.remove(child)


def _clean(element: XmlElement, unused: Unused) -> None:
    """Take out all that would have MuJoCo read a file or load a library."""
    for child in list(element.children):
        if child.tag in ('include', 'plugin', 'replicate', 'composite', 'flexcomp', 'attach'):
            unused.add(f'<{child.tag}>')
            element.children.remove(child)
            continue
        for word in ('texture', 'file'):
            if child.attributes.pop(word, None):
                unused.add(f'{word} of <{child.tag}>')
        _clean(child, unused)


def _tells_gravity(text: str, file: str) -> bool:
    return any(option.get('gravity') for option in parse(text, file).all('option'))
