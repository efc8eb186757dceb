"""The sunday arm: where its tool is, and that it touches nothing where it should not."""

import itertools

import numpy as np
import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.model.geometry import Box
from armsim_ros.model.inertia import implausible
from armsim_ros.model.loading import load_robot_model
from armsim_ros.model.transforms import pose_matrix, quat_xyzw_from_matrix
from armsim_ros.model.tree import link_poses

TOOL_POSES = {
    'home': ((0.20679, -0.12000, 1.66813), (0.70711, -0.00002, 0.00002, 0.70711)),
    'scan_food': ((0.10752, 0.19949, 1.40092), (0.02527, 0.70636, 0.02527, 0.70695)),
    'scan_face': ((0.10751, 0.21163, 1.57469), (0.50093, 0.49904, 0.50057, 0.49945)),
    'scan_face2': ((0.22623, -0.08631, 1.33695), (0.70710, -0.00001, 0.00001, 0.70711)),
}
BOXES = {
    'base_link': ((-.064, -.18, -.048), (.056, -.06, .026)),
    'link_1': ((-.042, -.042, 0), (.042, .055, .097)),
    'link_3': ((-.028, -.021, -.202), (.028, .066, .028)),
    'link_4': ((-.028, -.064, -.044), (.028, 0, .043)),
    'link_5': ((-.033, -.053, -.134), (.031, .043, 0)),
    'link_6': ((-.005, -.02, -.02), (.005, .02, .02)),
}


@pytest.fixture(scope='module')
def sunday():
    """Return settings and model; neither gives a warning."""
    settings = load_robot_settings('sunday')
    problems = []
    model = load_robot_model(settings, report=problems.append)
    assert problems == []
    return settings, model


@pytest.mark.parametrize('state', TOOL_POSES)
def test_the_tool_is_where_the_author_measured_it(sunday, state):
    """Position and orientation of link_6 in the world, to 1e-4."""
    _, model = sunday
    pose = link_poses(model, model.semantic.named_states['manipulator'][state])['link_6']
    xyz, quat = TOOL_POSES[state]
    assert pose[:3, 3] == pytest.approx(xyz, abs=1e-4)
    found = quat_xyzw_from_matrix(pose)
    assert found * np.sign(found @ np.array(quat)) == pytest.approx(quat, abs=1e-4)


def test_the_group_and_its_order(sunday):
    """The group is the chain from base_link to link_6."""
    group = sunday[1].group('manipulator')
    assert group.active_joints == tuple(f'joint_{n}' for n in range(1, 7))
    assert group.chain == ('base_link', 'link_6')
    assert sunday[1].model_frame == 'world'


def test_limits(sunday):
    """Those of the URDF."""
    limits = sunday[1].joints['joint_2'].limits
    assert (limits.lower, limits.upper) == (-1.54, 1.54)
    assert (limits.velocity, limits.effort) == (3.14, 30.0)


@pytest.mark.parametrize('state', TOOL_POSES)
def test_nothing_touches(sunday, near_pairs, state):
    """In every named state the links keep 5 mm from each other and from the table."""
    settings, model = sunday
    table = settings.world.objects['table'].parts[0]
    top = (Box(table.shape.size), pose_matrix(table.xyz, table.rpy))
    positions = model.semantic.named_states['manipulator'][state]
    assert near_pairs(model, positions, 0.005, {'table': [top]}) == []


@pytest.mark.parametrize('name', BOXES)
def test_shapes_stay_inside_the_measured_boxes(sunday, name):
    """The primitives of a link are inside the box of the real one."""
    low, high = (np.array(corner) for corner in BOXES[name])
    shapes = sunday[1].links[name].collisions
    assert shapes
    for one in shapes:
        shape = one.geometry
        half = 0.5 * np.array(shape.size if isinstance(shape, Box)
                              else (2 * shape.radius, 2 * shape.radius, shape.length))
        corners = np.array(list(itertools.product(*[(-x, x) for x in half])))
        placed = corners @ one.origin[:3, :3].T + one.origin[:3, 3]
        assert (placed >= low - 1e-6).all()
        assert (placed <= high + 1e-6).all()


def test_masses_and_inertias_are_plausible(sunday):
    """A body of that mass and size has such an inertia; the arm weighs 1.7 kg with camera."""
    links = sunday[1].links.values()
    for link in links:
        if link.inertial is not None:
            assert implausible(link.inertial, link.collisions) == ''
    total = sum(link.inertial.mass for link in links if link.inertial)
    assert total == pytest.approx(1.772, abs=0.01)
