"""The kinematic tree: which links are adjacent."""

import pytest

from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import adjacent_pairs

_SHAPE = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'


@pytest.fixture
def adjacent_in():
    """Return a function from (joints as (type, parent, child), links without shapes) to pairs."""
    def pairs(joints, empty=()):
        names = dict.fromkeys(name for _, *ends in joints for name in ends)
        links = [f'<link name="{name}">{"" if name in empty else _SHAPE}</link>'
                 for name in names]
        limit = '<limit lower="-1" upper="1" effort="5" velocity="3"/>'
        parts = [f'<joint name="{parent}_{child}" type="{kind}"><parent link="{parent}"/>'
                 f'<child link="{child}"/><axis xyz="0 0 1"/>{limit}</joint>'
                 for kind, parent, child in joints]
        text = '\n'.join(['<robot name="r">', *links, *parts, '</robot>'])
        content = parse_urdf(text, 'r.urdf', read_mesh=None)
        return set(adjacent_pairs(RobotModel(
            content.name, content.links, content.joints, content.root_link)))
    return pairs


def test_a_fence_on_the_base_is_not_adjacent_to_the_arm(adjacent_in):
    """
    Only the base is, though the fence never moves relative to it.

    compute_default_collisions.cpp (computeConnectionGraph): one joint connects neighbours.
    """
    assert adjacent_in([('fixed', 'base', 'fence'), ('revolute', 'base', 'arm')]) == {
        ('base', 'fence'), ('arm', 'base')}


def test_a_gripper_is_not_adjacent_to_the_link_before_the_last(adjacent_in):
    """A gripper that is fixed to link 6 can collide with link 5."""
    found = adjacent_in([('revolute', 'link_5', 'link_6'), ('fixed', 'link_6', 'gripper')])
    assert found == {('link_5', 'link_6'), ('gripper', 'link_6')}


def test_links_without_shapes_connect_their_neighbours(adjacent_in):
    """All neighbours of a group of such links are adjacent, whatever its joints are."""
    found = adjacent_in(
        [('revolute', 'a', 'flange'), ('revolute', 'flange', 'tool'), ('fixed', 'tool', 'b'),
         ('prismatic', 'tool', 'c'), ('revolute', 'c', 'd')], empty=('flange', 'tool'))
    assert found == {('a', 'b'), ('a', 'c'), ('b', 'c'), ('c', 'd')}


def test_links_of_a_rigid_body_are_never_checked(adjacent_in):
    """Two parts that are fixed to the base cannot move relative to each other."""
    assert ('camera', 'table') in adjacent_in(
        [('fixed', 'base', 'table'), ('fixed', 'base', 'camera')])
