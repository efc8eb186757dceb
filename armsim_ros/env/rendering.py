# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of an environment, drawn without a screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import Triple
from armsim_ros.errors import ConfigError, Problem, ResourceError

PACKAGES = 'libegl1 libegl-mesa0 libgl1-mesa-dri'


class View(Settings):
    """From where a picture is taken, and how large it is."""

    width: int = parameter(640, '[pixels]', ge=1, le=4096)
    height: int = parameter(480, '[pixels]', ge=1, le=4096)
    lookat: Triple = parameter((0.0, 0.1, 1.2), 'the point in the middle, in the world [m]')
    distance: float = parameter(1.8, 'from that point [m]', gt=0.0)
    azimuth: float = parameter(120.0, 'about z [degrees]')
    elevation: float = parameter(-25.0, 'above the horizon is negative [degrees]')


def view_from(given: Mapping[str, Any]) -> View:
    """
    Return a view of arguments.

    :raises ConfigError: each unknown argument, each value that is not possible.
    """
    try:
        return View.model_validate(dict(given))
    except ValidationError as error:
        raise ConfigError([
            Problem(f'view: {".".join(map(str, detail["loc"]))}: {detail["msg"]}',
                    allowed=', '.join(View.model_fields))
            for detail in error.errors(include_url=False)
        ]) from None


class Renderer:
    """
    Draws an ``MjModel`` and its ``MjData``; a change of the model makes it begin anew.

    :param view: size and camera.
    :param cameras: cameras of the model to draw instead.
    """

    def __init__(self, view: View, cameras: tuple[str, ...] = ()) -> None:
        self._view, self._cameras = view, cameras
        self._model: Any = None
        self._renderer: Any = None

    def draw(self, model: Any, data: Any) -> NDArray[np.uint8]:
        """
        Return the picture (height, width, 3).

        :raises ResourceError: there is no OpenGL to draw with.
        """
        import mujoco

        self._prepare(model)
        view, camera = self._view, mujoco.MjvCamera()
        camera.lookat[:] = view.lookat
        camera.distance, camera.azimuth = view.distance, view.azimuth
        camera.elevation = view.elevation
        return self._draw(data, camera)

    def draw_all(self, model: Any, data: Any) -> dict[str, NDArray[np.uint8]]:
        """
        Return camera -> its picture (height, width, 3).

        :raises ResourceError: there is no OpenGL to draw with.
        """
        self._prepare(model)
        return {name: self._draw(data, name) for name in self._cameras}

    def _draw(self, data: Any, camera: Any) -> NDArray[np.uint8]:
        self._renderer.update_scene(data, camera)
        picture: NDArray[np.uint8] = self._renderer.render().copy()
        return picture

    def _prepare(self, model: Any) -> None:
        import mujoco

        view = self._view
        if self._model is not model:
            self.close()
            size = model.vis.global_
            size.offwidth = max(size.offwidth, view.width)
            size.offheight = max(size.offheight, view.height)
            try:
                self._renderer = mujoco.Renderer(model, view.height, view.width)
            except Exception as error:
                raise ResourceError(
                    f'pictures need OpenGL without a screen: {error}; install {PACKAGES} (apt) '
                    'and set MUJOCO_GL=egl, or osmesa, before Python starts') from error
            self._model = model

    def close(self) -> None:
        """Give back what the graphics library holds."""
        if self._renderer is not None:
            self._renderer.close()
        self._model = self._renderer = None
