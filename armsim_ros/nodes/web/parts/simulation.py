# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The simulation's clock and objects, where simulation_interfaces are served; cameras."""

from __future__ import annotations

import base64
import io
from typing import Any, Literal

import numpy as np
from PIL import Image as Picture
from pydantic import Field
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from sensor_msgs.msg import CompressedImage, Image
from simulation_interfaces.msg import EntityCategory, Result, SimulationState
from simulation_interfaces.srv import (
    GetEntitiesStates,
    GetEntityBounds,
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    SetSimulationState,
    StepSimulation,
)

from armsim_ros.errors import ArmsimError
from armsim_ros.model.robot_model import RobotModel
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.objects_drawing import EntitiesDrawing, Entity
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.parts.watch import WatchPart

_SERVICES = {
    '/get_simulator_features': GetSimulatorFeatures,
    '/get_simulation_state': GetSimulationState,
    '/set_simulation_state': SetSimulationState,
    '/step_simulation': StepSimulation,
    '/reset_simulation': ResetSimulation,
    '/get_entities_states': GetEntitiesStates,
    '/get_entity_bounds': GetEntityBounds,
    '/simulation/get_parameters': GetParameters,
    '/simulation/set_parameters': SetParameters,
}
_STATES = {SimulationState.STATE_STOPPED: 'stopped', SimulationState.STATE_PLAYING: 'playing',
           SimulationState.STATE_PAUSED: 'paused'}
_OBJECTS = [EntityCategory(category=kind) for kind in (
    EntityCategory.CATEGORY_OBJECT, EntityCategory.CATEGORY_DYNAMIC_OBJECT,
    EntityCategory.CATEGORY_STATIC_OBJECT)]
#: More objects than this are not shown.
_MOST_ENTITIES = 100
_SPEED = 'real_time_factor'
_PERIOD = 1.0
_PICTURES = {'sensor_msgs/msg/Image': Image, 'sensor_msgs/msg/CompressedImage': CompressedImage}
#: Pictures a second, and their longest side [pixels].
_PICTURE_RATE, _PICTURE_SIZE = 5.0, 480


class Control(PanelCommand):
    """What the simulation is to do."""

    what: Literal['pause', 'play', 'step', 'reset']


class Speed(PanelCommand):
    """Simulated time per wall time; 0 is as fast as it goes."""

    factor: float = Field(ge=0.0, le=100.0)


class Watch(PanelCommand):
    """The topic of pictures to show; '' for none."""

    topic: str = ''


class SimulationPart(Part):
    """Pauses, steps and resets; shows entities and camera pictures."""

    def __init__(self, page: Page, watch: WatchPart, robot_part: RobotPart) -> None:
        super().__init__(page)
        self._watch = watch
        self._drawing = EntitiesDrawing(page.scene, robot_part.node_of)
        self._bounds: dict[str, Any] = {}
        self._prepared: set[str] = set()
        self._camera: Any = None
        self._topic = ''

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'simulation': (Control, self._control), 'camera': (Watch, self._choose),
                'simulation_speed': (Speed, self._set_speed)}

    def on_robot(self, robot: RobotModel) -> None:
        """Move the objects into the frames of another robot."""
        self._drawing.show([])

    async def run(self) -> None:
        """Publish the state of the simulation, where it has services for that."""
        self.page.start(self._look_through_camera())
        while True:
            for name, kind in _SERVICES.items():
                if name in self._watch.services and name not in self._prepared:
                    self._prepared.add(name)
                    self.page.link.prepare(kind, name)
            served = sorted(name for name in _SERVICES if name in self._watch.services)
            cameras = sorted(name for name, kind in self._watch.topics.items()
                             if kind in _PICTURES)
            if '/get_simulator_features' in served or cameras:
                entities = await self._entities() if '/get_entities_states' in served else []
                self._draw(entities)
                self.page.publish('simulation', {
                    'state': await self._state(), 'served': served, 'cameras': cameras,
                    'camera': self._topic, 'speed': await self._speed(),
                    'entities': [entity.form() for entity in entities]})
            else:
                self._draw([])
                self.page.publish('simulation', None)
            await self._watch.rest(_PERIOD)

    async def _state(self) -> str:
        try:
            answer = await self.page.call(GetSimulationState, '/get_simulation_state', None, 2.0)
        except ArmsimError:
            return ''
        return _STATES.get(answer.state.state, 'busy')

    async def _speed(self) -> float | None:
        """Return simulated time per wall time, None where it is not published."""
        if '/simulation/set_parameters' not in self._watch.services:
            return None
        try:
            (value,) = (await self.page.call(
                GetParameters, '/simulation/get_parameters',
                GetParameters.Request(names=[_SPEED]), 2.0)).values
        except (ArmsimError, ValueError):
            return None
        return value.double_value if value.type == ParameterType.PARAMETER_DOUBLE else None

    async def _set_speed(self, _session: Session, command: Speed) -> None:
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=command.factor)
        (result,) = (await self.page.call(
            SetParameters, '/simulation/set_parameters', SetParameters.Request(
                parameters=[Parameter(name=_SPEED, value=value)]))).results
        if not result.successful:
            raise ArmsimError(result.reason or f'{_SPEED} was not changed')

    async def _entities(self) -> list[Entity]:
        """Return the objects of the simulated world, each with the room that it takes."""
        request = GetEntitiesStates.Request()
        request.filters.categories = _OBJECTS
        try:
            answer = await self.page.call(GetEntitiesStates, '/get_entities_states', request, 2.0)
        except ArmsimError:
            return []
        names = list(answer.entities)[:_MOST_ENTITIES]
        if set(names) != set(self._bounds):
            self._bounds = {name: await self._bounds_of(name) for name in names}
        return [Entity(name, state.header.frame_id, state.pose, self._bounds[name])
                for name, state in zip(names, answer.states, strict=False)]

    async def _bounds_of(self, name: str) -> Any:
        try:
            return (await self.page.call(
                GetEntityBounds, '/get_entity_bounds',
                GetEntityBounds.Request(entity=name), 2.0)).bounds
        except ArmsimError:
            return None

    def _draw(self, entities: list[Entity]) -> None:
        """Draw, paler, what is simulated and not in the planning scene."""
        planned = {item['id'] for item in self.page.shared.get('objects') or ()}
        self._drawing.show([entity for entity in entities if entity.name not in planned])

    async def _control(self, _session: Session, command: Control) -> None:
        request: Any
        if command.what == 'step':
            name, request = '/step_simulation', StepSimulation.Request(steps=1)
        elif command.what == 'reset':
            name, request = '/reset_simulation', ResetSimulation.Request()
        else:
            name, request = '/set_simulation_state', SetSimulationState.Request()
            request.state.state = (SimulationState.STATE_PAUSED if command.what == 'pause'
                                   else SimulationState.STATE_PLAYING)
        result = (await self.page.call(_SERVICES[name], name, request)).result
        already = getattr(SetSimulationState.Response, 'ALREADY_IN_TARGET_STATE', 101)
        if result.result not in (Result.RESULT_OK, already):
            raise ArmsimError(f'{name}: {result.error_message or "refused"}')

    async def _choose(self, _session: Session, command: Watch) -> None:
        kind = self._watch.topics.get(command.topic, '')
        if command.topic and kind not in _PICTURES:
            raise ArmsimError(f"'{command.topic}' publishes no images")
        if self._camera is not None:
            self._camera.close()
            self._camera = None
        self._topic = command.topic
        self.page.publish('picture', None)
        if command.topic:
            self._camera = self.page.link.poll(_PICTURES[kind], command.topic, qos.COMMAND)

    async def _look_through_camera(self) -> None:
        while True:
            news = self._camera.take() if self._camera is not None else []
            if news:
                try:
                    self.page.publish('picture', picture_url(news[-1]))
                except ValueError as error:
                    self.page.publish('picture', None)
                    for session in self.page.sessions.values():
                        session.note(f"'{self._topic}': {error}")
            await self._watch.rest(1.0 / _PICTURE_RATE)


def picture_url(message: Any) -> str:
    """
    Return an image message as a data URL, small enough to be sent often.

    :raises ValueError: its encoding is none that is shown, or its bytes do not fit.
    """
    if isinstance(message, CompressedImage):
        picture: Picture.Image = Picture.open(io.BytesIO(bytes(message.data)))
    elif message.encoding == '32FC1':
        depths = np.frombuffer(bytes(message.data), np.float32).reshape(message.height, -1)
        picture = Picture.fromarray(_shades(depths[:, :message.width]))
    else:
        modes = {'rgb8': ('RGB', 3), 'bgr8': ('RGB', 3), 'rgba8': ('RGBA', 4), 'mono8': ('L', 1)}
        if message.encoding not in modes:
            raise ValueError(f"encoding '{message.encoding}' is not shown; shown are: "
                             f"{', '.join(modes)}, 32FC1")
        mode, depth = modes[message.encoding]
        rows = np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, message.step)
        pixels = rows[:, :message.width * depth].reshape(message.height, message.width, depth)
        if message.encoding == 'bgr8':
            pixels = pixels[..., ::-1]
        picture = Picture.fromarray(np.ascontiguousarray(pixels.squeeze()), mode)
    picture = picture.convert('RGB')
    picture.thumbnail((_PICTURE_SIZE, _PICTURE_SIZE))
    data = io.BytesIO()
    picture.save(data, 'JPEG', quality=75)
    return f'data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}'


def _shades(depths: Any) -> Any:
    """Return depths [m] as shades of grey: bright is near, black where none was measured."""
    known = np.isfinite(depths)
    near, far = (depths[known].min(), depths[known].max()) if known.any() else (0.0, 0.0)
    shades = 255.0 - 200.0 * (np.where(known, depths, far) - near) / max(far - near, 1e-6)
    return np.where(known, shades, 0.0).astype(np.uint8)
