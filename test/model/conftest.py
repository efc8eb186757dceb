"""An arm with a gripper, small enough to see through; distances between links."""

import itertools

import coal
import pytest

from armsim_ros.model.description.srdf import parse_srdf
from armsim_ros.model.description.urdf import parse_urdf
from armsim_ros.model.geometry import Box, Cylinder
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.model.tree import link_poses

_BODY = ('<inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" '
         'izz="0.01"/></inertial>')
_JOINT = ('<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>'
          '<origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>'
          '<limit lower="-1" upper="2" effort="5" velocity="3"/>{4}</joint>')


@pytest.fixture
def arm_urdf():
    """Return an arm with a gripper: base -> a -> b -> tool -> two fingers, one mimics."""
    links = [f'<link name="{name}">{_BODY}</link>'
             for name in ('base', 'a', 'b', 'tool', 'left', 'right')]
    mimic = '<mimic joint="finger_1" multiplier="-1" offset="0.5"/>'
    joints = [_JOINT.format(*parts) for parts in (
        ('j1', 'revolute', 'base', 'a', ''), ('j2', 'revolute', 'a', 'b', ''),
        ('to_tool', 'fixed', 'b', 'tool', ''), ('finger_1', 'prismatic', 'tool', 'left', ''),
        ('finger_2', 'prismatic', 'tool', 'right', mimic))]
    return '\n'.join(['<robot name="r">', *links, *joints, '</robot>'])


@pytest.fixture
def make_model(arm_urdf):
    """Return a function from an SRDF's inside to (model, warnings)."""
    def make(*lines, name='r'):
        content = parse_urdf(arm_urdf, 'r.urdf', read_mesh=None)
        text = '\n'.join([f'<robot name="{name}">', *lines, '</robot>'])
        found = parse_srdf(text, 'r.srdf', robot_name=content.name, root_link=content.root_link,
                           links=content.links, joints=content.joints)
        model = RobotModel(content.name, content.links, content.joints, content.root_link,
                           found.semantic)
        return model, [str(one) for one in found.problems]
    return make


def _coal_object(geometry, pose):
    shape = coal.Box(*geometry.size) if isinstance(geometry, Box) else None
    if isinstance(geometry, Cylinder):
        shape = coal.Cylinder(geometry.radius, geometry.length)
    return coal.CollisionObject(shape, pose[:3, :3], pose[:3, 3])


@pytest.fixture
def near_pairs():
    """Return a function from (model, positions, distance [m]) to the pairs that are nearer."""
    def find(model, positions, limit, others=None):
        poses = link_poses(model, positions)
        bodies = {name: [_coal_object(one.geometry, poses[name] @ one.origin)
                         for one in link.collisions] for name, link in model.links.items()}
        bodies.update({name: [_coal_object(*one) for one in shapes]
                       for name, shapes in (others or {}).items()})
        request, result = coal.DistanceRequest(), coal.DistanceResult
        return [pair for pair in itertools.combinations(sorted(bodies), 2)
                if pair not in model.semantic.disabled_collisions
                and any(coal.distance(a, b, request, result()) < limit
                        for a in bodies[pair[0]] for b in bodies[pair[1]])]
    return find
