# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The service ``/get_simulator_features``."""

from __future__ import annotations

import platform
from typing import Any

import mujoco
from rclpy.node import Node
from simulation_interfaces.msg import SimulatorFeatures as Features
from simulation_interfaces.srv import GetSimulatorFeatures

from armsim_ros.sim.world_files.resources import FORMATS

#: The features that have a service here.
_FEATURES = (
    Features.SPAWNING,
    Features.DELETING,
    Features.ENTITY_TAGS,
    Features.ENTITY_BOUNDS,
    Features.ENTITY_BOUNDS_BOX,
    Features.ENTITY_CATEGORIES,
    Features.SPAWNING_RESOURCE_STRING,
    Features.ENTITY_STATE_GETTING,
    Features.ENTITY_STATE_SETTING,
    Features.ENTITY_INFO_GETTING,
    Features.ENTITY_INFO_SETTING,
    Features.SPAWNABLES,
    Features.SIMULATION_RESET,
    Features.SIMULATION_RESET_STATE,
    Features.SIMULATION_RESET_SPAWNED,
    Features.SIMULATION_STATE_GETTING,
    Features.SIMULATION_STATE_SETTING,
    Features.SIMULATION_STATE_PAUSE,
    Features.STEP_SIMULATION_SINGLE,
    Features.STEP_SIMULATION_MULTIPLE,
    Features.STEP_SIMULATION_ACTION,
    Features.WORLD_LOADING,
    Features.WORLD_RESOURCE_STRING,
    Features.WORLD_TAGS,
    Features.WORLD_UNLOADING,
    Features.WORLD_INFO_GETTING,
    Features.AVAILABLE_WORLDS,
    Features.SPAWNING_ENTITIES,
)


class SimulatorFeatures:
    """
    Lists what this simulator can do.

    :param node: the node that serves.
    :param timestep: of the physics [s].
    :param lockstep: whether time moves by steps alone; only then can it be reset.
    """

    def __init__(self, node: Node, timestep: float, *, lockstep: bool) -> None:
        self._info = (
            f'armsim_ros with MuJoCo {mujoco.__version__}, Python {platform.python_version()}; '
            f'mode: {"lockstep" if lockstep else "real time"}; physics step: {timestep:g} s')
        self._features = [
            int(feature)
            for feature in (*_FEATURES, *((Features.SIMULATION_RESET_TIME,) if lockstep else ()))
        ]
        node.create_service(GetSimulatorFeatures, '/get_simulator_features', self._answer)

    def _answer(self, _: Any, response: Any) -> Any:
        response.features.features = self._features
        response.features.spawn_formats = list(FORMATS)
        response.features.custom_info = self._info
        return response
