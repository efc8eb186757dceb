# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services about planners, and topics that show plans and the contacts that refused them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from moveit_msgs.msg import (
    DisplayTrajectory,
    PlannerInterfaceDescription,
    RobotState,
    RobotTrajectory,
)
from moveit_msgs.srv import GetPlannerParams, SetPlannerParams
from moveit_msgs.srv import QueryPlannerInterfaces as Service
from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.config.ompl_planning import OmplSettings
from armsim_ros.nodes.conversions.motion_plan_request import display_trajectory_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.pilz.commands import COMMANDS
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ
from armsim_ros.planning.search.planners import PlannerTable

#: The adapters of MoveIt's own configuration, which count where the user lists none.
REQUEST_ADAPTERS = (
    'ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
    'CheckStartStateCollision')
RESPONSE_ADAPTERS = ('AddTimeOptimalParameterization', 'ValidateSolution', 'DisplayMotionPath')
PILZ_RESPONSE_ADAPTERS = RESPONSE_ADAPTERS[1:]


def request_adapters(settings: OmplSettings, pipeline: str) -> tuple[str, ...]:
    """Return what a request passes before the planner, without the packages' names."""
    listed = None if pipeline == PILZ else settings.request_adapters
    return REQUEST_ADAPTERS if listed is None else tuple(map(_short, listed))


def response_adapters(settings: OmplSettings, pipeline: str) -> tuple[str, ...]:
    """Return what a plan passes after the planner, without the packages' names."""
    if pipeline == PILZ:
        return PILZ_RESPONSE_ADAPTERS
    listed = settings.response_adapters
    return RESPONSE_ADAPTERS if listed is None else tuple(map(_short, listed))


def _short(adapter: str) -> str:
    return adapter.rpartition('/')[2]


class PlannerParams:
    """Reads and changes the parameters of planner configurations, from the next plan on."""

    def __init__(self, context: Context) -> None:
        self._context = context
        #: Kept for clients; its commands have no parameters.
        self._pilz = PlannerTable()
        context.serve(GetPlannerParams, 'get_planner_params', self._get)
        context.serve(SetPlannerParams, 'set_planner_params', self._set)

    async def _get(
        self, request: GetPlannerParams.Request, response: GetPlannerParams.Response
    ) -> None:
        settings = self._context.planner.settings
        pipeline = request.pipeline_id or settings.default_pipeline
        if pipeline not in settings.pipelines:
            return
        configs, config = self._planners(pipeline).configs, request.planner_config
        merged = dict(configs.get(config, {}))
        if request.group:
            merged = {**configs.get(config_name(request.group, config), {}), **merged}
        response.params.keys = list(merged)
        response.params.values = [_text(value) for value in merged.values()]
        response.params.descriptions = [''] * len(merged)

    async def _set(self, request: SetPlannerParams.Request, _: object) -> None:
        context, keys, values = self._context, request.params.keys, request.params.values
        settings = context.planner.settings
        pipeline = request.pipeline_id or settings.default_pipeline
        if pipeline not in settings.pipelines:
            context.logger.error(
                f"set_planner_params: pipeline '{pipeline}' is not known; allowed: "
                f"{', '.join(settings.pipelines)}")
        elif len(keys) != len(values):
            context.logger.error(
                f'set_planner_params: {len(keys)} keys and {len(values)} values; nothing changed')
        else:
            name = config_name(request.group, request.planner_config)
            planners = self._planners(pipeline)
            configs = dict(planners.configs)
            old = {} if request.replace else dict(configs.get(name, {}))
            if 'type' in configs.get(name, {}):
                old['type'] = configs[name]['type']
            configs[name] = {**old, **dict(zip(keys, values, strict=False))}
            planners = replace(planners, configs=configs)
            if pipeline == PILZ:
                self._pilz = planners
            else:
                context.planner.settings = replace(settings, planners=planners)

    def _planners(self, pipeline: str) -> PlannerTable:
        """Return the configurations of a pipeline."""
        return self._pilz if pipeline == PILZ else self._context.planner.settings.planners


def _text(value: object) -> str:
    """Return a parameter's value as rclcpp writes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def config_name(group: str, config: str) -> str:
    """Return the name of a configuration for a group."""
    return f'{group}[{config}]' if group else config


NAMES = {'ompl': 'OMPL', PILZ: 'Pilz Industrial Motion Planner'}


class QueryPlannerInterface:
    """Lists the pipelines and their planners."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'query_planner_interface', self._fill)

    async def _fill(self, _: Service.Request, response: Service.Response) -> None:
        settings = self._context.planner.settings
        groups = tuple(self._context.robot.semantic.groups)
        response.planner_interfaces = [
            PlannerInterfaceDescription(
                name=NAMES.get(pipeline, pipeline),
                pipeline_id=pipeline,
                planner_ids=list(
                    COMMANDS if pipeline == PILZ else settings.planners.planner_ids(groups)))
            for pipeline in settings.pipelines]


#: Contacts of a state that are shown, the diameter of a marker [m], its lifetime in RViz [s].
MOST, SIZE, LIFETIME = 10, 0.07, 60


class DisplayContacts:
    """
    Publishes contacts as MoveIt does: red spheres, those of the previous plan deleted first.

    :param topic: '' publishes nothing.
    :param frame: of the contacts: the model frame.
    """

    def __init__(self, node: Node, topic: str, frame: str) -> None:
        self._node, self._frame = node, frame
        self._publisher = node.create_publisher(MarkerArray, topic, 10) if topic else None

    def publish(self, contacts: Sequence[Contact]) -> None:
        """Publish contacts in a message, if it has subscribers."""
        if self._publisher is None or not self._publisher.get_subscription_count():
            return
        markers = [Marker(action=Marker.DELETEALL)]
        seen: Counter[str] = Counter()
        for contact in contacts[:MOST]:
            pair = f'{contact.body1}={contact.body2}'
            markers.append(self._marker(pair, seen[pair], contact))
            seen[pair] += 1
        self._publisher.publish(MarkerArray(markers=markers))

    def _marker(self, pair: str, number: int, contact: Contact) -> Marker:
        marker = Marker(ns=pair, id=number, type=Marker.SPHERE, action=Marker.ADD)
        marker.header.frame_id = self._frame
        marker.header.stamp = self._node.get_clock().now().to_msg()
        place = marker.pose.position
        place.x, place.y, place.z = map(float, contact.position)
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = SIZE
        marker.color.r, marker.color.a = 1.0, 0.8
        marker.lifetime.sec = LIFETIME
        return marker


TOPIC = 'display_planned_path'


class DisplayPlannedPath:
    """
    Publishes trajectories, for RViz to animate.

    A pipeline publishes its plans where its response adapters have DisplayMotionPath, on the
    topic ``<pipeline>.display_path_topic``; compute_cartesian_path always does.

    :param model_id: the robot's name.
    :param settings: of the pipelines.
    """

    def __init__(self, node: Node, model_id: str, settings: OmplSettings) -> None:
        self._model_id, self._settings = model_id, settings
        self._publishers = {
            topic: node.create_publisher(DisplayTrajectory, topic, 10)
            for topic in {TOPIC, settings.display_path_topic}}

    def publish(self, start: RobotState, trajectory: RobotTrajectory, topic: str = TOPIC) -> None:
        """Publish a trajectory and the state that it begins in."""
        self._publishers[topic].publish(
            display_trajectory_message(self._model_id, [trajectory], start))

    def publish_plan(self, pipeline: str, start: RobotState, trajectory: RobotTrajectory) -> None:
        """Publish what a pipeline has planned, if it is configured to."""
        if 'DisplayMotionPath' in response_adapters(self._settings, pipeline):
            topic = TOPIC if pipeline == PILZ else self._settings.display_path_topic
            self.publish(start, trajectory, topic)
