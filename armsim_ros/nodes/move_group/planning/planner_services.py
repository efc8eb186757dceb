# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Services about planners: ``query_planner_interface`` and ``get_``, ``set_planner_params``."""

from __future__ import annotations

from dataclasses import replace

from moveit_msgs.msg import PlannerInterfaceDescription
from moveit_msgs.srv import GetPlannerParams, SetPlannerParams
from moveit_msgs.srv import QueryPlannerInterfaces as Service

from armsim_ros.config.move_group.ompl_planning import OmplSettings
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.planning.pilz.commands import COMMANDS
from armsim_ros.planning.pilz.commands import PIPELINE as PILZ

#: The adapters of MoveIt's own configuration, which count where the user lists none.
REQUEST_ADAPTERS = (
    'ResolveConstraintFrames', 'ValidateWorkspaceBounds', 'CheckStartStateBounds',
    'CheckStartStateCollision',
)
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
    """
    Reads and changes the parameters of planner configurations, from the next plan on.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(GetPlannerParams, 'get_planner_params', self._get)
        context.serve(SetPlannerParams, 'set_planner_params', self._set)

    async def _get(
        self, request: GetPlannerParams.Request, response: GetPlannerParams.Response
    ) -> GetPlannerParams.Response:
        settings = self._context.planner.settings
        if request.pipeline_id and request.pipeline_id not in settings.pipelines:
            return response
        configs, config = settings.planners.configs, request.planner_config
        merged = dict(configs.get(config, {}))
        if request.group:
            merged = {**configs.get(config_name(request.group, config), {}), **merged}
        response.params.keys = list(merged)
        response.params.values = [str(value) for value in merged.values()]
        response.params.descriptions = [''] * len(merged)
        return response

    async def _set(
        self, request: SetPlannerParams.Request, response: SetPlannerParams.Response
    ) -> SetPlannerParams.Response:
        context, keys, values = self._context, request.params.keys, request.params.values
        settings = context.planner.settings
        if request.pipeline_id and request.pipeline_id not in settings.pipelines:
            context.logger.error(
                f"set_planner_params: pipeline '{request.pipeline_id}' is not known; allowed: "
                f"{', '.join(settings.pipelines)}"
            )
        elif len(keys) != len(values):
            context.logger.error(
                f'set_planner_params: {len(keys)} keys and {len(values)} values; nothing changed'
            )
        else:
            name = config_name(request.group, request.planner_config)
            configs = dict(settings.planners.configs)
            old = {} if request.replace else dict(configs.get(name, {}))
            if 'type' in configs.get(name, {}):
                old['type'] = configs[name]['type']
            configs[name] = {**old, **dict(zip(keys, values, strict=False))}
            planners = replace(settings.planners, configs=configs)
            context.planner.settings = replace(settings, planners=planners)
        return response


def config_name(group: str, config: str) -> str:
    """Return the name of a configuration for a group."""
    return f'{group}[{config}]' if group else config


NAMES = {'ompl': 'OMPL', PILZ: 'Pilz Industrial Motion Planner'}


class QueryPlannerInterface:
    """
    Lists the pipelines and their planners.

    :param context: the parts of move_group.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        context.serve(Service, 'query_planner_interface', self._answer)

    async def _answer(
        self, request: Service.Request, response: Service.Response
    ) -> Service.Response:
        settings = self._context.planner.settings
        groups = tuple(self._context.robot.semantic.groups)
        response.planner_interfaces = [
            PlannerInterfaceDescription(
                name=NAMES.get(pipeline, pipeline),
                pipeline_id=pipeline,
                planner_ids=list(
                    COMMANDS if pipeline == PILZ else settings.planners.planner_ids(groups)
                ),
            )
            for pipeline in settings.pipelines
        ]
        return response
