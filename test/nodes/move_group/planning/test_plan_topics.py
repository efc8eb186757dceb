# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics that tell of a plan: its stages, and what touched where it was refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from moveit_msgs.msg import MotionPlanRequest, MotionPlanResponse, PipelineState
from moveit_msgs.srv import GetMotionPlan
import pytest
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.nodes.move_group.planning.pipeline_state import PipelineStates

BEFORE = ['ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
          'CheckStartStateCollision']  # fmt: skip
AFTER = ['AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath']


def told(code: int, source: str = '', heard: int = 1, pipeline: str = 'ompl',
         **settings: Any) -> list[tuple[str, int]]:  # fmt: skip
    """Return the stages that are told of a plan, with the codes that they have."""
    published: list[PipelineState] = []
    publisher = SimpleNamespace(
        get_subscription_count=lambda: heard, publish=published.append)  # fmt: skip
    node: Any = SimpleNamespace(create_publisher=lambda kind, topic, depth: publisher)
    states = PipelineStates(node, OmplSettings(**settings))
    response = MotionPlanResponse()
    response.error_code.val, response.error_code.source = code, source
    states.begin(MotionPlanRequest())
    states.end(MotionPlanRequest(), response, pipeline)
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
                  response_adapters=(), pipeline='pilz_industrial_motion_planner')  # fmt: skip
    assert [stage for stage, _ in stages] == [
        '', 'CheckStartStateBounds', 'Pilz Industrial Motion Planner']  # fmt: skip


@pytest.mark.parametrize('quiet', [{'heard': 0}, {'progress_topic': ''}])
def test_nothing_is_told(quiet: dict[str, Any]) -> None:
    """Nothing is made where nobody listens, and where there is no topic."""
    assert told(1, **quiet) == []


def test_stages_and_contacts_from_outside(stack: Any) -> None:
    """A goal that collides is told stage by stage, and what touches is shown in the frame."""
    client = stack.client
    stages = client.collect('/pipeline_state', PipelineState)
    markers = client.collect('/display_contacts', MarkerArray)
    # The hand is in the upper arm.
    places = (0.8, -0.7, -2.6, -2.7, 1.7, 2.3)
    folded = {f'joint_{number}': place for number, place in enumerate(places, start=1)}
    request = GetMotionPlan.Request(motion_plan_request=stack.request(folded))
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
