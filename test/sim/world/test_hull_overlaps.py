# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Hulls that overlap where meshes do not, and what the physics makes of them."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from armsim_ros.config.world import WorldSettings
from armsim_ros.model.geometry import Box, Mesh
from armsim_ros.model.robot_model import Joint, JointType, Link, LinkGeometry
from armsim_ros.model.semantic_model import SemanticModel
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.simulation import Simulation


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Keep convex parts in a folder of the test's own."""
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))


@pytest.fixture
def ringed(arm):
    """Return a function that puts a ring on the arm's base, whose hole holds a box of its hand."""
    def make(size):
        ring = trimesh.creation.annulus(0.07, 0.1, 0.04)
        mesh = Mesh(np.array(ring.vertices), np.array(ring.faces))
        height = 0.6  # of the hand's joint is 0.5 [m]
        base = LinkGeometry(mesh, pose_matrix((0, 0, height)))
        hand = LinkGeometry(Box((size, size, 0.02)), pose_matrix((0, 0, height - 0.5)))
        links = {**arm.links, 'base': replace(arm.links['base'], collisions=(base,)),
                 'hand': replace(arm.links['hand'], collisions=(hand,))}
        return replace(arm, links=links)
    return make


def run(simulation, steps):
    """Step on."""
    for _ in range(steps):
        simulation.step()


def settled(model, settings, claim):
    """Return the simulation after half a second at its start, and how far its joints went."""
    simulation = Simulation(model, settings, WorldSettings(floor=False))
    claim(simulation, 'position')
    run(simulation, 500)
    return simulation, float(np.abs(simulation.state.position).max())


def test_parts_take_the_place_of_hulls_that_overlap(ringed, settings, claim):
    """What stands in a hole of a mesh is not pushed by the mesh's hull, and a line says so."""
    simulation, distance = settled(ringed(0.05), settings, claim)
    assert simulation.contacts == ()
    assert distance < 1e-4
    (line,) = simulation.warnings
    assert "the hulls of 'tiny/hand' and 'tiny/base' overlap by" in line
    assert 'convex parts: ' in line


def test_parts_still_touch(ringed, settings, claim):
    """An arm that leaves the hole's middle touches the ring's rim."""
    simulation, _ = settled(ringed(0.09), settings, claim)
    simulation.command.position[:] = [0.2, 0.0, 0.0]
    simulation.write(1)
    run(simulation, 1000)
    assert {'tiny/base', 'tiny/hand'} in [set(one.bodies) for one in simulation.contacts]
    assert simulation.state.position[0] < 0.15


def test_parts_that_overlap_pass_through_each_other(ringed, settings, claim):
    """A hand that is really in the ring is not thrown out, and the line says what to do."""
    simulation, distance = settled(ringed(0.16), settings, claim)
    assert simulation.contacts == ()
    assert distance < 1e-4
    (line,) = simulation.warnings
    assert 'pass through each other in the physics' in line
    assert 'disable the pair in the SRDF' in line


BENT = {'initial_positions': {'shoulder': 1.2}}


@pytest.fixture
def walled(arm):
    """Return a function that puts two walls, one mesh, on both sides of the arm's upper part."""
    def make(gap=0.3, **semantic):
        walls = [trimesh.creation.box((1.0, 0.02, 0.5), pose_matrix((0, side * gap / 2, 0.65)))
                 for side in (-1, 1)]
        both = trimesh.util.concatenate(walls)
        base = LinkGeometry(Mesh(np.array(both.vertices), np.array(both.faces)), np.eye(4))
        hand = LinkGeometry(Box((0.05, 0.05, 0.1)), pose_matrix((0, 0, 0.1)))
        links = {**arm.links, 'base': replace(arm.links['base'], collisions=(base,)),
                 'hand': replace(arm.links['hand'], collisions=(hand,)),
                 'lower': replace(arm.links['lower'], collisions=())}
        return replace(arm, links=links, semantic=SemanticModel('tiny', **semantic))
    return make


def moved_upright(model, settings, claim):
    """Return the simulation after the arm rose from bent to upright."""
    simulation = Simulation(model, settings.model_copy(update=BENT), WorldSettings(floor=False))
    claim(simulation, 'position')
    simulation.command.position[:] = 0.0
    simulation.write(1)
    run(simulation, 3000)
    return simulation


def test_hulls_of_a_named_state_become_parts(walled, settings, claim):
    """A named state in which only hulls overlap is reached, and a line names state and parts."""
    upright = dict.fromkeys(('shoulder', 'elbow', 'wrist'), 0.0)
    model = walled(named_states={'arm': {'upright': upright}})
    simulation = moved_upright(model, settings, claim)
    assert np.abs(simulation.state.position).max() < 1e-3
    line = simulation.warnings[0]
    assert "in the named state 'upright' of group 'arm', so the physics takes convex parts" in line


def test_hulls_that_overlap_elsewhere_pass(walled, settings, claim):
    """Where random states show that only hulls overlap, the links pass through each other."""
    simulation = moved_upright(walled(), settings, claim)
    assert np.abs(simulation.state.position).max() < 1e-3
    assert simulation.warnings == ()
    line, = simulation.remarks
    assert 'overlap where their meshes are apart, so they pass through each other' in line


def test_hulls_of_two_arms_still_touch(walled, settings):
    """Links that different joints on the root carry, as robots of a cell, are never let pass."""
    model = walled()
    base = model.links['base']
    links = {'world': Link('world'), **model.links,
             'base': replace(base, collisions=()), 'other': replace(base, name='other')}
    mounts = {name: Joint(f'{name}_mount', JointType.FIXED, 'world', name, np.eye(4), np.eye(3)[2])
              for name in ('base', 'other')}
    joints = {'base_mount': mounts['base'], **model.joints, 'other_mount': mounts['other']}
    two = replace(model, links=links, joints=joints, root_link='world')
    assert Simulation(two, settings.model_copy(update=BENT)).remarks == []


def test_what_was_found_is_kept(walled, settings, monkeypatch):
    """A second start with the same robot finds the same pairs without comparing meshes."""
    first = Simulation(walled(), settings.model_copy(update=BENT)).remarks
    assert first
    monkeypatch.setattr('armsim_ros.model.coal_shapes.are_apart', None)
    assert Simulation(walled(), settings.model_copy(update=BENT)).remarks == first


def test_meshes_that_touch_still_collide(walled, settings, claim):
    """Walls that are nearer than the hand is wide stop the arm, hull or mesh."""
    simulation = moved_upright(walled(gap=0.05), settings, claim)
    assert simulation.state.position[0] > 0.1
