# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects and worlds in every format, as plain values."""

import numpy as np
import pytest
from sdf_texts import BALL, BOX, link, model

from armsim_ros.model.geometry import Box, Cylinder, Mesh, Plane, Sphere
from armsim_ros.sim.world.loaded_world import Fault, ResourceFaultError, shape_object
from armsim_ros.sim.world.resources import WorldResources

TETRAHEDRON = """solid t
facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet
facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet
facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 0 1 vertex 1 0 0 endloop endfacet
facet normal 0 0 0 outer loop vertex 1 0 0 vertex 0 0 1 vertex 0 1 0 endloop endfacet
endsolid t
"""


@pytest.fixture
def resources(tmp_path):
    """Return what may read below a folder of the user's."""
    return WorldResources([tmp_path])


def read(resources, text):
    """Return the object of a text."""
    return resources.object('', text, 'x')


def test_a_shape_of_an_address():
    """Measures, mass, friction and colour; three numbers make an opaque colour."""
    thing = shape_object('box', 'size=0.1,0.2,0.3&mass=0.3&color=1,0,0&friction=0.5').item
    part = thing.parts[0]
    assert (part.geometry, part.rgba) == (Box((0.1, 0.2, 0.3)), (1.0, 0.0, 0.0, 1.0))
    assert (thing.mass, thing.friction) == (0.3, 0.5)
    assert shape_object('sphere', 'radius=0.1').item.mass is None


@pytest.mark.parametrize(('query', 'words'), [
    ('siez=1,1,1', "did you mean 'size'"), ('size=1,1', '3 finite numbers'),
    ('size=1,1,-1', 'greater than 0'), ('mass=nan', 'a finite number'), ('color=2,0,0', 'less'),
])
def test_a_wrong_address_says_what_is_allowed(query, words):
    """Misspelt words, missing numbers, impossible values."""
    with pytest.raises(ResourceFaultError, match=words):
        shape_object('box', query)


def test_links_of_a_model_hold_together(resources):
    """Each shape stands where its link does; masses add up, and the centre lies between."""
    weight = '<inertial><mass>{}</mass><inertia><ixx>1</ixx></inertia></inertial>'
    text = model(link(BOX, 'a', more=weight.format(1)) + link(
        BALL, 'b', '0 0 1 0 0 0', more=weight.format(3))
        + '<joint name="j" type="revolute"/>')
    loaded = read(resources, text)
    thing = loaded.item
    assert [type(part.geometry) for part in thing.parts] == [Box, Sphere]
    assert thing.parts[1].origin[2, 3] == 1.0
    assert thing.mass == 4.0
    assert thing.inertial.origin[2, 3] == pytest.approx(0.75)
    assert any("joint 'j'" in line for line in loaded.unused)


def test_a_static_model_and_one_without_inertial(resources):
    """Static ones have no mass; the others 1 kg unless they say otherwise."""
    assert read(resources, model(link(BOX), more='<static>true</static>')).item.mass is None
    assert read(resources, model(link(BOX))).item.mass == 1.0


def test_friction_and_colour(resources):
    """The first mu counts; the colour is the visual's."""
    text = model('<link name="l"><visual name="v"><material><diffuse>1 0 0 1</diffuse></material>'
                 '</visual><collision name="c"><geometry>' + BOX + '</geometry><surface><friction>'
                 '<ode><mu>0.3</mu></ode></friction></surface></collision></link>')
    thing = read(resources, text).item
    assert (thing.friction, thing.parts[0].rgba) == (0.3, (1.0, 0.0, 0.0, 1.0))


def test_poses_relative_to_other_frames(resources):
    """Links, frames and models of the scope; degrees where they are said."""
    text = model(
        '<frame name="f"><pose degrees="true">0 0 1 0 0 90</pose></frame>' + link(
            BALL, 'a', '1 0 0 0 0 0').replace('<pose>', '<pose relative_to="f">', 1))
    np.testing.assert_allclose(
        read(resources, text).item.parts[0].origin[:3, 3], (0, 1, 1), atol=1e-12)


@pytest.mark.parametrize(('text', 'words'), [
    (model(link(BALL).replace('<pose>', '<pose relative_to="g">', 1)), "'g' names no frame"),
    (model('<frame name="f"><pose relative_to="f"/></frame>' + link(BALL).replace(
        '<pose>', '<pose relative_to="f">', 1)), 'relative to itself'),
    (model(''), 'no <collision>'),
    (model(link('<plane/>')), 'not static'),
    (model(link('<sphere><radius>zero</radius></sphere>')), "<radius> is 'zero'"),
    ('<sdf version="1.9"/>', 'no <model>'),
    ('<', 'is none of'), ('<!-- <sdf/> -->', 'is none of'), ('<html/>', 'is none of'),
])
def test_a_wrong_model_is_a_mistake_with_its_line(resources, text, words):
    """Nothing is guessed."""
    with pytest.raises(ResourceFaultError, match=words) as caught:
        read(resources, text)
    assert caught.value.fault is (
        Fault.UNSUPPORTED_FORMAT if words == 'is none of' else Fault.RESOURCE_PARSE_ERROR)


def test_models_inside_of_models(resources, tmp_path):
    """Nested and included models are parts; an include may be placed and renamed."""
    folder = tmp_path / 'cup'
    folder.mkdir()
    (folder / 'cup.stl').write_text(TETRAHEDRON)
    text = model(link(BOX) + '<include><uri>model://cup</uri><pose>0 0 2 0 0 0</pose></include>')
    (tmp_path / 'tray.sdf').write_text(text)
    for mesh in ('cup.stl', 'model://cup/cup.stl'):
        (folder / 'model.sdf').write_text(model(link(f'<mesh><uri>{mesh}</uri></mesh>'), 'cup'))
        thing = resources.object(str(tmp_path / 'tray.sdf'), '', '').item
        assert [type(part.geometry) for part in thing.parts] == [Box, Mesh]
        assert thing.parts[1].origin[2, 3] == 2.0


def test_a_world_in_sdf(resources):
    """Models stand where they say; a plane is one of a static model."""
    text = ('<sdf version="1.9"><world name="w"><plugin name="p"/><model name="ground"><static>1'
            '</static>' + link('<plane><normal>0 0 1</normal></plane>') + '</model>'
            + model(link(BALL), 'ball', '<pose>1 2 3 0 0 0</pose>')[len('<sdf version="1.9">'):-6]
            + '</world></sdf>')
    world = resources.world('', text)
    assert [thing.name for thing in world.items] == ['ground', 'ball']
    assert isinstance(world.items[0].parts[0].geometry, Plane)
    np.testing.assert_allclose(world.items[1].pose[:3, 3], (1, 2, 3))
    assert any('plugin' in line for line in world.unused)


def test_mjcf_means_what_mujoco_makes_of_it(resources):
    """Defaults, degrees, materials; 1000 kg/m^3 without an inertial."""
    text = """<mujoco model="w"><default><geom rgba="0 1 0 1"/></default><worldbody>
      <geom type="plane" size="1 1 1"/>
      <body name="post" pos="1 0 0" euler="0 90 0"><geom type="cylinder" size="0.1 0.5"/></body>
      <body name="cube" pos="0 1 1"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
    </worldbody></mujoco>"""
    world = resources.world('', text)
    post, cube = world.items
    assert (world.name, world.floor) == ('w', 0.0)
    assert (post.mass, post.parts[0].geometry) == (None, Cylinder(0.1, 1.0))
    np.testing.assert_allclose(post.pose[:3, 2], (1, 0, 0), atol=1e-12)
    assert cube.mass == pytest.approx(1.0)
    assert cube.parts[0].rgba == (0.0, 1.0, 0.0, 1.0)


@pytest.mark.parametrize(('body', 'friction'), [
    ('<geom type="box" size="0.1 0.1 0.1" contype="0" conaffinity="0" friction="0.9"/>'
     '<geom size="0.1" friction="0.1"/>', 0.1),
    ('<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><body>'
     '<geom size="0.1" friction="0.1"/></body><body><geom size="0.1" friction="0.9"/></body>',
     0.1),
])
def test_the_friction_of_a_body_is_that_of_its_first_shape_that_touches(
        resources, body, friction):
    """Neither what is only seen nor what another body has."""
    text = ('<mujoco><worldbody><body name="b"><freejoint/>{}</body><body name="c">'
            '<geom size="0.1" friction="0.7"/></body></worldbody></mujoco>')
    assert read(resources, text.format(body)).item.friction == friction


def test_shapes_of_an_mjcf_world_keep_their_friction(resources):
    """But for the floor, whose own is reported."""
    world = resources.world('', '<mujoco><worldbody>'
                            '<geom name="ground" type="plane" size="1 1 1" friction="0.1"/>'
                            '<geom name="ramp" type="box" size="1 1 0.1" friction="0.05"/>'
                            '</worldbody></mujoco>')
    assert [(thing.name, thing.friction) for thing in world.items] == [('ramp', 0.05)]
    assert world.unused == ("friction of geom 'ground': it is the floor",)


def test_gravity_compensation_of_mjcf(resources):
    """So much of the weight of all bodies does not act."""
    inertial = '<inertial pos="0 0 0" mass="{}" diaginertia="1 1 1"/><geom size="0.1"/>'
    text = (f'<mujoco><worldbody><body gravcomp="1"><freejoint/>{inertial.format(1)}'
            f'<body>{inertial.format(3)}</body></body></worldbody></mujoco>')
    assert read(resources, text).item.gravcomp == 0.25


def test_mjcf_reads_files_of_the_users_folders_only(resources, tmp_path):
    """Meshes are read here; an include is left out and said."""
    (tmp_path / 't.stl').write_text(TETRAHEDRON)
    text = """<mujoco><compiler meshdir="{}"/><include file="/etc/passwd"/>
      <asset><mesh name="t" file="t.stl" scale="0.1 0.1 0.1"/></asset><worldbody><body name="b">
      <freejoint/><geom type="mesh" mesh="t"/></body></worldbody></mujoco>"""
    file = tmp_path / 'b.xml'
    file.write_text(text.format('.'))
    loaded = resources.object(str(file), '', '')
    assert isinstance(loaded.item.parts[0].geometry, Mesh)
    assert '<include>' in loaded.unused
    file.write_text(text.format('/etc'))
    with pytest.raises(ResourceFaultError) as caught:
        resources.object(str(file), '', '')
    assert caught.value.fault is Fault.MISSING_ASSETS


TABLE = """<robot name="table"><link name="{root}"/><link name="top"><collision><geometry>
  <box size="1 1 0.1"/></geometry></collision><inertial><mass value="10"/>
  <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="{joint}"><parent link="{root}"/><child link="top"/></joint>
  {more}</robot>"""
STATIC = '<gazebo><static>{}</static></gazebo>'


@pytest.mark.parametrize(('root', 'joint', 'more', 'mass'), [
    ('foot', 'fixed', '', 10.0), ('world', 'fixed', '', None), ('world', 'floating', '', 10.0),
    ('foot', 'fixed', STATIC.format('True'), None), ('foot', 'fixed', STATIC.format('no'), 10.0),
])
def test_a_urdf_may_be_fixed_to_the_world(resources, root, joint, more, mass):
    """
    By a root link of that name, unless its joint floats, or by Gazebo's word.

    sdformat parser_urdf.cc InitModelString, ParseSDFExtension.
    """
    text = TABLE.format(root=root, joint=joint, more=more)
    assert read(resources, text).item.mass == mass


def test_a_link_that_leads_elsewhere_is_not_followed(resources, tmp_path):
    """Where a symbolic link leads counts, not where it lies."""
    (tmp_path / 'x.sdf').symlink_to('/etc/passwd')
    with pytest.raises(ResourceFaultError) as caught:
        resources.object(str(tmp_path / 'x.sdf'), '', '')
    assert caught.value.fault is Fault.MISSING_ASSETS
    assert 'root:' not in str(caught.value)


MESH = '<mesh><uri>{}</uri></mesh>'


def test_an_address_counts_before_a_text(resources, tmp_path):
    """
    The text is used where the address is empty, for objects and worlds.

    simulation_interfaces Resource.msg, SpawnEntity.srv, LoadWorld.srv.
    """
    (tmp_path / 'a.sdf').write_text(model(link(BOX), 'of_the_file'))
    text = model(link(BALL), 'of_the_text')
    assert resources.object(str(tmp_path / 'a.sdf'), text, '').item.name == 'of_the_file'
    assert resources.object('', text, '').item.name == 'of_the_text'
    (tmp_path / 'w.sdf').write_text(
        f'<sdf version="1.9"><world name="w"><model name="m">{link(BALL)}</model></world></sdf>')
    assert resources.world(str(tmp_path / 'w.sdf'), 'objects: {}\n').name == 'w'


@pytest.mark.parametrize(('uri', 'text', 'name'), [
    ('', model(link(BOX), 'lamp'), 'lamp'),
    ('', '<robot name="tool"><link name="a"><collision><geometry><sphere radius="0.1"/></geometry>'
         '</collision></link></robot>', 'tool'),
    ('', '<mujoco><worldbody><body name="ball"><geom size="0.1"/></body></worldbody></mujoco>',
     'ball'),
    ('', '<mujoco><worldbody><body><geom size="0.1"/></body></worldbody></mujoco>', ''),
    ('', 'parts: [{shape: {type: sphere, radius: 0.1}}]\n', ''),
    ('armsim://box', '', ''),
    ('armsim://feeding_place/cube', '', 'cube'),
])
def test_a_resource_has_its_own_name_or_none(resources, uri, text, name):
    """
    The name that a file or text gives; '' where it gives none.

    simulation_interfaces SpawnEntity.srv, name.
    """
    assert resources.object(uri, text, 'x').item.name == name


@pytest.mark.parametrize('uri', [
    'nowhere.sdf', 'package://no_such_package/a.sdf', 'file:///nowhere.sdf', 'armsim://nothing',
    'armsim://feeding_place/nothing', '/etc/hostname',
])
def test_what_is_not_found_is_a_missing_asset(resources, uri):
    """
    Files, packages and addresses that are not found among those that are read.

    simulation_interfaces SpawnEntity.srv, MISSING_ASSETS.
    """
    with pytest.raises(ResourceFaultError) as caught:
        resources.object(uri, '', 'x')
    assert caught.value.fault is Fault.MISSING_ASSETS


@pytest.mark.parametrize('uri', ['package://no_such_package/a.stl', 'file:///nowhere.stl'])
def test_a_mesh_that_is_not_found_is_a_missing_asset(resources, uri):
    """The package of a mesh may be missing, too."""
    with pytest.raises(ResourceFaultError) as caught:
        read(resources, model(link(MESH.format(uri))))
    assert caught.value.fault is Fault.MISSING_ASSETS


def test_a_world_can_leave_missing_assets_out(resources, tmp_path):
    """
    Shapes and models whose files are missing or cannot be read are left out, and named.

    simulation_interfaces LoadWorld.srv, ignore_missing_or_unsupported_assets.
    """
    (tmp_path / 'bad.stl').write_text('nothing')
    bad = str(tmp_path / 'bad.stl')
    text = ('<sdf version="1.9"><world name="w">'
            f'<model name="both">{link(BOX)}{link(MESH.format(bad), "k")}</model>'
            f'<model name="gone">{link(MESH.format("file:///nowhere.stl"))}</model>'
            '<include><uri>model://nowhere</uri></include></world></sdf>')
    with pytest.raises(ResourceFaultError):
        resources.world('', text)
    world = resources.world('', text, ignore_assets=True)
    assert [(thing.name, len(thing.parts)) for thing in world.items] == [('both', 1)]
    assert sum(line.startswith('left out') for line in world.unused) == 4


def test_an_mjcf_world_can_leave_missing_meshes_out(resources):
    """Bodies without any other shape go with them."""
    text = ('<mujoco><asset><mesh name="m" file="file:///nowhere.stl"/></asset><worldbody>'
            '<body name="a"><freejoint/><geom type="mesh" mesh="m"/></body>'
            '<body name="b"><geom size="0.1"/><geom type="mesh" mesh="m"/></body>'
            '</worldbody></mujoco>')
    world = resources.world('', text, ignore_assets=True)
    assert [(thing.name, len(thing.parts)) for thing in world.items] == [('b', 1)]
    assert any('nowhere.stl' in line for line in world.unused)


def test_missing_assets_are_the_only_faults_that_are_left_out(resources):
    """A model without any shape is a mistake of the text."""
    text = '<sdf version="1.9"><world name="w"><model name="m"/></world></sdf>'
    with pytest.raises(ResourceFaultError) as caught:
        resources.world('', text, ignore_assets=True)
    assert caught.value.fault is Fault.RESOURCE_PARSE_ERROR


def test_each_collision_has_the_colour_of_its_visual(resources):
    """They are matched by order; where there are fewer colours the last one counts."""
    colours = ['1 0 0 1', '0 1 0 1', '0 0 1 1']
    visual = '<visual name="v{}"><material><diffuse>{}</diffuse></material></visual>'
    visuals = ''.join(visual.format(*each) for each in enumerate(colours))
    collisions = ''.join(f'<collision name="c{k}"><geometry>{BALL}</geometry></collision>'
                         for k in range(4))
    thing = read(resources, model(f'<link name="l">{visuals}{collisions}</link>')).item
    assert [part.rgba[:3] for part in thing.parts] == [
        (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)]
