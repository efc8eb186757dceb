# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""compute_ik, compute_fk and check_state_validity."""

from __future__ import annotations

import math
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped
from move_group_bench import name_of, turn, xyz
import pytest
from wire import at, box, carried, joint_goal, robot_state, thing


def positions(message: Any) -> dict[str, float]:
    """Return the joints of a robot state."""
    return dict(zip(message.joint_state.name, message.joint_state.position, strict=True))


def assert_same(a: Any, b: Any) -> None:
    """Check two stamped poses against the precision that clients may rely on."""
    assert math.dist(xyz(a.pose.position), xyz(b.pose.position)) < 1e-4
    assert turn(a.pose.orientation, b.pose.orientation) < 1e-3


@pytest.mark.statement('SRV-1', 'SRV-2', 'SRV-6', 'PM-9', 'UT-12')
def test_ik_and_fk_agree(arm: Any) -> None:
    """FK of the solution is the pose, and the solution names all joints of the robot."""
    for step in (0.1, 0.4, 0.8):
        pose = arm.pose(arm.near(step))
        answer = arm.ik(pose_stamped=pose, ik_link_name=arm.tip)
        assert name_of(answer.error_code) == 'SUCCESS', answer.error_code
        solution = positions(answer.solution)
        assert set(solution) >= set(arm.joints)
        assert not answer.solution.is_diff
        assert not answer.solution.attached_collision_objects
        assert_same(arm.pose(solution), pose)


@pytest.mark.statement('SRV-1', 'SRV-2')
def test_the_seed_is_tried_first(arm: Any) -> None:
    """From a seed that is a solution the solution is the seed."""
    seed = arm.near(0.4)
    answer = arm.ik(pose_stamped=arm.pose(seed), robot_state=robot_state(seed))
    found = positions(answer.solution)
    assert {name: found[name] for name in seed} == pytest.approx(seed, abs=1e-4)


@pytest.mark.statement('SRV-1', 'M25', 'R22')
def test_ik_with_a_vector_of_poses(arm: Any) -> None:
    """A vector of one pose needs no link; from two on, lengths that differ are -18."""
    pose = arm.pose(arm.near(0.4))
    for names in ([arm.tip], []):
        answer = arm.ik(pose_stamped_vector=[pose], ik_link_names=names)
        assert name_of(answer.error_code) == 'SUCCESS'
    answer = arm.ik(pose_stamped_vector=[pose, pose], ik_link_names=[arm.tip])
    assert name_of(answer.error_code) == 'INVALID_LINK_NAME'


@pytest.mark.statement('SRV-3')
def test_a_timeout_in_nanoseconds_counts(arm: Any) -> None:
    """A timeout below a second is a timeout; the group's own counts where that is longer."""
    answer = arm.ik(pose_stamped=arm.pose(arm.near(0.4)), timeout=Duration(nanosec=200_000_000))
    assert name_of(answer.error_code) == 'SUCCESS'


@pytest.mark.statement('SRV-4', 'E21', 'R15', 'R20')
def test_ik_codes(arm: Any) -> None:
    """-15 group, -21 frame, -31 link or no solution; each with a message."""
    pose = arm.pose(arm.near(0.4))
    far, lost = arm.pose(), arm.pose()
    far.pose.position.x += 50.0
    lost.header.frame_id = 'the_moon'
    for fields, code in (
        ({'pose_stamped': pose, 'group_name': 'no_such_group'}, 'INVALID_GROUP_NAME'),
        ({'pose_stamped': lost}, 'FRAME_TRANSFORM_FAILURE'),
        ({'pose_stamped': pose, 'ik_link_name': 'third_hand'}, 'NO_IK_SOLUTION'),
        ({'pose_stamped': far}, 'NO_IK_SOLUTION'),
        ({'pose_stamped': pose, 'robot_state': robot_state({'no_such_joint': 0.0})},
         'INVALID_ROBOT_STATE'),
    ):
        answer = arm.ik(**fields)
        assert name_of(answer.error_code) == code
        assert answer.error_code.message
        assert answer.error_code.source
        assert not answer.solution.joint_state.name


@pytest.mark.statement('SRV-4')
def test_an_empty_frame_is_the_model_frame(arm: Any) -> None:
    """No frame_id means the model frame; another link's frame is transformed."""
    pose = arm.pose(arm.near(0.4))
    bare = PoseStamped(pose=pose.pose)
    assert name_of(arm.ik(pose_stamped=bare).error_code) == 'SUCCESS'
    other = arm.fk([arm.tip], arm.near(0.4), frame=arm.links[1]).pose_stamped[0]
    assert other.header.frame_id == arm.links[1]
    solution = positions(arm.ik(pose_stamped=other).solution)
    assert_same(arm.pose(solution), pose)


@pytest.mark.statement('SRV-5')
def test_avoid_collisions(arm: Any) -> None:
    """A colliding solution is not returned; with avoid_collisions false it is."""
    seed = arm.near(0.5)
    pose = arm.pose(seed)
    arm.add(thing('wrap', pose.header.frame_id, [box(0.02, 0.02, 0.02)], pose=pose.pose))
    refused = arm.ik(pose_stamped=pose, avoid_collisions=True)
    assert name_of(refused.error_code) == 'NO_IK_SOLUTION'
    assert 'wrap' in refused.error_code.message
    assert name_of(arm.ik(pose_stamped=pose).error_code) == 'SUCCESS'


@pytest.mark.statement('SRV-5')
def test_ik_keeps_constraints(arm: Any) -> None:
    """Constraints of the request hold in the solution."""
    seed = arm.near(0.5)
    name = arm.group_joints[0]
    answer = arm.ik(pose_stamped=arm.pose(seed), constraints=joint_goal({name: seed[name]}, 0.1))
    assert name_of(answer.error_code) == 'SUCCESS'
    assert positions(answer.solution)[name] == pytest.approx(seed[name], abs=0.1001)
    answer = arm.ik(pose_stamped=arm.pose(seed),
                    constraints=joint_goal({name: arm.limits[name][0] + 0.01}, 0.001))
    assert name_of(answer.error_code) == 'NO_IK_SOLUTION'


@pytest.mark.statement('CON-7', 'SRV-1', 'CON-5')
def test_ik_for_what_is_fixed_to_the_tip(arm: Any) -> None:
    """A carried object and its subframe can be the link."""
    item = thing('pen', arm.tip, [box(0.01, 0.01, 0.1)], pose=at(0.0, 0.0, 0.1))
    item.subframe_names, item.subframe_poses = ['point'], [at(0.0, 0.0, 0.05)]
    arm.attach(carried(item, arm.tip, arm.links))
    for link in ('pen', 'pen/point'):
        pose = arm.pose(arm.near(0.4), link)
        solution = positions(arm.ik(pose_stamped=pose, ik_link_name=link).solution)
        assert_same(arm.pose(solution, link), pose)


@pytest.mark.statement('SRV-10', 'E22')
def test_fk_codes(arm: Any) -> None:
    """No name is -18; unknown names and objects of the world are left out and make it -18."""
    assert name_of(arm.fk([]).error_code) == 'INVALID_LINK_NAME'
    arm.add(thing('stone', arm.frame, [box(0.02, 0.02, 0.02)], pose=at(2.0, 0.0, 0.0)))
    assert name_of(arm.fk(['stone']).error_code) == 'INVALID_LINK_NAME'
    answer = arm.fk([arm.tip, 'third_hand'])
    assert name_of(answer.error_code) == 'INVALID_LINK_NAME'
    assert answer.fk_link_names == [arm.tip]
    assert len(answer.pose_stamped) == 1
    assert 'third_hand' in answer.error_code.message


@pytest.mark.statement('SRV-11', 'E22')
def test_fk_frames(arm: Any) -> None:
    """Poses are in the header's frame, stamped; an unknown one is -21."""
    pose = arm.fk([arm.tip], frame=arm.tip).pose_stamped[0]
    assert pose.header.frame_id == arm.tip
    assert xyz(pose.pose.position) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert pose.header.stamp.sec > 0
    assert name_of(arm.fk([arm.tip], frame='the_moon').error_code) == 'FRAME_TRANSFORM_FAILURE'


@pytest.mark.statement('SRV-11')
def test_fk_of_the_present_state(arm: Any) -> None:
    """Without a state the robot's own is meant."""
    assert_same(arm.pose(), arm.pose(arm.positions()))


@pytest.mark.statement('REQ-7')
def test_fk_of_an_unknown_joint(arm: Any) -> None:
    """A state with a joint that the robot lacks is -17, no crash."""
    answer = arm.fk([arm.tip], {'no_such_joint': 1.0})
    assert name_of(answer.error_code) == 'INVALID_ROBOT_STATE'


# ---------------------------------------------------------------- state validity


@pytest.mark.statement('SRV-22', 'UT-1')
def test_a_free_state_is_valid(arm: Any) -> None:
    """A named state in an empty world: valid, no contacts."""
    report = arm.validity(next(iter(arm.states.values())))
    assert report.valid
    assert not report.contacts
    assert not report.constraint_result


@pytest.mark.statement('SRV-22', 'UT-1', 'SRV-21')
def test_a_self_collision_has_contacts(arm: Any) -> None:
    """A state in which two links meet: not valid, with both links named."""
    lows = {name: arm.limits[name][0] for name in arm.group_joints}
    highs = {name: arm.limits[name][1] for name in arm.group_joints}
    folded = [
        {**dict.fromkeys(arm.group_joints, 0.0), a: x[a], b: y[b]}
        for a in arm.group_joints for b in arm.group_joints if a != b
        for x in (lows, highs) for y in (lows, highs)
    ]
    report = next(
        (found for state in folded if not (found := arm.validity(state)).valid), None
    )
    assert report is not None
    assert report.contacts
    for contact in report.contacts:
        assert {contact.contact_body_1, contact.contact_body_2} <= set(arm.links)
        assert contact.header.frame_id == arm.frame
        assert contact.header.stamp.sec > 0


@pytest.mark.statement('SRV-21')
def test_contacts_with_the_world(arm: Any) -> None:
    """Names, types, depth and a unit normal of a contact; one a pair."""
    pose = arm.pose()
    arm.add(thing('wrap', pose.header.frame_id, [box(0.05, 0.05, 0.05)], pose=pose.pose))
    report = arm.validity(arm.positions())
    assert not report.valid
    pairs = [frozenset((one.contact_body_1, one.contact_body_2)) for one in report.contacts]
    assert len(pairs) == len(set(pairs))
    for one in report.contacts:
        types = {one.contact_body_1: one.body_type_1, one.contact_body_2: one.body_type_2}
        assert types['wrap'] == 1
        assert abs(math.hypot(one.normal.x, one.normal.y, one.normal.z) - 1.0) < 1e-6


@pytest.mark.statement('SRV-20')
def test_limits_are_not_asked(arm: Any) -> None:
    """A state beyond a joint limit may be valid; the group '' means all links."""
    name = arm.group_joints[-1]
    state = {**next(iter(arm.states.values())), name: arm.limits[name][1] + 0.2}
    assert arm.validity(state).valid
    assert arm.validity(state, '').valid


@pytest.mark.statement('SRV-20')
def test_an_unknown_group_means_all_links(arm: Any) -> None:
    """
    A state is checked for all links where the group does not exist.

    moveit_core, collision_common.cpp, CollisionData::enableGroup.
    """
    assert arm.validity(arm.positions(), 'no_such_group').valid
    pose = arm.pose()
    arm.add(thing('wrap', pose.header.frame_id, [box(0.05, 0.05, 0.05)], pose=pose.pose))
    assert not arm.validity(arm.positions(), 'no_such_group').valid


@pytest.mark.statement('SCN-15')
def test_the_group_filter(arm: Any) -> None:
    """An object in a link that the group does not move does not concern the group."""
    base = arm.pose(link=arm.links[0]).pose
    base.position.z += 0.02
    arm.add(thing('stone', arm.frame, [box(0.05, 0.05, 0.05)], pose=base))
    state = arm.positions()
    whole, group = arm.validity(state, ''), arm.validity(state)
    touched = {
        name for one in whole.contacts for name in (one.contact_body_1, one.contact_body_2)
    }
    assert group.valid or touched - {'stone'}


@pytest.mark.statement('SRV-20')
def test_constraints_make_a_state_invalid(arm: Any) -> None:
    """A free state that breaks a constraint is not valid."""
    name = arm.group_joints[0]
    state = next(iter(arm.states.values()))
    report = arm.validity(state, constraints=joint_goal({name: state[name] + 1.0}, 0.1))
    assert not report.valid
    assert not report.contacts
