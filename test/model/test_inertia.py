"""Mass properties of shapes, against sums over many points."""

import numpy as np
import pytest

from armsim_ros.model.geometry import Box, Capsule, Cone, Cylinder, Sphere
from armsim_ros.model.inertia import (
    bounding_radius,
    implausible,
    inertial_of,
    rigid_inertia,
    unit_inertia,
    volume,
    with_plausible_inertia,
)
from armsim_ros.model.robot_model import Inertial, LinkGeometry
from armsim_ros.model.transforms import pose_matrix

INSIDE = {
    Box((0.2, 0.4, 0.6)): lambda x, y, z: (abs(x) < 0.1) & (abs(y) < 0.2) & (abs(z) < 0.3),
    Sphere(0.3): lambda x, y, z: x**2 + y**2 + z**2 < 0.09,
    Cylinder(0.2, 0.6): lambda x, y, z: (x**2 + y**2 < 0.04) & (abs(z) < 0.3),
    Cone(0.3, 0.6): lambda x, y, z: np.hypot(x, y) < 0.3 * (0.3 - z) / 0.6,
    Capsule(0.1, 0.4): lambda x, y, z: (
        x**2 + y**2 + np.maximum(abs(z) - 0.2, 0)**2 < 0.01),
}


@pytest.mark.parametrize('shape', INSIDE, ids=lambda shape: type(shape).__name__)
def test_volume_inertia_and_reach_of_a_solid(shape):
    """A fine grid of points has the same volume, centre, inertia and reach, to 1 %."""
    axis = np.linspace(-0.3, 0.3, 121)
    axis = 0.5 * (axis[1:] + axis[:-1])
    grid = np.array(np.meshgrid(axis, axis, axis, indexing='ij')).reshape(3, -1)
    points = grid[:, INSIDE[shape](*grid)].T
    cell = (axis[1] - axis[0])**3
    assert volume(shape) == pytest.approx(len(points) * cell, rel=0.01)
    assert bounding_radius(shape) == pytest.approx(
        np.linalg.norm(points, axis=1).max(), abs=2.0 * (axis[1] - axis[0]))
    made = inertial_of([LinkGeometry(shape, np.eye(4))], mass=1.0)
    centre = points.mean(axis=0)
    assert made.origin[:3, 3] == pytest.approx(centre, abs=2e-3)
    arms = points - centre
    expected = np.eye(3) * (arms**2).sum(axis=1).mean() - arms.T @ arms / len(arms)
    assert made.inertia == pytest.approx(expected, rel=0.01, abs=1e-5)
    assert made.inertia == pytest.approx(unit_inertia(shape))


def test_two_boxes_are_one_long_box():
    """Parts are joined by the theorem of parallel axes, turned shapes too."""
    half = Box((0.3, 0.2, 0.1))
    turned = Box((0.2, 0.3, 0.1))
    made = inertial_of([LinkGeometry(half, pose_matrix((0.15, 0, 0))),
                        LinkGeometry(turned, pose_matrix((0.45, 0, 0), (0, 0, np.pi / 2)))], 2.0)
    assert made.mass == pytest.approx(2.0)
    assert made.origin[:3, 3] == pytest.approx((0.3, 0, 0))
    assert made.inertia == pytest.approx(2.0 * unit_inertia(Box((0.6, 0.2, 0.1))), abs=1e-12)


def test_a_link_without_shapes_is_a_small_ball():
    """There is something to move, but hardly anything."""
    made = inertial_of([])
    assert made.mass == pytest.approx(0.01)
    assert (np.linalg.eigvalsh(made.inertia) > 0).all()


def test_an_inertia_is_replaced_at_the_given_centre_of_mass():
    """Mass and centre of mass stay; the inertia is that of the shape, in the link's axes."""
    shapes = [LinkGeometry(Box((0.1, 0.2, 0.3)), pose_matrix((0.0, 0.0, 0.1)))]
    given = Inertial(2.0, pose_matrix((0.01, 0.02, 0.03), (0, 0, 1.0)), np.diag([1.0, 1.0, 9.0]))
    made = with_plausible_inertia(given, shapes)
    assert made.mass == 2.0
    assert made.origin == pytest.approx(pose_matrix((0.01, 0.02, 0.03)))
    assert made.inertia == pytest.approx(2.0 * unit_inertia(Box((0.1, 0.2, 0.3))))


def test_a_centre_of_mass_in_millimetres_is_replaced_too():
    """It is taken from the shapes where it is much further away than their reach."""
    shapes = [LinkGeometry(Box((0.1, 0.2, 0.3)), pose_matrix((0.0, 0.0, 0.1)))]
    given = Inertial(2.0, pose_matrix((0.0, 0.0, 100.0)), np.eye(3))
    assert with_plausible_inertia(given, shapes).origin == pytest.approx(pose_matrix((0, 0, 0.1)))


def test_without_shapes_the_least_principal_inertia_is_raised():
    """A rod of no thickness keeps its centre of mass and its inertia across, turned as given."""
    given = Inertial(3.0, pose_matrix((0.0, 0.0, 0.5), (0.0, np.pi / 2, 0.0)),
                     np.diag([0.25, 0.2, 0.0]))
    made = with_plausible_inertia(given, [])
    assert made.origin == pytest.approx(pose_matrix((0.0, 0.0, 0.5)))
    assert made.inertia == pytest.approx(np.diag([0.05, 0.2, 0.25]), rel=1e-5)
    assert implausible(made) == ''


def test_a_flat_body_gets_a_hardly_larger_inertia():
    """Only the least principal value is raised, and only as far as rounding matters."""
    flat = np.diag([0.005208, 0.005208, 0.010417])
    raised = rigid_inertia(flat)
    low, middle, high = np.linalg.eigvalsh(raised)
    assert low + middle > high
    assert raised == pytest.approx(flat, rel=1e-3)
    thick = np.diag([0.1, 0.2, 0.25])
    assert rigid_inertia(thick) is thick
