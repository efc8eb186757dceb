# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Differences of scenes, as those apply them who follow."""

from hypothesis import given, settings
from hypothesis import strategies as st
from scene_summary import summary

from armsim_ros.errors import PlanningError
from armsim_ros.model.geometry import Box, Sphere
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.planning.scene.difference import scene_difference
from armsim_ros.planning.scene.planning_scene import PlanningScene
from armsim_ros.planning.scene.update import (
    AttachedObjectUpdate,
    CollisionObjectUpdate,
    ObjectOperation,
    SceneUpdate,
)

ADD, REMOVE, APPEND, MOVE = ObjectOperation


IDS = st.sampled_from(['a', 'b', 'c'])
POSES = st.tuples(*[st.floats(-1, 1)] * 3).map(pose_matrix)
EDITS = st.one_of(
    st.builds(lambda i, p: ('object', CollisionObjectUpdate(i, ADD, pose=p,
                                                            primitives=(Sphere(0.1),))),
              IDS, POSES),
    st.builds(lambda i, p: ('object', CollisionObjectUpdate(i, MOVE, pose=p)), IDS, POSES),
    st.builds(lambda i, p: ('object', CollisionObjectUpdate(i, APPEND, 'fore', p,
                                                            (Box((0.1, 0.1, 0.1)),))),
              IDS, POSES),
    st.builds(lambda i: ('object', CollisionObjectUpdate(i, REMOVE)), IDS),
    st.builds(lambda i, k: ('attached', AttachedObjectUpdate(k, CollisionObjectUpdate(i))),
              IDS, st.sampled_from(['fore', 'finger'])),
    st.builds(lambda i: ('attached', AttachedObjectUpdate('', CollisionObjectUpdate(i, REMOVE))),
              IDS),
    st.builds(lambda v: ('state', {'shoulder': v}), st.floats(-1, 1)),
    st.builds(lambda i: ('color', {i: (1.0, 0.0, 0.0, 1.0)}), IDS),
)


def edit(scene, kind, what):
    """Apply an edit; a refused one is no edit."""
    try:
        if kind == 'object':
            scene.apply_object(what)
        elif kind == 'attached':
            scene.apply_attached(what)
        elif kind == 'state':
            scene.set_positions(what)
        else:
            scene.apply(SceneUpdate(object_colors=what))
    except PlanningError:
        pass


@settings(max_examples=60, deadline=None)
@given(first=st.lists(EDITS, max_size=6), second=st.lists(EDITS, max_size=6))
def test_difference_leads_from_one_scene_to_the_next(kinematics, first, second):
    """IF-40a: a follower that applies the differences holds the same scene."""
    scene = PlanningScene(kinematics)
    for item in first:
        edit(scene, *item)
    follower = PlanningScene(kinematics)
    follower.apply(scene.full_update())
    before = scene.content
    for item in second:
        edit(scene, *item)
    difference = scene_difference(kinematics, before, scene.content)
    follower.apply(difference)
    expected, got = summary(scene.content), summary(follower.content)
    for part in ('q', 'objects', 'attached', 'acm'):
        assert got[part] == expected[part]
