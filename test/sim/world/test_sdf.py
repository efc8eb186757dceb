# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What of an SDF model changes how it moves."""

import numpy as np
import pytest
from sdf_texts import BALL, BOX, link, model

from armsim_ros.sim.world.loaded_world import ResourceFaultError
from armsim_ros.sim.world.resources import WorldResources


@pytest.fixture
def resources(tmp_path):
    """Return what may read below a folder of the user's."""
    return WorldResources([tmp_path])


def read(resources, text):
    """Return the object of a text."""
    return resources.object('', text, 'x')


@pytest.mark.parametrize('word', ['true', 'True', 'TRUE', '1'])
def test_a_truth_value_may_be_in_capitals(resources, word):
    """They are read in lower case. sdformat Param.cc."""
    thing = read(resources, model(link(BOX), more=f'<static>{word}</static>')).item
    assert thing.mass is None


def test_a_link_without_inertial_counts_beside_one_with_it(resources):
    """Each link has its mass, 1 kg by default. sdformat Link.cc."""
    weight = '<inertial><mass>3</mass><inertia><ixx>1</ixx></inertia></inertial>'
    empty = '<link name="b"><pose>0 0 1 0 0 0</pose></link>'
    for shape in (link(BALL, 'b', '0 0 1 0 0 0'), empty):
        thing = read(resources, model(link(BOX, 'a', more=weight) + shape)).item
        assert thing.mass == 4.0
        assert thing.inertial.origin[2, 3] == pytest.approx(0.25)


@pytest.mark.parametrize(('inertial', 'collision', 'mass'), [
    ('<inertial auto="true"/>', '', 6.0),
    ('<inertial auto="True"><mass>9</mass><density>500</density></inertial>', '', 3.0),
    ('<inertial auto="1"><density>500</density></inertial>', '<density>100</density>', 0.6),
])
def test_an_automatic_inertial_is_that_of_the_collisions(resources, inertial, collision, mass):
    """
    The density is the collision's, then the link's, then that of water.

    sdformat Link.cc ResolveAutoInertials, Collision.cc CalculateInertial.
    """
    text = link(BOX, pose='0 0 1 0 0 0', more=inertial).replace('</geometry>',
                                                                f'</geometry>{collision}')
    thing = read(resources, model(text)).item
    assert thing.mass == pytest.approx(mass)
    assert thing.inertial.origin[2, 3] == pytest.approx(1.0)
    turned = thing.inertial.origin[:3, :3]
    np.testing.assert_allclose(
        turned @ thing.inertial.inertia @ turned.T,
        mass / 12.0 * np.diag([0.13, 0.10, 0.05]), atol=1e-9)


def test_an_automatic_inertial_needs_a_collision(resources):
    """It is refused otherwise. sdformat Link.cc ResolveAutoInertials."""
    text = model(link(BOX) + '<link name="b"><inertial auto="true"/></link>')
    with pytest.raises(ResourceFaultError, match="'b' has an automatic inertial and no <coll"):
        read(resources, text)


@pytest.mark.parametrize(('links', 'share'), [
    (link(BALL, more='<gravity>false</gravity>'), 1.0), (link(BALL), 0.0),
    (link(BALL, 'a', more='<gravity>0</gravity>') + link(BALL, 'b'), 0.5),
])
def test_a_link_without_gravity_floats(resources, links, share):
    """So much of the model's weight does not act. SDF link.sdf, gravity."""
    assert read(resources, model(links)).item.gravcomp == share


def test_a_kinematic_link_is_fixed(resources):
    """No force moves it. SDF link.sdf, kinematic."""
    loaded = read(resources, model(link(BALL, more='<kinematic>true</kinematic>')))
    assert loaded.item.mass is None
    assert 'kinematic' in loaded.remarks[0]


def test_a_placement_frame_is_where_the_model_is_placed(resources):
    """The pose of a model is that of the frame. sdformat Model.cc, placement_frame."""
    text = model(link(BOX, 'a') + link(BALL, 'b', '1 0 0 0 0 0'), more='<pose>5 0 0 0 0 0</pose>')
    placed = text.replace('name="m"', 'name="m" placement_frame="b"')
    np.testing.assert_allclose(read(resources, placed).item.pose[:3, 3], (4, 0, 0))
    with pytest.raises(ResourceFaultError, match="'c' names no frame; allowed: a, b"):
        read(resources, placed.replace('_frame="b"', '_frame="c"'))


def test_friction_without_a_coefficient_is_that_of_sdf(resources):
    """The default of mu is 1; parameters of other engines are listed. SDF surface.sdf."""
    surface = '<surface><bounce/><friction><bullet/></friction></surface>'
    loaded = read(resources, model(link(BOX).replace('</geometry>', f'</geometry>{surface}')))
    assert loaded.item.friction == 1.0
    assert loaded.unused == ("<bounce> of collision 'c'", "<bullet> of collision 'c'")
