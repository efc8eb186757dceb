"""URDF text to a tree, and what is said of a text that is none."""

import math

import numpy as np
import pytest

from armsim_ros.errors import ModelError, Severity
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.geometry import Box, Capsule, Cylinder, Mesh, Sphere
from armsim_ros.model.robot_model import JointType

LIMIT = '<limit lower="-1" upper="2" effort="5" velocity="3"/>'


def joint(name, parent, child, kind='revolute', inside=LIMIT, xyz='0 0 0.1'):
    """Return a joint's text on one line."""
    return (f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz}"/><axis xyz="0 0 1"/>{inside}</joint>')


def link(name, inside=''):
    """Return a link's text on one line, with plausible mass properties."""
    inertial = ('<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" '
                'iyz="0" izz="0.01"/></inertial>')
    return f'<link name="{name}">{inside or inertial}</link>'


def robot(*lines):
    """Return a URDF whose second line is the first one given."""
    return '\n'.join(['<robot name="r">', *lines, '</robot>'])


def read(text, **arguments):
    """Return the content of a URDF."""
    return parse_urdf(text, 'r.urdf', read_mesh=arguments.pop('read_mesh', None), **arguments)


def urdf_mistakes(text):
    """Return the messages of a URDF's mistakes."""
    with pytest.raises(ModelError) as caught:
        read(text)
    return [str(one) for one in caught.value.problems]


def test_the_tree_is_in_depth_first_order(arm_urdf):
    """Links and joints follow the tree; siblings in the order of the joints' names."""
    content = read(arm_urdf)
    assert content.root_link == 'base'
    assert list(content.links) == ['base', 'a', 'b', 'tool', 'left', 'right']
    assert list(content.joints) == ['j1', 'j2', 'to_tool', 'finger_1', 'finger_2']


def test_a_joint_as_written():
    """Origin, unit axis, limits, mimic and dynamics."""
    inside = LIMIT + '<dynamics damping="0.5" friction="0.1"/>'
    text = robot(link('a'), link('b'), joint('j', 'a', 'b', inside=inside).replace(
        'xyz="0 0 1"', 'xyz="0 3 4"'))
    found = read(text).joints['j']
    assert found.type is JointType.REVOLUTE
    assert found.axis == pytest.approx([0, 0.6, 0.8])
    assert found.origin[:3, 3] == pytest.approx([0, 0, 0.1])
    assert (found.limits.lower, found.limits.upper) == (-1.0, 2.0)
    assert (found.limits.velocity, found.limits.effort) == (3.0, 5.0)
    assert found.limits.acceleration == math.inf
    assert (found.damping, found.friction) == (0.5, 0.1)


def test_the_default_axis_is_x():
    """A joint without an axis turns about x."""
    text = robot(link('a'), link('b'), joint('j', 'a', 'b').replace('<axis xyz="0 0 1"/>', ''))
    assert read(text).joints['j'].axis == pytest.approx([1, 0, 0])


def test_a_continuous_joint_needs_no_limit():
    """C2: it has no bounds, those it gives count."""
    content = read(robot(link('a'), link('b'), link('c'), joint('j', 'a', 'b', 'continuous', ''),
                         joint('k', 'b', 'c', 'continuous', LIMIT)))
    assert content.joints['j'].limits.velocity == math.inf
    assert content.joints['k'].limits.velocity == 3.0
    assert content.joints['k'].limits.lower == -math.inf


def test_shapes():
    """Boxes, spheres, cylinders, capsules and meshes, with pose and color."""
    shapes = ('<box size="1 2 3"/>', '<sphere radius="1"/>',
              '<cylinder radius="1" length="2"/>', '<capsule radius="1" length="2"/>',
              '<mesh filename="m.stl" scale="1 2 3"/>')
    asked = []
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]))

    def read_mesh(uri, scale):
        asked.append((uri, scale))
        return mesh

    inside = ''.join(f'<collision><origin xyz="0 0 {n}"/><geometry>{shape}</geometry></collision>'
                     for n, shape in enumerate(shapes))
    inside += ('<visual><geometry><box size="1 1 1"/></geometry><material name="red"/></visual>')
    text = robot('<material name="red"><color rgba="1 0 0 1"/></material>', link('a', inside))
    found = read(text, read_mesh=read_mesh).links['a']
    assert [one.geometry for one in found.collisions] == [
        Box((1, 2, 3)), Sphere(1), Cylinder(1, 2), Capsule(1, 2), mesh]
    assert found.collisions[3].origin[2, 3] == 3.0
    assert found.visuals[0].rgba == (1, 0, 0, 1)
    assert asked == [('m.stl', (1.0, 2.0, 3.0))]


A_B = (link('a'), link('b'))
WRONG = [
    (robot(link('a'), link('a')), "r.urdf:3:1: link 'a' is defined twice, first in line 2"),
    (robot(*A_B), 'r.urdf:3:1: 2 links have no parent: a, b'),
    (robot(*A_B, joint('j', 'a', 'b'), joint('j', 'a', 'b')), "joint 'j' is defined twice"),
    (robot(*A_B, joint('j', 'a', 'bb')), "r.urdf:4:1: child of joint 'j': link 'bb' is not in"),
    (robot(*A_B, joint('j', 'a', 'b'), joint('k', 'a', 'b')),
     "r.urdf:5:1: link 'b' is the child of two joints, 'j' and 'k'"),
    (robot(*A_B, joint('j', 'a', 'b'), joint('k', 'b', 'a')), 'the links form a loop'),
    (robot(link('r'), *A_B, joint('j', 'a', 'b'), joint('k', 'b', 'a')),
     'r.urdf:3:1: the links a, b form a loop'),
    (robot(*A_B, joint('j', 'a', 'b', 'revolut')),
     "r.urdf:4:1: joint 'j' has the type 'revolut'; allowed: fixed, revolute, continuous, "
     "prismatic, floating, planar; did you mean 'revolute'?"),
    (robot(*A_B, joint('j', 'a', 'b', inside='')), "joint 'j' is revolute and has no <limit>"),
    (robot(*A_B, joint('j', 'a', 'b', inside='<limit lower="1" upper="2" effort="1"/>')),
     "<limit> of joint 'j' has no 'velocity'"),
    (robot(*A_B, joint('j', 'a', 'b', xyz='0 0 nan')),
     "<origin xyz> is '0 0 nan'; allowed: 3 finite numbers"),
    (robot(*A_B, joint('j', 'a', 'b').replace('xyz="0 0 1"', 'xyz="0 0 0"')),
     "the axis of joint 'j' has length 0"),
    ('<robot name="r">\n<link name="a">\n</robot>',
     'r.urdf:3:3: this is not XML: mismatched tag; <link> of line 2 is still open there'),
    ('<sdf/>', 'r.urdf:1:1: the root element is <sdf>; allowed: <robot>'),
    ('<robot name="r"/>', 'r.urdf:1:1: the robot has no links'),
    ('<!DOCTYPE x [<!ENTITY a "b">]><robot/>', "the text defines the entity 'a'"),
]


@pytest.mark.parametrize(('text', 'message'), WRONG)
def test_one_message_with_its_line(text, message):
    """A mistake is told with file, line and what would be right."""
    assert any(message in one for one in urdf_mistakes(text)), urdf_mistakes(text)


def test_all_mistakes_at_once():
    """One run names them all."""
    text = robot(link('a'), link('a'), joint('j', 'a', 'x'), joint('k', 'y', 'a', 'hinge'))
    assert len(urdf_mistakes(text)) == 3


def test_a_limit_of_zero_is_none():
    """Exporters write effort 0 and velocity 0 for what they do not know."""
    content = read(robot(*A_B, joint('j', 'a', 'b', inside='<limit lower="-1" upper="1" '
                                     'effort="0" velocity="0"/>')))
    assert content.joints['j'].limits.effort == math.inf
    assert len(content.problems) == 1


def test_limits_of_zero_are_one_message():
    """Joints with the same zeros share a line; it names them and the limits."""
    zero = '<limit lower="-1" upper="1" effort="{}" velocity="0"/>'
    names = 'abcd'
    content = read(robot(*map(link, names), *(
        joint(f'joint_{child}', parent, child, inside=zero.format(effort))
        for parent, child, effort in zip('abc', 'bcd', (0, 0, 5), strict=True))))
    warnings = [one.what for one in content.problems]
    assert warnings == [
        'joints joint_b, joint_c: limit 0 of velocity and effort allows no motion; it is taken '
        'as no limit',
        "joint 'joint_d': limit 0 of velocity allows no motion; it is taken as no limit"]


def test_what_others_read_is_listed(arm_urdf):
    """Gazebo's tags and transmissions are noted, unknown tags give a warning."""
    extra = ('<transmission name="t"><type>transmission_interface/SimpleTransmission</type>'
             '<joint name="j1"><hardwareInterface>hardware_interface/PositionJointInterface'
             '</hardwareInterface></joint><actuator name="m"><mechanicalReduction>50'
             '</mechanicalReduction></actuator></transmission>\n<gazebo><plugin name="p"/>'
             '</gazebo>\n<gazebo reference="a"><material>Gazebo/Red</material></gazebo>\n<lnk/>\n')
    content = read(arm_urdf.replace('</robot>', extra + '</robot>'))
    assert content.transmissions[0].joint == 'j1'
    assert content.transmissions[0].interfaces == ('position',)
    assert content.transmissions[0].reduction == 50.0
    texts = [str(one) for one in content.problems]
    assert any('<gazebo> is not used here (plugin)' in one for one in texts)
    assert any("<gazebo reference='a'> is not used here (material)" in one for one in texts)
    assert any("<lnk> is not known and has no effect; did you mean 'link'?" in one
               for one in texts)


@pytest.mark.parametrize(('inertial', 'reason'), [
    ('', 'it has no <inertial>'),
    ('<inertial><mass value="-1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
     '</inertial>', 'the mass -1 kg is not above 1e-06 kg'),
    ('<inertial><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
     '</inertial>', 'not positive definite'),
    ('<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/>'
     '</inertial>', 'no body has the principal inertias 1, 1, 9'),
    ('<inertial><mass value="1"/><inertia ixx="9" ixy="0" ixz="0" iyy="9" iyz="0" izz="9"/>'
     '</inertial>', 'the inertia 9 kg*m^2 is too large for 1 kg within'),
    ('<inertial><mass value="1"/><inertia ixx="1e-15" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
     '</inertial>', 'not positive definite'),
    ('<inertial><origin xyz="0 0 100"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" '
     'iyy="0.01" iyz="0" izz="0.01"/></inertial>',
     'the centre of mass is 100 m away from shapes of 0.187 m'),
    ('<inertial><mass value="6000"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/>'
     '</inertial>', 'the mass 6000 kg is too large for its shape, and taken as grams'),
    ('<inertial><mass value="1e6"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
     '</inertial>', 'the mass 1e+06 kg is too large for its shape; taken instead: mass 6 kg'),
])
def test_impossible_mass_properties_are_repaired(inertial, reason):
    """The warning names link, reason and the value that is taken."""
    shape = '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>'
    content = read(robot(link('a'), f'<link name="b">{inertial}{shape}</link>',
                         joint('j', 'a', 'b')))
    (warning,) = (str(one) for one in content.problems)
    assert warning.startswith("r.urdf:3:1: link 'b': ")
    assert reason in warning
    mass = content.links['b'].inertial.mass
    assert mass == pytest.approx(1.0 if 'value="1"' in inertial else 6.0)
    assert np.diag(content.links['b'].inertial.inertia) == pytest.approx(
        mass / 12 * np.array([0.13, 0.10, 0.05]))


def test_a_replaced_inertia_keeps_mass_and_centre():
    """The weight of the link loads the joints as in urdfdom (link.cpp, parseInertial)."""
    shape = '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>'
    inertial = ('<inertial><origin xyz="0.01 0.02 0.03"/><mass value="2"/><inertia ixx="1" '
                'ixy="0" ixz="0" iyy="1" iyz="0" izz="9"/></inertial>')
    content = read(robot(link('a'), f'<link name="b">{inertial}{shape}</link>',
                         joint('j', 'a', 'b')))
    assert content.links['b'].inertial.mass == pytest.approx(2.0)
    assert content.links['b'].inertial.origin[:3, 3] == pytest.approx((0.01, 0.02, 0.03))


def test_masses_in_grams_keep_their_inertia():
    """Where the inertia fits the mass, both are a thousandth of what is written."""
    shape = '<visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual>'
    inertial = ('<inertial><mass value="6000"/><inertia ixx="60" ixy="0" ixz="0" iyy="50" iyz="0" '
                'izz="20"/></inertial>')
    content = read(robot(link('a'), f'<link name="b">{inertial}{shape}</link>',
                         joint('j', 'a', 'b')))
    assert content.links['b'].inertial.mass == pytest.approx(6.0)
    assert np.diag(content.links['b'].inertial.inertia) == pytest.approx((0.06, 0.05, 0.02))


def test_a_placeholder_mass_becomes_a_light_link():
    """A link of a nanogram gets ten grams in its shape, not what its volume would weigh."""
    shape = '<collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision>'
    inertial = ('<inertial><mass value="1e-9"/><inertia ixx="1e-9" ixy="0" ixz="0" iyy="1e-9" '
                'iyz="0" izz="1e-9"/></inertial>')
    content = read(robot(link('a'), f'<link name="b">{inertial}{shape}</link>',
                         joint('j', 'a', 'b')))
    assert content.links['b'].inertial.mass == pytest.approx(0.01)
    assert "link 'b': the mass 1e-09 kg is not above 1e-06 kg; taken instead: mass 0.01 kg" in str(
        content.problems[0])


def test_a_mass_of_no_arm_is_not_kept():
    """Without a shape to compare with, a link of a million kilograms is a point of ten grams."""
    inertial = ('<inertial><mass value="1e6"/><inertia ixx="1e3" ixy="0" ixz="0" iyy="1e3" '
                'iyz="0" izz="1e3"/></inertial>')
    content = read(robot(link('a'), f'<link name="b">{inertial}</link>', joint('j', 'a', 'b')))
    assert content.links['b'].inertial.mass == pytest.approx(0.01)
    assert "link 'b': the mass 1e+06 kg is above 20000 kg" in str(content.problems[0])


def test_a_frame_stays_without_mass():
    """A fixed link without shapes is only a frame."""
    content = read(robot(link('a'), '<link name="b"/>', joint('j', 'a', 'b', 'fixed', '')))
    assert content.links['b'].inertial is None
    assert content.problems == ()


def test_a_box_without_volume_is_left_out_with_a_warning():
    """A plane that is drawn as a box of no height costs its shape, not the start."""
    text = ('<robot name="r"><link name="ground"><collision><geometry><box size="5 5 0"/>'
            '</geometry></collision></link></robot>')
    content = parse_urdf(text, 'r.urdf', read_mesh=lambda uri, scale: None)
    assert content.links['ground'].collisions == ()
    assert "link 'ground' has no collision geometry of a box" in str(content.problems[0])


def test_bounds_below_zero_count_without_their_sign():
    """
    The absolute value of velocity and effort is the bound.

    moveit_core/robot_model/src/robot_model.cpp: jointBoundsFromURDF;
    ros2_control/joint_limits/include/joint_limits/joint_limits_urdf.hpp: getJointLimits.
    """
    content = read(robot(link('a'), link('b'), joint(
        'j', 'a', 'b', 'continuous', '<limit velocity="-3" effort="-5"/>')))
    limits = content.joints['j'].limits
    assert (limits.velocity, limits.effort) == (3.0, 5.0)
    assert len(content.problems) >= 2


def test_soft_limits_are_read():
    """<safety_controller> has 0 where an attribute is missing; k_velocity is required."""
    text = joint('j', 'a', 'b', 'revolute', LIMIT + '<safety_controller {}/>')
    soft = read(robot(link('a'), link('b'), text.format(
        'soft_lower_limit="-0.5" k_velocity="3"'))).joints['j'].soft_limits
    assert (soft.lower, soft.upper, soft.k_position, soft.k_velocity) == (-0.5, 0.0, 0.0, 3.0)
    with pytest.raises(ModelError, match='k_velocity'):
        read(robot(link('a'), link('b'), text.format('k_position="3"')))


def found_in(text):
    """Return the content of a URDF that upstream loads, and its warnings."""
    content = read(text, read_visual_mesh=lambda uri, scale: None)
    assert all(one.strict for one in content.problems if one.severity is Severity.WARNING
               and 'left out' in one.what)
    return content, [str(one) for one in content.problems]


@pytest.mark.parametrize(('inside', 'reason'), [
    ('<visual><geometry/></visual>', '<visual> has no <geometry> with a shape'),
    ('<visual><origin xyz="0 0 nan"/><geometry><box size="1 1 1"/></geometry></visual>',
     "<origin xyz> is '0 0 nan'"),
    ('<collision><geometry><cone radius="1"/></geometry></collision>',
     "<cone> is not a shape; <collision> of link 'a' is left out"),
    ('<collision><geometry><box size="1 -1 1"/></geometry></collision>',
     '<box> needs sizes above 0'),
    ('<collision><geometry><mesh filename=""/></geometry></collision>',
     "<mesh> has no 'filename'"),
    ('<visual><geometry><mesh filename="x.stl" scale="0.001"/></geometry></visual>',
     "<mesh scale> is '0.001'"),
    ('<inertial><mass value="1"/></inertial>',
     "<inertial> has no <inertia ixx ixy ixz iyy iyz izz>; <inertial> of link 'a' is left out"),
    ('<inertial><mass/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>',
     '<inertial> has no <mass value>'),
])
def test_a_part_of_a_link_with_a_mistake_is_left_out(inside, reason):
    """The rest counts, with a warning; urdfdom's model.cpp ignores the result of parseLink."""
    sphere = '<geometry><sphere radius="0.1"/></geometry>'
    content, warnings = found_in(robot(link(
        'a', f'{inside}<collision>{sphere}</collision><visual>{sphere}</visual>')))
    shapes = (*content.links['a'].collisions, *content.links['a'].visuals)
    assert [one.geometry for one in shapes] == [Sphere(0.1), Sphere(0.1)]
    assert any(reason in one and one.startswith('r.urdf:2:') for one in warnings), warnings


def test_a_wrong_color_leaves_the_shape():
    """As in urdfdom's link.cpp (parseMaterial)."""
    content = read(robot(link('a', (
        '<visual><geometry><sphere radius="0.1"/></geometry><material name="m">'
        '<color rgba="1 0 0"/></material></visual>'))))
    assert content.links['a'].visuals[0].rgba is None


MIMIC_CHAIN = (*A_B, link('c'))


@pytest.mark.parametrize(('leader', 'reason'), [
    ('nobody', "joint 'nobody' is not in the URDF"), ('k', "joint 'k' is fixed")])
def test_a_joint_that_cannot_follow_is_free(leader, reason):
    """Of an unknown joint, or one without a variable (robot_model.cpp: buildMimic)."""
    content, warnings = found_in(robot(
        *MIMIC_CHAIN, joint('j', 'a', 'b', inside=LIMIT + f'<mimic joint="{leader}"/>'),
        joint('k', 'b', 'c', 'fixed', '')))
    assert content.joints['j'].mimic is None
    assert any(f"r.urdf:5:1: <mimic> of joint 'j' is left out: {reason}" in one
               for one in warnings), warnings


def test_joints_that_mimic_each_other_are_free():
    """All <mimic> of the robot are left out (robot_model.cpp: buildMimic)."""
    content, warnings = found_in(robot(
        *MIMIC_CHAIN, link('d'), joint('j', 'a', 'b', inside=LIMIT + '<mimic joint="k"/>'),
        joint('k', 'b', 'c', inside=LIMIT + '<mimic joint="j"/>'),
        joint('l', 'c', 'd', inside=LIMIT + '<mimic joint="j"/>')))
    assert [one.mimic for one in content.joints.values()] == [None, None, None]
    assert any('joints mimic each other (j -> k -> j)' in one for one in warnings), warnings


def test_limits_the_wrong_way_round_are_exchanged():
    """With a warning; MoveIt finds no valid state between them."""
    content, warnings = found_in(robot(*A_B, joint(
        'j', 'a', 'b', inside='<limit lower="1" upper="-1" effort="1" velocity="1"/>')))
    assert (content.joints['j'].limits.lower, content.joints['j'].limits.upper) == (-1.0, 1.0)
    assert any("joint 'j' has lower 1 above upper -1" in one for one in warnings)


def test_damping_below_zero_is_none():
    """A joint would gain speed by itself."""
    content, warnings = found_in(robot(*A_B, joint(
        'j', 'a', 'b', inside=LIMIT + '<dynamics damping="-1" friction="0.1"/>')))
    assert (content.joints['j'].damping, content.joints['j'].friction) == (0.0, 0.1)
    assert any("damping of joint 'j' is -1" in one for one in warnings)
