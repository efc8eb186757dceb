# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Joint vectors, poses and Jacobians."""

import threading

import numpy as np
import pytest

from armsim_ros.errors import PlanningError
from armsim_ros.model.transforms import matrix_from_quat_xyzw, rotation_angle

STATES = {
    'home': (0, 0, 0, 0, 0, 0),
    'scan_food': (0, 0.4569, 0.4905, -0.5519, 1.57, 0),
    'scan_face': (0, 0.4569, 0.4905, 0.9504, 1.57, 0),
    'scan_face2': (-0.3491, 0, 2.6877, 2.6877, 0.3491, 0),
}


@pytest.mark.parametrize(
    ('state', 'xyz', 'quat_xyzw'),
    [
        ('home', (0.20679, -0.12, 1.66813), (0.70711, -0.00002, 0.00002, 0.70711)),
        ('scan_food', (0.10752, 0.19949, 1.40092), (0.02527, 0.70636, 0.02527, 0.70695)),
        ('scan_face', (0.10751, 0.21163, 1.57469), (0.50093, 0.49904, 0.50057, 0.49945)),
        ('scan_face2', (0.22623, -0.08631, 1.33695), (0.7071, -0.00001, 0.00001, 0.70711)),
    ],
)
def test_forward_kinematics_equals_the_published_poses(sunday, state, xyz, quat_xyzw):
    """The tool is where the arm's author measured it, to 1e-4."""
    pose = sunday.link_pose(np.array(STATES[state], dtype=float), 'link_6')
    np.testing.assert_allclose(pose[:3, 3], xyz, atol=1e-4)
    assert rotation_angle(pose, matrix_from_quat_xyzw(quat_xyzw)) < 1e-4


def test_one_joint_beyond_either_limit_is_noticed(sunday):
    """All others are within theirs."""
    for limits, beyond in ((sunday.lower, -0.01), (sunday.upper, 0.01)):
        middle = 0.5 * (sunday.lower + sunday.upper)
        assert sunday.within_limits(middle)
        middle[2] = limits[2] + beyond
        assert not sunday.within_limits(middle)


@pytest.mark.parametrize('arm', ['sunday', 'ur5', 'panda', 'continuous', 'parallelogram'])
def test_jacobian_is_the_derivative_of_the_pose(arm, request):
    """Columns equal central differences of the pose, mimic joints included."""
    model = request.getfixturevalue(arm)
    link = model.robot.joints[model.names[-1]].child
    rng = np.random.default_rng(1)
    values = rng.uniform(0.1, 1.0, len(model.group_indices('arm')))
    q = model.insert(model.default(), 'arm', values)
    step = 1e-6
    numeric = np.zeros((6, len(values)))
    for column in range(len(values)):
        ahead, back = values.copy(), values.copy()
        ahead[column] += step
        back[column] -= step
        pose_1 = model.link_pose(model.insert(q, 'arm', ahead), link)
        pose_0 = model.link_pose(model.insert(q, 'arm', back), link)
        numeric[:3, column] = (pose_1[:3, 3] - pose_0[:3, 3]) / (2 * step)
        spin = (pose_1[:3, :3] - pose_0[:3, :3]) / (2 * step) @ model.link_pose(q, link)[:3, :3].T
        numeric[3:, column] = spin[2, 1], spin[0, 2], spin[1, 0]
    np.testing.assert_allclose(model.jacobian(q, link, 'arm'), numeric, atol=1e-7)


def test_vector_completes_positions_and_moves_mimic_joints(parallelogram):
    """What is not named stays at the base; mimic joints follow their masters."""
    base = parallelogram.vector({'turn': 0.5, 'lift': 0.2})
    q = parallelogram.vector({'bend': 0.3}, base)
    assert parallelogram.positions(q) == pytest.approx(
        {'turn': 0.5, 'lift': 0.2, 'bend': 0.3, 'level_1': -0.2, 'level_2': -0.2}
    )


def test_mimic_keeps_the_plate_level(parallelogram):
    """The plate's inclination does not change when lift and bend move."""
    tilts = [
        parallelogram.link_pose(parallelogram.vector({'lift': lift, 'bend': bend}), 'plate')[2, 2]
        for lift, bend in ((0.0, 0.0), (0.5, -0.3), (-1.0, 1.2))
    ]
    assert tilts == pytest.approx([np.cos(0.1)] * 3)


def test_unknown_joint_is_refused_with_the_nearest_name(sunday):
    """A joint that the robot lacks is code -17 and names what was meant."""
    with pytest.raises(PlanningError, match="did you mean 'joint_3'") as caught:
        sunday.vector({'joint_33': 0.1})
    assert caught.value.code == -17


def test_position_that_is_not_finite_is_refused(sunday):
    """NaN is code -17."""
    with pytest.raises(PlanningError, match='joint_2') as caught:
        sunday.vector({'joint_2': float('nan')})
    assert caught.value.code == -17


def test_unknown_group_and_link_have_their_own_codes(sunday):
    """A group is -15, a link -18."""
    with pytest.raises(PlanningError) as group:
        sunday.group_indices('leg')
    with pytest.raises(PlanningError) as link:
        sunday.link_pose(sunday.default(), 'link_9')
    assert (group.value.code, link.value.code) == (-15, -18)


def test_insert_and_extract_are_inverse(two_arms):
    """A group's values go in and come out; the others stay."""
    q = two_arms.default()
    values = np.array([0.1, 0.2, 0.3])
    changed = two_arms.insert(q, 'right', values)
    np.testing.assert_array_equal(two_arms.extract(changed, 'right'), values)
    np.testing.assert_array_equal(two_arms.extract(changed, 'left'), two_arms.extract(q, 'left'))


def test_default_is_the_middle_where_zero_is_not_allowed(two_arms):
    """CFG-4: the lift stands between 0.1 and 0.5."""
    assert two_arms.positions(two_arms.default())['lift'] == pytest.approx(0.3)


def test_moved_links_include_what_hangs_below(two_arms):
    """SCN-15: a group moves its links and all that they carry, and no other."""
    assert two_arms.moved_links('left') == {
        'left_1_link', 'left_2_link', 'left_3_link', 'left_hand'
    }


def test_continuous_joints_have_no_bounds(continuous):
    """Their limits are infinite, and turning once changes nothing."""
    assert np.isinf(continuous.lower).all()
    assert np.isinf(continuous.upper).all()
    q = np.full(6, 0.3)
    np.testing.assert_allclose(
        continuous.link_pose(q, 'tool'), continuous.link_pose(q + 2 * np.pi, 'tool'), atol=1e-12
    )


def test_threads_do_not_disturb_each_other(sunday):
    """Poses computed in several threads at once are those of one thread."""
    rng = np.random.default_rng(2)
    states = rng.uniform(-1.5, 1.5, (200, 6))
    expected = [sunday.link_pose(q, 'link_6') for q in states]
    wrong = []

    def work():
        for q, pose in zip(states, expected, strict=True):
            if not np.array_equal(sunday.link_pose(q, 'link_6'), pose):
                wrong.append(q)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
