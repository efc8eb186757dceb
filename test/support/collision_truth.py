# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which bodies of a scene touch, found with coal alone, and scenes to ask that of."""

import itertools

import coal
import numpy as np

from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Mesh, Plane, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.objects import (
    AttachedObject,
    CollisionObject,
    ObjectOperation,
    ObjectShape,
)

ADD, REMOVE, APPEND, MOVE = ObjectOperation


def shape_of(geometry):
    """Return a coal shape, made independently of the package."""
    if isinstance(geometry, Mesh):
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(geometry.triangles), len(geometry.vertices))
        model.addVertices(geometry.vertices)
        model.addTriangles(geometry.triangles)
        model.endModel()
        return model
    if isinstance(geometry, Box):
        return coal.Box(*geometry.size)
    if isinstance(geometry, Sphere):
        return coal.Sphere(geometry.radius)
    if isinstance(geometry, Plane):
        normal = np.array([geometry.a, geometry.b, geometry.c])
        return coal.Plane(normal / np.linalg.norm(normal),
                          -geometry.d / np.linalg.norm(normal))
    kind = {Cylinder: coal.Cylinder, Cone: coal.Cone, Capsule: coal.Capsule}[type(geometry)]
    return kind(geometry.radius, geometry.length)


def truth(scene, q):
    """Return the pairs of names that touch, by every shape against every other."""
    kinematics = scene.kinematic_model
    bodies = []
    for link in kinematics.robot.links.values():
        at = kinematics.link_pose(q, link.name)
        shapes = [(shape_of(c.geometry), at @ c.origin) for c in link.collisions]
        bodies.append((link.name, link.name, (), shapes))
    for item in scene.attached.values():
        at = kinematics.link_pose(q, item.link_name) @ item.object.pose
        shapes = [(shape_of(s.geometry), at @ s.pose) for s in item.object.shapes]
        bodies.append((item.id, item.link_name, item.touch_links, shapes))
    for item in scene.objects.values():
        shapes = [(shape_of(s.geometry), item.pose @ s.pose) for s in item.shapes]
        bodies.append((item.id, '', (), shapes))
    found = set()
    for (a, la, ta, sa), (b, lb, tb, sb) in itertools.combinations(bodies, 2):
        if not (la or lb) or scene.acm.allowed(a, b):
            continue
        if la and lb and (b in ta or a in tb or (la == lb and a != la and b != lb)):
            continue
        if any(touch(*one, *other) for one in sa for other in sb):
            found.add(tuple(sorted((a, b))))
    return found


def touch(shape_1, pose_1, shape_2, pose_2):
    """Return whether two placed coal shapes touch."""
    result = coal.CollisionResult()
    coal.collide(
        shape_1, coal.Transform3s(pose_1[:3, :3], pose_1[:3, 3]),
        shape_2, coal.Transform3s(pose_2[:3, :3], pose_2[:3, 3]),
        coal.CollisionRequest(), result)
    return result.isCollision()


def states(scene, count, seed=0):
    """Return random robot states."""
    rng = np.random.default_rng(seed)
    model = scene.kinematic_model
    return rng.uniform(model.lower, model.upper, (count, model.n))


def thing(id_, geometry, at, rpy=(0, 0, 0), operation=ADD):
    """Return an update with one shape."""
    return CollisionObject(
        id_, operation, pose=pose_matrix(at, rpy), shapes=(ObjectShape(geometry),))


def clutter(scene, make_mesh):
    """Fill a scene with one object of every kind."""
    scene.apply_object(thing('box', Box((0.1, 0.2, 0.3)), (0.5, 0.4, 0.1), (0.2, 0.1, 0.5)))
    scene.apply_object(thing('ball', Sphere(0.08), (-0.5, 0.3, 0.05)))
    scene.apply_object(thing('can', Cylinder(0.06, 0.2), (0.1, -0.6, 0.0), (1.0, 0.2, 0.0)))
    scene.apply_object(thing('hat', Cone(0.1, 0.2), (-0.4, -0.5, 0.0)))
    scene.apply_object(thing('cube', make_mesh(0.15), (0.75, -0.2, 0.02), (0.3, 0.3, 0.3)))
    scene.apply_object(thing('wall', Plane(1.0, 0.2, 0.0, 0.75), (0, 0, 0)))
    scene.apply_attached(AttachedObject(
        'finger', thing('held', Capsule(0.02, 0.1), (0.95, 0.05, 0.0), (0, 1.57, 0)),
        ('finger',)))
