# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services about planners, and topics that show plans and the contacts that refused them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
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

from armsim_ros.config.ompl_planning import PipelineSettings, Planner
from armsim_ros.nodes.conversions.motion_plan_request import display_trajectory_message
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.collision.contacts import Contact
from armsim_ros.planning.context import PlanningPipeline
from armsim_ros.planning.pilz.commands import COMMANDS


def without_package(adapters: Sequence[str]) -> tuple[str, ...]:
    """Return the adapters' own names."""
    return tuple(adapter.rpartition('/')[2] for adapter in adapters)


class PlannerParams:
    """Reads and changes the parameters of planner configurations, from the next plan on."""

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(GetPlannerParams, 'get_planner_params', self._get)
        context.serve(SetPlannerParams, 'set_planner_params', self._set)

    async def _get(
        self, request: GetPlannerParams.Request, response: GetPlannerParams.Response
    ) -> None:
        settings = self._context.planner.settings
        pipeline = request.pipeline_id or settings.default_pipeline
        if pipeline not in settings.pipelines:
            return
        configs, config = settings.pipelines[pipeline].planners.configs, request.planner_config
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
            old_pipeline = settings.pipelines[pipeline]
            configs = dict(old_pipeline.planners.configs)
            old = {} if request.replace else dict(configs.get(name, {}))
            if 'type' in configs.get(name, {}):
                old['type'] = configs[name]['type']
            configs[name] = {**old, **dict(zip(keys, values, strict=False))}
            changed = replace(
                old_pipeline, planners=replace(old_pipeline.planners, configs=configs))
            context.planner.settings = replace(
                settings, pipelines={**settings.pipelines, pipeline: changed})


def _text(value: object) -> str:
    """Return a parameter's value as rclcpp writes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def config_name(group: str, config: str) -> str:
    """Return the name of a configuration for a group."""
    return f'{group}[{config}]' if group else config


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
                name=pipeline.planner.value, pipeline_id=name,
                planner_ids=list(_planner_ids(pipeline, groups)))
            for name, pipeline in settings.pipelines.items()]


def _planner_ids(pipeline: PlanningPipeline, groups: Sequence[str]) -> Sequence[str]:
    if pipeline.planner is Planner.PILZ:
        return COMMANDS
    return pipeline.planners.planner_ids(groups)


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
    :param pipelines: planning pipeline -> its settings.
    """

    def __init__(
        self, node: Node, model_id: str, pipelines: Mapping[str, PipelineSettings]
    ) -> None:
        self._model_id, self._pipelines = model_id, pipelines
        self._publishers = {
            topic: node.create_publisher(DisplayTrajectory, topic, 10)
            for topic in {TOPIC, *(each.display_path_topic for each in pipelines.values())}}

    def publish(self, start: RobotState, trajectory: RobotTrajectory, topic: str = TOPIC) -> None:
        """Publish a trajectory and the state that it begins in."""
        self._publishers[topic].publish(
            display_trajectory_message(self._model_id, [trajectory], start))

    def publish_plan(self, pipeline: str, start: RobotState, trajectory: RobotTrajectory) -> None:
        """Publish what a pipeline has planned, if it is configured to."""
        settings = self._pipelines[pipeline]
        if 'DisplayMotionPath' in without_package(settings.used_response_adapters):
            self.publish(start, trajectory, settings.display_path_topic)
