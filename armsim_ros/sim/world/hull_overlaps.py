# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Links that would press on each other only because the physics takes a mesh for its convex hull.

Where hulls of a robot overlap at the start or in a named state, convex parts of the meshes take
their place. Of what the joints reach elsewhere, random states are a sample: links whose hulls
overlap there though their meshes are apart pass through each other. Links of different arms on
the root, such as two robots of a cell, always collide.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import mujoco
import numpy as np

from armsim_ros.arrays import Matrix, Vector
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.meshes import Arrays, cached
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import link_poses
from armsim_ros.sim.physics.geoms import contacts
from armsim_ros.sim.physics.plant import Plant

#: Overlap that is worth a line [m].
LEAST_OVERLAP = 1e-3
#: Meshes nearer than this are not apart [m].
LEAST_GAP = 1e-4
#: Random states that are checked.
STATES = 400
#: The body that has the floor.
FLOOR_BODY = 'world'
#: Pairs that a line names.
SHOWN = 6

Pair = tuple[str, str]
Depths = dict[Pair, float]


class _Overlap(NamedTuple):
    """Two links whose hulls overlap where their meshes are apart."""

    pair: Pair
    depth: float
    where: str


def resolve_overlaps(
    plant: Plant, model: RobotModel, start: Vector
) -> tuple[list[str], list[str]]:
    """
    Let no link be pushed because its mesh's hull is larger than the mesh.

    Links that overlap at the start even as convex parts pass through each other.

    :param plant: at the start; where hulls overlap it is compiled again.
    :param start: (n,) the joints there [rad or m].
    :returns: a warning for each pair that overlaps at the start or in a named state, and a remark
        on those that overlap elsewhere.
    """
    resolver = _Resolver(plant, model)
    warnings = resolver.at_the_start()
    if not any(_is_mesh(model, link) for link in model.links):
        return warnings, []
    return warnings + resolver.in_named_states(start), resolver.elsewhere()


class _Resolver:
    """
    Changes a plant until hulls do not press where meshes are apart.

    :param plant: at the start.
    """

    def __init__(self, plant: Plant, model: RobotModel) -> None:
        self._plant, self._model = plant, model
        self._links = {plant.spec.name(name): name for name in model.links}
        self._parts: dict[str, int] = {}

    def at_the_start(self) -> list[str]:
        """Check all that overlaps now, the robot's world included."""
        mujoco.mj_forward(self._plant.model, self._plant.data)
        before = self._overlaps(self._plant.data)
        self._decompose(body for pair in before for body in pair)
        mujoco.mj_forward(self._plant.model, self._plant.data)
        found = self._overlaps(self._plant.data)
        lines = [self._parts_line(_Overlap(pair, depth, 'at the start'))
                 for pair, depth in before.items() if pair not in found]
        inseparable = [pair for pair in found if self._are_links_with_mesh(pair)]
        self._exclude(inseparable)
        return lines + [_line(pair, depth, pair in inseparable) for pair, depth in found.items()]

    def in_named_states(self, start: Vector) -> list[str]:
        """Check the named states; the other joints are at the start (n,)."""
        states, names = [], []
        for group, named in self._model.semantic.named_states.items():
            for name, values in named.items():
                states.append(self._positions({**self._named(start), **values}))
                names.append(f"in the named state '{name}' of group '{group}'")
        if not states:
            return []
        before = list(self._only_hulls(np.array(states), names))
        self._decompose(body for overlap in before for body in overlap.pair)
        left = [overlap.pair for overlap in self._only_hulls(np.array(states), names)
                if self._are_of_one_arm(overlap.pair)]
        self._exclude(left)
        return [_passing_line([overlap.pair]) if overlap.pair in left
                else self._parts_line(overlap) for overlap in before]

    def elsewhere(self) -> list[str]:
        """Check random states; what was found is kept by the content of the robot."""
        def search(_: bytes) -> Arrays:
            lower, upper = np.array([self._range(name) for name in self._plant.joint_names]).T
            random = np.random.default_rng(0).uniform(lower, upper, (STATES, len(lower)))
            states = np.array([self._positions(self._named(state)) for state in random])
            pairs = [overlap.pair for overlap in self._only_hulls(states, [''] * STATES)]
            return [np.array(pairs, dtype=np.str_).reshape(-1, 2)]

        found = cached(self._content(), '.passing', search)[0]
        pairs = [pair for pair in ((str(first), str(second)) for first, second in found)
                 if self._are_of_one_arm(pair)]
        self._exclude(pairs)
        return [_passing_line(pairs)] if pairs else []

    def _only_hulls(self, states: Matrix, names: Iterable[str]) -> Iterator[_Overlap]:
        """Yield the pairs of links whose hulls alone overlap in a state of (k, n), each once."""
        data = mujoco.MjData(self._plant.model)
        found: set[Pair] = set()
        for state, name in zip(states, names, strict=True):
            self._plant.place_in(data, state)
            poses: dict[str, Matrix] = {}
            for pair, depth in self._overlaps(data).items():
                if pair in found or not self._are_links_with_mesh(pair):
                    continue
                poses = poses or link_poses(self._model, self._named(state))
                if self._meshes_are_apart(pair, poses):
                    found.add(pair)
                    yield _Overlap(pair, depth, name)

    def _meshes_are_apart(self, pair: Pair, poses: Mapping[str, Matrix]) -> bool:
        from armsim_ros.model.coal_shapes import are_apart  # only where hulls overlap

        first, second = (
            [(shape.geometry, poses[link] @ shape.origin)
             for shape in self._model.links[link].collisions]
            for link in (self._links[body] for body in pair))
        return are_apart(first, second, LEAST_GAP)

    def _overlaps(self, data: Any) -> Depths:
        """Return pair of bodies -> how deep they overlap [m], for those with a link in them."""
        found: Depths = {}
        for contact in contacts(self._plant.model, data):
            if (contact.depth > LEAST_OVERLAP
                    and not self._links.keys().isdisjoint(contact.bodies)):
                found.setdefault(contact.bodies, contact.depth)
        return found

    def _are_links_with_mesh(self, pair: Pair) -> bool:
        return all(body in self._links for body in pair) and any(
            _is_mesh(self._model, self._links[body]) for body in pair)

    def _are_of_one_arm(self, pair: Pair) -> bool:
        """Return whether the same joint on the root carries both links, or either is the root."""
        branches = {self._branch(self._links[body]) for body in pair}
        return len(branches - {self._model.root_link}) < 2

    def _branch(self, link: str) -> str:
        """Return the link below the root that carries a link, the root itself for the root."""
        root, parents = self._model.root_link, self._model.parent_joint
        while link != root and (above := self._model.joints[parents[link]].parent) != root:
            link = above
        return link

    def _decompose(self, bodies: Iterable[str]) -> None:
        """Let links collide as the convex parts of their meshes."""
        fresh = {body for body in bodies if body in self._links and body not in self._parts
                 and _is_mesh(self._model, self._links[body])}
        counts = {body: self._plant.spec.robot.decompose(self._links[body])
                  for body in sorted(fresh)}
        self._parts.update(counts)
        if any(counts.values()):
            self._plant.recompile()

    def _exclude(self, pairs: Iterable[Pair]) -> None:
        """Let links pass through each other."""
        pairs = list(pairs)
        for first, second in pairs:
            self._plant.spec.robot.exclude(self._links[first], self._links[second])
        if pairs:
            self._plant.recompile()

    def _parts_line(self, overlap: _Overlap) -> str:
        first, second = overlap.pair
        counts = ' and '.join(f"{self._parts[body]} of '{body}'" for body in overlap.pair
                              if self._parts.get(body))
        return (f"the hulls of '{first}' and '{second}' overlap by {overlap.depth * 1e3:.1f} mm "
                f'{overlap.where}, so the physics takes convex parts: {counts}')

    def _named(self, state: Vector) -> dict[str, float]:
        """Return the active joints' positions of a state (n,)."""
        active = set(self._model.active_joints)
        return {name: float(value) for name, value
                in zip(self._plant.joint_names, state, strict=True) if name in active}

    def _positions(self, values: dict[str, float]) -> Vector:
        full = self._model.complete(values)
        return np.array([full[name] for name in self._plant.joint_names])

    def _range(self, name: str) -> tuple[float, float]:
        limits = self._model.joints[name].limits
        if np.isfinite(limits.lower) and np.isfinite(limits.upper):
            return limits.lower, limits.upper
        return -np.pi, np.pi

    def _content(self) -> bytes:
        """Return all that the overlaps depend on."""
        meshes = (part for link in self._model.links.values() for shape in link.collisions
                  if isinstance(shape.geometry, Mesh)
                  for part in (shape.geometry.vertices, shape.geometry.triangles))
        texts = (mujoco.__version__, self._model.urdf, self._model.srdf)
        return b''.join((*(text.encode() for text in texts), *(part.tobytes() for part in meshes)))


def _is_mesh(model: RobotModel, link: str) -> bool:
    return any(isinstance(shape.geometry, Mesh) for shape in model.links[link].collisions)


def _line(pair: Pair, depth: float, passes: bool) -> str:
    first, second = ('the floor' if body == FLOOR_BODY else f"'{body}'" for body in sorted(
        pair, key=lambda body: body != FLOOR_BODY))
    text = f'{first} and {second} overlap by {depth * 1e3:.1f} mm at the start'
    if FLOOR_BODY in pair:
        return (f"{text}; raise the robot (simulation.yaml: placement), or lower the world's "
                'floor')
    if passes:
        return (f'{text} and pass through each other in the physics; move the robot, or disable '
                'the pair in the SRDF')
    return f'{text}; move the robot or the object, or disable the pair in the SRDF'


def _passing_line(pairs: list[Pair]) -> str:
    names = ', '.join(f"'{first}' and '{second}'" for first, second in pairs[:SHOWN])
    more = f' and {len(pairs) - SHOWN} more pairs' if len(pairs) > SHOWN else ''
    return (f'the convex hulls of {names}{more} overlap where their meshes are apart, so they '
            'pass through each other in the physics')
