# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The services ``get_planner_params`` and ``set_planner_params``."""

from __future__ import annotations

from dataclasses import replace

from moveit_msgs.srv import GetPlannerParams, SetPlannerParams

from armsim_ros.nodes.move_group.context import Context


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
