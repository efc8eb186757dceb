# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What joint_state_publisher publishes of a description and of its sources."""

import math

import pytest

from armsim_ros.errors import ModelError
from armsim_ros.nodes.upstream.joint_states import (
    DependentJointError,
    JointStateOptions,
    JointStates,
)

LIMIT = '<limit lower="-1" upper="2"/>'


def joint(name, inside=LIMIT, kind='revolute'):
    """Return the text of a joint."""
    return f'<joint name="{name}" type="{kind}">{inside}</joint>'


def states(*joints, **options):
    """Return the joint states of a robot with these joints."""
    return JointStates(f'<robot name="r">{"".join(joints)}</robot>', JointStateOptions(**options))


def test_joints_are_in_the_order_of_the_description():
    """
    Fixed, floating and planar joints are left out; mimic joints have their place.

    joint_state_publisher.py: init_urdf; test_multi_joints.py, test_64_joint_robot.py.
    """
    found = states(joint('b'), joint('x', '', 'fixed'), joint('a', LIMIT, 'prismatic'),
                   joint('y', '', 'floating'), joint('z', '', 'planar'),
                   joint('c', '', 'continuous'), joint('m', LIMIT + '<mimic joint="b"/>'))
    assert found.names == ['b', 'a', 'c', 'm']
    assert found.state() == {'position': [0.0] * 4, 'velocity': [], 'effort': []}


def test_a_robot_without_joints_has_no_state():
    """
    There is nothing to publish of it.

    joint_state_publisher.py: timer_callback; test_zero_joints.py.
    """
    assert states(joint('x', '', 'fixed')).names == []


@pytest.mark.parametrize(('inside', 'options', 'expected'), [
    ('<limit lower="1" upper="2"/>', {}, 1.5),
    ('<limit lower="-4" upper="-2"/>', {}, -3.0),
    (LIMIT, {'zeros': {'a': 7.0}}, 7.0),
    (LIMIT + '<safety_controller soft_lower_limit="0.5" soft_upper_limit="9"/>', {}, 1.25),
    (LIMIT + '<safety_controller soft_lower_limit="0.5"/>',
     {'use_smallest_joint_limits': False}, 0.0)])
def test_where_a_joint_begins(inside, options, expected):
    """
    At 0 where its range allows it, else in the middle, or where zeros says.

    joint_state_publisher.py: init_urdf.
    """
    assert states(joint('a', inside), **options).state()['position'] == [expected]


@pytest.mark.parametrize('inside', ['', '<limit upper="1"/>', '<limit lower="1"/>',
                                    '<limit lower="x" upper="1"/>'])
def test_limits_are_required(inside):
    """
    A joint without both limits is refused, unless it is continuous.

    joint_state_publisher.py: init_urdf; test_parsing.py.
    """
    with pytest.raises(ModelError, match=r'lower|upper|limit'):
        states(joint('a', inside))
    assert states(joint('a', inside, 'continuous')).names == ['a']


def test_a_text_that_is_no_robot():
    """
    It is refused with an error that names it.

    joint_state_publisher.py: init_urdf; test_parsing.py.
    """
    for text in ('', 'robot', '<sdf/>', '<robot>', '<urdf><joint name="a"/></urdf>'):
        with pytest.raises(ModelError):
            JointStates(text, JointStateOptions())
    assert JointStates(f'<urdf><robot>{joint("a")}</robot></urdf>', JointStateOptions()).names == [
        'a']


SDF = '<sdf><model name="m">{}</model></sdf>'
AXIS = '<axis><limit><lower>{}</lower><upper>{}</upper></limit></axis>'


def test_joints_of_sdf():
    """
    Joints of one axis have the limits of their axis; the others are left out.

    joint_state_publisher.py: init_sdf; test_parsing.py, test_multi_joints.py.
    """
    text = SDF.format(joint('a', AXIS.format(1, 2)) + joint('b', '', 'continuous')
                      + joint('c', '', 'ball') + joint('d', AXIS.format(-1, 2), 'prismatic'))
    found = JointStates(text, JointStateOptions())
    assert found.names == ['a', 'b', 'd']
    assert found.state()['position'] == [1.5, 0.0, 0.0]
    for inside in ('', AXIS.format('', 1), AXIS.format(1, 'x'), '<axis><limit/></axis>'):
        with pytest.raises(ModelError):
            JointStates(SDF.format(joint('a', inside)), JointStateOptions())


COLLADA = ('<COLLADA version="{}"><kinematics_model><technique_common>{}</technique_common>'
           '</kinematics_model></COLLADA>')
REVOLUTE = ('<joint name="{}"><revolute><limits><min>{}</min><max>{}</max></limits></revolute>'
            '</joint>')


def test_joints_of_collada():
    """
    Revolute joints have limits in degrees and begin at 0; equal limits make a fixed joint.

    joint_state_publisher.py: init_collada; test_parsing.py, test_multi_joints.py.
    """
    text = COLLADA.format('1.5.0', REVOLUTE.format('a', -90, 90) + REVOLUTE.format('b', 5, 5)
                          + '<joint name="c"><prismatic/></joint>')
    found = JointStates(text, JointStateOptions())
    assert found.names == ['a']
    found.step(9.0)
    assert found.state()['position'] == [pytest.approx(math.pi / 2)]
    whole = REVOLUTE.format('a', -90, 90)
    for wrong in (COLLADA.format('1.4.0', whole), COLLADA.format('', whole),
                  COLLADA.format('1.5.0', whole.replace('limits', 'limit')),
                  COLLADA.format('1.5.0', whole.replace('min', 'least')),
                  COLLADA.format('1.5.0', REVOLUTE.format('a', 'x', 1)),
                  COLLADA.format('1.5.0', whole).replace('kinematics_model', 'model'),
                  COLLADA.format('1.5.0', whole).replace('technique_common', 'technique')):
        with pytest.raises(ModelError):
            JointStates(wrong, JointStateOptions())


def test_mimic_chains_are_followed():
    """
    Factor and offset of the whole chain; velocities are scaled, efforts are the leader's.

    joint_state_publisher.py: timer_callback; test_mimic_chain.py.
    """
    found = states(joint('m', LIMIT + '<mimic joint="n" multiplier="2" offset="0.5"/>'),
                   joint('n', LIMIT + '<mimic joint="a" multiplier="-3" offset="1"/>'),
                   joint('a'))
    found.take(['a'], position=[0.2], velocity=[0.1], effort=[4.0])
    state = found.state()
    assert state['position'] == pytest.approx([2 * (-3 * 0.2 + 1) + 0.5, -3 * 0.2 + 1, 0.2])
    assert state['velocity'] == pytest.approx([-0.6, -0.3, 0.1])
    assert state['effort'] == [4.0, 4.0, 4.0]


def test_without_mimic_tags_every_joint_is_free():
    """
    With use_mimic_tags false, <mimic> has no effect.

    joint_state_publisher.py: init_urdf.
    """
    found = states(joint('a'), joint('m', LIMIT + '<mimic joint="a" offset="1"/>'),
                   use_mimic_tags=False)
    assert found.state()['position'] == [0.0, 0.0]


@pytest.mark.parametrize('leader', ['b', 'm', 'lost'])
def test_a_circle_of_mimic_joints(leader):
    """
    A mimic joint that follows no free joint is an error, which ends the program.

    joint_state_publisher.py: timer_callback; test_mimic_cycle.py.
    """
    found = states(joint('m', LIMIT + f'<mimic joint="{leader}"/>'),
                   joint('b', LIMIT + '<mimic joint="m"/>'))
    with pytest.raises(DependentJointError, match=r'follows|follow each other'):
        found.state()


def test_sources_fill_what_they_give():
    """
    Lists that are not empty are taken; mimic and unknown joints are skipped.

    joint_state_publisher.py: source_cb, timer_callback.
    """
    found = states(joint('a'), joint('b'), joint('m', LIMIT + '<mimic joint="a"/>'))
    found.take(['lost', 'm', 'b'], position=[9.0, 9.0, 1.0], velocity=[], effort=[9.0, 9.0, 2.0])
    assert found.state() == {
        'position': [0.0, 1.0, 0.0], 'velocity': [], 'effort': [0.0, 2.0, 0.0]}
    found.take(['b', 'a'], position=[], velocity=[0.5], effort=[])
    assert found.state()['velocity'] == [0.0, 0.5, 0.0]


def test_default_fields():
    """
    Free joints have the fields that are asked for; mimic joints always bring positions.

    joint_state_publisher.py: _init_joint, timer_callback.
    """
    assert states(joint('a'), defaults=('velocity', 'effort')).state() == {
        'position': [], 'velocity': [0.0], 'effort': [0.0]}
    mimic = joint('m', LIMIT + '<mimic joint="a" offset="1"/>')
    assert states(joint('a'), mimic, defaults=()).state()['position'] == [0.0, 0.0]


def test_delta_moves_joints_between_their_limits():
    """
    They turn round at the limits; a continuous joint begins anew.

    joint_state_publisher.py: update.
    """
    found = states(joint('a'), joint('c', '', 'continuous'))
    seen = []
    for _ in range(9):
        found.step(0.7)
        seen.append(found.state()['position'])
    assert [one[0] for one in seen] == pytest.approx(
        [0.7, 1.4, 2.0, 1.3, 0.6, -0.1, -0.8, -1.0, -0.3])
    assert seen[3][1] == pytest.approx(2.8)
    assert seen[4][1] == -math.pi
