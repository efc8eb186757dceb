# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Property tests: errors and random goals of orientations, by SciPy's rotations."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armsim_ros.planning.constraint_terms import Frame, OrientationTerm

angle = st.floats(-math.pi, math.pi)
rotation = st.tuples(angle, st.floats(-1.5, 1.5), angle).map(
    lambda angles: Rotation.from_euler('XYZ', angles))
tolerance = st.floats(0.0, 3.2)


def pose(turn):
    """Return the pose of a link that is turned."""
    made = np.eye(4)
    made[:3, :3] = turn.as_matrix()
    return made


def error_of(link, frame, desired, as_vector):
    """Return upstream's error: from the desired orientation to the link's."""
    turn = (frame * desired).inv() * link
    return desired.apply(turn.as_rotvec()) if as_vector else turn.as_euler('XYZ')


def term_of(desired, tolerances, as_vector):
    """Return a constraint of link 'l' in the frame of link 'f'."""
    return OrientationTerm(
        'l', Frame('l', np.eye(4)), Frame('f', np.eye(4)), desired.as_matrix(),
        np.asarray(tolerances, dtype=float), as_vector, 1.0)


@pytest.mark.parametrize('as_vector', [False, True])
@settings(max_examples=60, deadline=None)
@given(link=rotation, frame=rotation, desired=rotation)
def test_error_is_that_of_an_independent_formula(link, frame, desired, as_vector):
    """
    The three angles turn the desired orientation into the link's.

    Upstream: kinematic_constraint.cpp, OrientationConstraint::decide.
    """
    found = term_of(desired, (math.inf,) * 3, as_vector).error({'l': pose(link), 'f': pose(frame)})
    wanted = error_of(link, frame, desired, as_vector)
    made = (Rotation.from_rotvec(found) * desired if as_vector
            else desired * Rotation.from_euler('XYZ', found))
    assert (made.inv() * frame.inv() * link).magnitude() < 1e-6
    if math.cos(wanted[1]) > 1e-3 and np.linalg.norm(wanted) < 3.1:
        assert found == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize('as_vector', [False, True])
@settings(max_examples=60, deadline=None)
@given(frame=rotation, desired=rotation, tolerances=st.tuples(tolerance, tolerance, tolerance),
       seed=st.integers(0, 10**6))
def test_random_goal_orientation_satisfies_its_constraint(
        frame, desired, tolerances, seed, as_vector):
    """
    An orientation drawn within the tolerances is within them by the error's formula.

    Upstream: default_constraint_samplers.cpp, IKConstraintSampler::samplePose.
    """
    term = term_of(desired, tolerances, as_vector)
    drawn = Rotation.from_matrix(term.random(np.random.default_rng(seed)))
    link = frame * drawn
    assert term.evaluate({'l': pose(link), 'f': pose(frame)}).satisfied
    error = error_of(link, frame, desired, as_vector)
    if math.cos(error[1]) > 1e-3:
        assert (np.abs(error) <= np.asarray(tolerances) + 1e-6).all()


PITCH = math.pi / 2
"""Where XYZ Euler angles are singular [rad]."""


@pytest.mark.parametrize(('roll', 'pitch', 'yaw', 'tolerances', 'kept'), [
    (3.140208, 3.141588, 1.570821, (0.8, 0.8, 3.15), True),
    (0.15, PITCH, 0.15, (0.2, 2.0, 0.2), False), (0.21, PITCH, 0.0, (0.2, 2.0, 0.2), False),
    (0.0, PITCH, 0.21, (0.2, 2.0, 0.2), False), (0.15, -PITCH, 0.15, (0.2, 2.0, 0.2), True),
    (0.21, PITCH, 0.0, (0.2, 2.0, 0.3), False), (0.0, PITCH, 0.21, (0.2, 2.0, 0.3), False),
    (0.21, PITCH, 0.0, (0.3, 2.0, 0.2), False), (0.0, PITCH, 0.21, (0.3, 2.0, 0.2), False),
    (0.21, -PITCH, 0.0, (0.2, 2.0, 0.3), False), (0.0, -PITCH, 0.21, (0.2, 2.0, 0.3), False),
    (0.21, -PITCH, 0.0, (0.3, 2.0, 0.2), False), (0.0, -PITCH, 0.21, (0.3, 2.0, 0.2), False),
    (0.5, -PITCH, 0.21, (0.3, 2.0, 0.2), False),
])
def test_singular_orientations(roll, pitch, yaw, tolerances, kept):
    """
    Near a singularity the angles are those that stay within the tolerances, if any do.

    Upstream: test_orientation_constraints.cpp, SphericalRobot Test1 to Test4.
    """
    link = Rotation.from_euler('XYZ', (roll, pitch, yaw))
    term = term_of(Rotation.identity(), tolerances, False)
    assert term.evaluate({'l': pose(link), 'f': np.eye(4)}).satisfied is kept


def test_singular_desired_orientation():
    """
    A turn about the link's own z axis is a yaw, where roll and yaw of the link are the same.

    Upstream: test_orientation_constraints.cpp, SphericalRobot Test5.
    """
    term = term_of(Rotation.from_euler('XYZ', (0.0, PITCH, 0.0)), (0.0, 0.0, 1.0), False)
    link = Rotation.from_euler('XYZ', (0.2, PITCH, 0.3))
    assert term.evaluate({'l': pose(link), 'f': np.eye(4)}).satisfied


@pytest.mark.parametrize(('quat', 'as_vector'), [
    ((-0.1712092272140422, -0.2853625129991958, -0.1712092272140422, 0.9273311367620117), False),
    ((0.28536251299919585, 0.17120922721404216, 0.28536251299919585, 0.8987902273981057), False),
    ((-0.23771285949073287, -0.23771285949073287, -0.23771285949073287, 0.911305541132181), True),
    ((0.0, -0.24012729887347428, 0.24012729887347428, 0.9405731022474851), True),
])
def test_parameterizations_differ(quat, as_vector):
    """
    Orientations within 0.5 rad by either parameterization, and not by the other.

    Upstream: test_orientation_constraints.cpp, OrientationConstraintsParameterization.
    """
    poses = {'l': pose(Rotation.from_quat(quat)), 'f': np.eye(4)}
    for parameterization in (False, True):
        term = term_of(Rotation.identity(), (0.5,) * 3, parameterization)
        assert term.evaluate(poses).satisfied is (parameterization == as_vector)


def test_a_rotation_vector_is_in_the_frame():
    """
    A wide tolerance about z allows a turn about z of the frame, not of the link.

    Upstream: test_orientation_constraints.cpp, ToleranceInRefFrame.
    """
    base, delta = Rotation.from_rotvec((PITCH, 0, 0)), Rotation.from_rotvec((0.1, 0.1, 0.9))
    term = term_of(base, (0.2, 0.2, 1.0), True)
    assert term.evaluate({'l': pose(delta * base), 'f': np.eye(4)}).satisfied
    assert not term.evaluate({'l': pose(base * delta), 'f': np.eye(4)}).satisfied
