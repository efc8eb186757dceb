# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Proven bounds of how far two placed shapes are apart, found without a collision library.

Separation is the distance of two shapes that are apart, and minus the depth of two that overlap.
A lower bound is proved by a direction in which the shapes leave a gap, an upper one by a point of
both of them; signed distances and the separating axis test give both.
"""

import itertools

import numpy as np

from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Mesh, Plane, Sphere

_HALVINGS = 45
_AROUND = np.array([[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)
                    if x or y or z], float)
_AROUND /= np.linalg.norm(_AROUND, axis=1)[:, None]


def _dot(a, b):
    return np.einsum('...i,...i->...', a, b)


def _norm(a):
    return np.sqrt(_dot(a, a))


class Round:
    """A cylinder or cone along z: the meridian is a polygon in (distance from the axis, z)."""

    def __init__(self, bottom, top, length):
        self.bottom, self.top, self.half = bottom, top, 0.5 * length
        self.size = max(bottom, self.half)
        slope = np.array([length, bottom - top])
        self._out = slope / np.linalg.norm(slope)
        ring = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        circle = np.column_stack([np.cos(ring), np.sin(ring), 0 * ring])
        self.samples = np.vstack([
            share * (bottom + (top - bottom) * (0.5 + 0.5 * z)) * circle + [0, 0, z * self.half]
            for z in np.linspace(-0.9999, 0.9999, 7) for share in (0.0, 0.5, 0.9999)])
        self.normals = np.array([[0, 0, 1.0], [0, 0, -1.0]])

    def outside(self, x):
        around, z = np.hypot(x[..., 0], x[..., 1]), x[..., 2]
        side = (around - self.bottom) * self._out[0] + (z + self.half) * self._out[1]
        return np.maximum(np.abs(z) - self.half, side)

    def signed_distance(self, x):
        point = np.stack([np.hypot(x[..., 0], x[..., 1]), x[..., 2]], -1)
        corners = np.array([[0, -self.half], [self.bottom, -self.half], [self.top, self.half],
                            [0, self.half]])
        apart = np.minimum.reduce([
            _to_segment(point, *edge) for edge in itertools.pairwise(corners)])
        inside = self.outside(x)
        return np.where(inside <= 0, inside, apart)

    def support(self, d):
        around = np.hypot(d[..., 0], d[..., 1])
        out = np.where(around[..., None] > 0, d[..., :2] / np.maximum(around, 1e-300)[..., None],
                       0.0)
        low = self.bottom * around - self.half * d[..., 2]
        high = self.top * around + self.half * d[..., 2]
        up = high > low
        radius = np.where(up, self.top, self.bottom)
        return np.concatenate([out * radius[..., None],
                               np.where(up, self.half, -self.half)[..., None]], -1)


class Ball:
    """A sphere, or a capsule along z."""

    def __init__(self, radius, length=0.0):
        self.radius, self.half = radius, 0.5 * length
        self.size = radius + self.half

    def signed_distance(self, x):
        x = x - np.stack([0 * x[..., 2], 0 * x[..., 2],
                          np.clip(x[..., 2], -self.half, self.half)], -1)
        return _norm(x) - self.radius

    outside = signed_distance

    def support(self, d):
        end = np.zeros_like(d)
        end[..., 2] = np.where(d[..., 2] > 0, self.half, -self.half)
        return end + self.radius * d / _norm(d)[..., None]


class Polytope:
    """The convex hull of vertices with the faces' normals (f, 3) and directions of edges."""

    def __init__(self, vertices, normals, edges, triangles):
        self.vertices, self.normals, self.edges = vertices, normals, edges
        self.size = float(np.abs(vertices).max())
        self._triangles = triangles
        self._offsets = (normals @ vertices.T).max(axis=1)
        self.flat = len(vertices) == 3
        weights = np.random.default_rng(1).dirichlet(np.full(len(vertices), 0.3), 200)
        self.samples = np.vstack([vertices, weights @ vertices])

    @classmethod
    def hull(cls, mesh):
        """Return the body inside of a convex mesh."""
        corners = mesh.vertices[mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= _norm(normals)[:, None]
        edges = np.vstack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 1],
                           corners[:, 0] - corners[:, 2]])
        return cls(mesh.vertices, _different(normals), _different(edges, True),
                   _Triangles(corners))

    @classmethod
    def triangle(cls, corners):
        """Return a triangle (3, 3), flat as it is."""
        edges = corners - np.roll(corners, 1, axis=0)
        normal = np.cross(edges[0], edges[1])
        normal /= np.linalg.norm(normal)
        sides = np.cross(edges, normal)
        sides /= _norm(sides)[:, None]
        sides *= np.where(_dot(sides, corners - corners.mean(axis=0)) < 0, -1, 1)[:, None]
        return cls(corners, np.vstack([normal, -normal, sides]), edges / _norm(edges)[:, None],
                   _Triangles(corners[None]))

    def support(self, d):
        return self.vertices[np.argmax(d @ self.vertices.T, axis=-1)]

    def outside(self, x):
        return (x @ self.normals.T - self._offsets).max(axis=-1)

    def signed_distance(self, x):
        inside = self.outside(x)
        return np.where(inside < 0, inside, self._triangles.distance(x))


class Block(Polytope):
    """A box."""

    def __init__(self, size):
        self._half = 0.5 * np.asarray(size)
        mesh = box_mesh(size)
        super().__init__(mesh.vertices, np.vstack([np.eye(3), -np.eye(3)]), np.eye(3), None)

    def signed_distance(self, x):
        off = np.abs(x) - self._half
        return _norm(np.maximum(off, 0.0)) + np.minimum(off.max(axis=-1), 0.0)


class Wall:
    """A thin plane with its normal [unit] and its way from the frame's origin [m]."""

    def __init__(self, plane):
        normal = np.array([plane.a, plane.b, plane.c])
        self.normal = normal / np.linalg.norm(normal)
        self.offset = -plane.d / np.linalg.norm(normal)
        self.size = 1.0


class Surface:
    """Triangles with nothing inside."""

    def __init__(self, mesh):
        self.parts = [Polytope.triangle(mesh.vertices[each]) for each in mesh.triangles]
        self.size = float(np.abs(mesh.vertices).max())
        self.support = Polytope.hull(mesh).support


def solid(shape, surface=True):
    """Return the form of a shape that this module computes with; meshes as bodies on request."""
    if isinstance(shape, Box):
        return Block(shape.size)
    if isinstance(shape, Sphere):
        return Ball(shape.radius)
    if isinstance(shape, Capsule):
        return Ball(shape.radius, shape.length)
    if isinstance(shape, Cylinder):
        return Round(shape.radius, shape.radius, shape.length)
    if isinstance(shape, Cone):
        return Round(shape.radius, 0.0, shape.length)
    if isinstance(shape, Plane):
        return Wall(shape)
    return Surface(shape) if surface else Polytope.hull(shape)


def box_mesh(size):
    """Return a box as twelve triangles."""
    x, y, z = 0.5 * np.asarray(size)
    vertices = np.array([[i, j, k] for i in (-x, x) for j in (-y, y) for k in (-z, z)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(vertices, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]))


class Placed:
    """A form at k poses: rotations (k, 3, 3) and positions (k, 3)."""

    def __init__(self, form, rotations, positions):
        self.form, self.turn, self.at = form, rotations, positions

    def part(self, form):
        return Placed(form, self.turn, self.at)

    def signed_distance(self, x):
        """Return the distance of points (k, p, 3)."""
        return self.form.signed_distance((x - self.at[:, None]) @ self.turn)

    def outside(self, x):
        """Return how far points (k, p, 3) are beyond its faces; the depth, negative, within."""
        return self.form.outside((x - self.at[:, None]) @ self.turn)

    def reach(self, d):
        """Return how far it goes in directions (k, m, 3)."""
        own = d @ self.turn
        return _dot(self.form.support(own), own) + _dot(d, self.at[:, None])

    def support(self, d):
        """Return the outmost points (k, 3) in directions (k, 3)."""
        own = np.einsum('kji,kj->ki', self.turn, d)
        return np.einsum('kij,kj->ki', self.turn, self.form.support(own)) + self.at

    def points(self, own):
        """Return points (p, 3) of its frame in the world (k, p, 3)."""
        return own @ self.turn.transpose(0, 2, 1) + self.at[:, None]


def separation(a, b):
    """Return bounds (low (k,), high (k,)) [m] of the separation of two placed shapes."""
    for one, other in ((a, b), (b, a)):
        if isinstance(one.form, Surface):
            bounds = [separation(one.part(part), other) for part in one.form.parts]
            return tuple(np.minimum.reduce(each) for each in zip(*bounds, strict=True))
    for one, other in ((a, b), (b, a)):
        if isinstance(one.form, Wall):
            return (_from_plane(one, other),) * 2
    for one, other in ((a, b), (b, a)):
        if isinstance(one.form, Ball):
            return (_from_segment(one, other),) * 2
    if isinstance(a.form, Polytope) and isinstance(b.form, Polytope):
        gap = _widest_gap(a, b, _axes(a, b))
        return gap, np.where(gap < 0, gap, np.inf)
    return _certified(a, b)


def _from_plane(wall, other):
    normal = (wall.turn @ wall.form.normal)[:, None]
    offset = wall.form.offset + _dot(normal, wall.at[:, None])[:, 0]
    above = other.reach(normal)[:, 0] - offset
    below = other.reach(-normal)[:, 0] + offset
    return -np.minimum(above, below)


def _from_segment(ball, other):
    """Minimise the other's distance, which is convex, along the axis of a ball or capsule."""
    def at(share):
        return other.signed_distance((ball.at + (share * ball.form.half)[:, None] * axis)[:, None])

    axis = ball.turn[:, :, 2]
    low, high = -np.ones(len(axis)), np.ones(len(axis))
    best = np.minimum(at(low)[:, 0], at(high)[:, 0])
    for _ in range(_HALVINGS if ball.form.half else 1):
        first, second = (2 * low + high) / 3, (low + 2 * high) / 3
        one, two = at(first)[:, 0], at(second)[:, 0]
        best = np.minimum(best, np.minimum(one, two))
        low, high = np.where(one > two, first, low), np.where(one > two, high, second)
    return best - ball.form.radius


def _axes(a, b):
    """Return the axes (k, m, 3) that the separating axis test of two polytopes needs."""
    def crossed(ones, others):
        found = np.cross(ones[:, :, None], others[:, None]).reshape(len(ones), -1, 3)
        length = _norm(found)[..., None]
        return np.where(length > 1e-7, found / np.maximum(length, 1e-300), [1.0, 0.0, 0.0])

    turned = [(each.form.normals @ each.turn.transpose(0, 2, 1),
               each.form.edges @ each.turn.transpose(0, 2, 1)) for each in (a, b)]
    return np.concatenate([turned[0][0], -turned[1][0], crossed(turned[0][1], turned[1][1])], 1)


def _widest_gap(a, b, axes):
    along = -b.reach(-axes) - a.reach(axes)
    back = -a.reach(-axes) - b.reach(axes)
    return np.maximum(along, back).max(axis=1)


def _certified(a, b):
    """Bound by gaps in many directions, and by points that are deep in both."""
    axis_a, axis_b = a.turn[:, :, 2], b.turn[:, :, 2]
    between = b.at - a.at
    pointed = [axis_a, axis_b, between, *(
        between - _dot(between, axis)[:, None] * axis for axis in (axis_a, axis_b)),
        np.cross(axis_a, axis_b)]
    directions = np.stack(pointed, 1)
    length = _norm(directions)[..., None]
    directions = np.where(length > 1e-9, directions / np.maximum(length, 1e-300), [1.0, 0, 0])
    faces = [each.form.normals @ each.turn.transpose(0, 2, 1) for each in (a, b)]
    low = _widest_gap(a, b, np.concatenate([directions, *faces], 1))

    flat = [each for each in (a, b) if isinstance(each.form, Polytope) and each.form.flat]
    thick = [each for each in (a, b) if each not in flat]

    def worse(points):
        return np.maximum.reduce([each.outside(points) for each in thick])

    points = np.concatenate([each.points(each.form.samples) for each in flat or thick], 1)
    values = worse(points)
    best = np.argmin(values, axis=1)
    place = points[np.arange(len(best)), best]
    value = values[np.arange(len(best)), best]
    if flat:  # its own points only
        return low, np.where(value < 0, value, np.inf)
    step = np.full(len(best), 0.25 * min(a.form.size, b.form.size))
    for _ in range(_HALVINGS):
        around = place[:, None] + step[:, None, None] * _AROUND
        values = worse(around)
        best = np.argmin(values, axis=1)
        found = values[np.arange(len(best)), best]
        better = found < value
        place = np.where(better[:, None], around[np.arange(len(best)), best], place)
        value = np.where(better, found, value)
        step = np.where(better, step, 0.6 * step)
    return low, np.where(value < 0, value, np.inf)


def _to_segment(x, a, b):
    a, b = np.asarray(a, float), np.asarray(b, float)
    way = b - a
    share = np.clip((x - a) @ way / max(float(way @ way), 1e-300), 0.0, 1.0)
    return _norm(x - a - share[..., None] * way)


class _Triangles:
    """Triangles (t, 3, 3), to find distances to."""

    def __init__(self, corners):
        self._corners = corners
        self._ways = np.roll(corners, -1, axis=1) - corners
        self._squares = _dot(self._ways, self._ways)
        normals = np.cross(self._ways[:, 0], self._ways[:, 1])
        self._normals = normals / _norm(normals)[:, None]
        self._inward = np.cross(self._normals[:, None], self._ways)

    def distance(self, x):
        """Return the distance of points (..., 3) from the nearest triangle."""
        from_corners = x[..., None, None, :] - self._corners
        within = (_dot(from_corners, self._inward) >= 0).all(axis=-1)
        share = np.clip(_dot(from_corners, self._ways) / self._squares, 0.0, 1.0)
        edges = _norm(from_corners - share[..., None] * self._ways).min(axis=-1)
        above = np.abs(_dot(from_corners[..., 0, :], self._normals))
        return np.where(within, above, edges).min(axis=-1)


def _different(directions, both_ways=False):
    """Return those of the directions that are not (nearly) another, as unit vectors."""
    kept = []
    for each in directions / _norm(directions)[:, None]:
        if not any(abs(each @ one) > 1 - 1e-12 if both_ways else each @ one > 1 - 1e-12
                   for one in kept):
            kept.append(each)
    return np.array(kept)
