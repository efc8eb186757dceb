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
@settings(max_examples=200)
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
@settings(max_examples=200)
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
