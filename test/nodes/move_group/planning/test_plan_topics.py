# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics that tell of a plan: its stages, and what touched where it was refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from builtin_interfaces.msg import Time
from moveit_msgs.msg import (
    MotionPlanRequest,
    MotionPlanResponse,
    MotionSequenceItem,
    MotionSequenceRequest,
    PipelineState,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.srv import GetMotionPlan, GetMotionSequence
import numpy as np
import pytest
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.config.ompl_planning import PipelineSettings
from armsim_ros.nodes.move_group.planning.planner_services import (
    DisplayContacts,
    DisplayPlannedPath,
)
from armsim_ros.nodes.move_group.planning.planning_job import PipelineStates
from armsim_ros.planning.collision.contacts import BodyType, Contact

BEFORE = ['ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
          'CheckStartStateCollision']
AFTER = ['AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath']
#: The hand is in the upper arm.
FOLDED = {f'joint_{number}': place for number, place in enumerate(
    (0.8, -0.7, -2.6, -2.7, 1.7, 2.3), start=1)}
PLUGIN = ('pilz_industrial_motion_planner/CommandPlanner',)


def told(code: int, source: str = '', heard: int = 1, **settings: Any) -> list[tuple[str, int]]:
    """Return the stages that are told of a plan, with the codes that they have."""
    published: list[PipelineState] = []
    publisher = SimpleNamespace(
        get_subscription_count=lambda: heard, publish=published.append)
    node: Any = SimpleNamespace(create_publisher=lambda kind, topic, depth: publisher)
    states = PipelineStates(node, PipelineSettings(**settings))
    response = MotionPlanResponse()
    response.error_code.val, response.error_code.source = code, source
    states.begin(MotionPlanRequest())
    states.end(MotionPlanRequest(), response)
    return [(one.pipeline_stage, one.response.error_code.val) for one in published]


def test_stages_of_a_success() -> None:
    """An empty stage, then every adapter and the planner by their names."""
    stages = ['', *BEFORE, 'OMPL', *AFTER]
    assert told(1) == [('', 0), *((stage, 1) for stage in stages[1:])]


@pytest.mark.parametrize(
    ('source', 'last'),
    [('CheckStartStateCollision', 'CheckStartStateCollision'), ('goal sampling', 'OMPL'),
     ('AddTimeOptimalParameterization', 'AddTimeOptimalParameterization')],
)
def test_stages_end_where_the_request_was_refused(source: str, last: str) -> None:
    """The stage that refused it is the last one, with its code; those before have passed."""
    *passed, end = told(-5, source)
    assert end == (last, -5)
    assert {code for _, code in passed[1:]} == {1}


def test_adapters_of_the_user() -> None:
    """They are told by the names that they have in the user's file."""
    stages = told(1, request_adapters=('default_planning_request_adapters/CheckStartStateBounds',),
                  response_adapters=())
    assert [stage for stage, _ in stages] == ['', 'CheckStartStateBounds', 'OMPL']


def test_adapters_of_pilz() -> None:
    """Its plans have times already: no adapter adds them."""
    stages = told(1, planning_plugins=PLUGIN)
    assert [stage for stage, _ in stages] == [
        '', *BEFORE, 'Pilz Industrial Motion Planner', *AFTER[1:]]


class FakeNode:
    """Publishers that keep their messages by topic; everybody listens."""

    def __init__(self) -> None:
        self.published: dict[str, list[Any]] = {}

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        """Return a publisher."""
        heard = self.published.setdefault(topic, [])
        return SimpleNamespace(get_subscription_count=lambda: 1, publish=heard.append)

    def get_clock(self) -> Any:
        """Return a clock that stands at 7 s."""
        return SimpleNamespace(now=lambda: SimpleNamespace(to_msg=lambda: Time(sec=7)))


@pytest.mark.parametrize(('adapters', 'topics'), [
    (None, ['mine']), (('x/DisplayMotionPath',), ['mine']), (('x/ValidateSolution',), []),
])
def test_plans_are_published_by_an_adapter(
    adapters: tuple[str, ...] | None, topics: list[str]
) -> None:
    """
    DisplayMotionPath publishes one message for a plan, on the topic of its pipeline.

    Upstream: display_motion_path.cpp.
    """
    node: Any = FakeNode()
    display = DisplayPlannedPath(node, 'robot', {
        'other': PipelineSettings(display_path_topic='others'),
        'fast': PipelineSettings(display_path_topic='mine', response_adapters=adapters)})
    display.publish_plan('fast', RobotState(), RobotTrajectory())
    assert [topic for topic, heard in node.published.items() if heard] == topics
    assert all(len(message.trajectory) == 1
               for topic in topics for message in node.published[topic])


def contact(one: str, other: str) -> Contact:
    """Return a contact at 1, 2, 3."""
    return Contact(one, other, BodyType.ROBOT_LINK, BodyType.WORLD_OBJECT,
                   np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0]), 0.01)


def test_contacts_are_red_spheres() -> None:
    """
    All markers are deleted, then each pair has spheres in a namespace of its own.

    Upstream: validate_path.cpp, collision_tools.cpp getCollisionMarkersFromContacts.
    """
    node: Any = FakeNode()
    contacts = [contact('a', 'b'), contact('a', 'c'), contact('a', 'b')]
    DisplayContacts(node, 'shown', 'world').publish(contacts)
    (message,) = node.published['shown']
    first, *spheres = message.markers
    assert first.action == Marker.DELETEALL
    assert [(one.ns, one.id) for one in spheres] == [('a=b', 0), ('a=c', 0), ('a=b', 1)]
    one = spheres[0]
    assert (one.type, one.action, one.lifetime.sec) == (Marker.SPHERE, Marker.ADD, 60)
    assert (one.scale.x, one.scale.y, one.scale.z) == (0.07, 0.07, 0.07)
    assert (one.color.r, one.color.g, one.color.b) == (1.0, 0.0, 0.0)
    assert one.color.a == pytest.approx(0.8)
    assert (one.header.frame_id, one.header.stamp.sec) == ('world', 7)
    assert (one.pose.position.x, one.pose.orientation.w) == (1.0, 1.0)


@pytest.mark.parametrize('quiet', [{'heard': 0}, {'progress_topic': ''}])
def test_nothing_is_told(quiet: dict[str, Any]) -> None:
    """Nothing is made where nobody listens, and where there is no topic."""
    assert told(1, **quiet) == []


def test_stages_and_contacts_from_outside(stack: Any) -> None:
    """A goal that collides is told stage by stage, and what touches is shown in the frame."""
    client = stack.client
    stages = client.collect('/pipeline_state', PipelineState)
    markers = client.collect('/display_contacts', MarkerArray)
    request = GetMotionPlan.Request(motion_plan_request=stack.request(FOLDED))
    for _ in range(20):  # until the publishers have found the subscriptions
        answer = client.call('/plan_kinematic_path', GetMotionPlan, request)
        assert answer.motion_plan_response.error_code.val == -12
        if markers.messages and stages.messages:
            break
    first, *others = markers.wait(1)[-1].markers
    assert first.action == Marker.DELETEALL
    assert 1 <= len(others) <= 10
    assert others[0].header.frame_id
    stages.wait_for(lambda message: message.pipeline_stage == 'OMPL')


def test_stages_and_contacts_of_a_sequence(stack: Any) -> None:
    """
    Each motion of a sequence is told as a plan of its own, up to the motion that collides.

    Upstream: command_list_manager.cpp, solveSequenceItems; planning_pipeline.cpp, generatePlan.
    """
    client = stack.client
    stages = client.collect('/pipeline_state', PipelineState)
    markers = client.collect('/display_contacts', MarkerArray)
    items = [MotionSequenceItem(req=stack.request(state)) for state in ('home', FOLDED)]
    items[1].req.start_state = RobotState()
    request = GetMotionSequence.Request(request=MotionSequenceRequest(items=items))
    for _ in range(20):  # until the publishers have found the subscriptions
        answer = client.call('/plan_sequence_path', GetMotionSequence, request)
        assert answer.response.error_code.val == 99999
        if markers.messages and stages.messages:
            break
    assert len(markers.wait(1)[-1].markers) > 1
    stages.wait_for(lambda message: message.pipeline_stage == 'DisplayMotionPath')
    stages.wait_for(lambda message: message.response.error_code.val == -12)
