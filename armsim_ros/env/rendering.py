# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of an environment, drawn without a screen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import Triple
from armsim_ros.errors import ResourceError

PACKAGES = 'libegl1 libegl-mesa0 libgl1-mesa-dri'


class View(Settings):
    """From where a picture is taken, and how large it is."""

    width: int = parameter(640, '[pixels]', ge=1, le=4096)
    height: int = parameter(480, '[pixels]', ge=1, le=4096)
    lookat: Triple = parameter((0.0, 0.1, 1.2), 'the point in the middle, in the world [m]')
    distance: float = parameter(1.8, 'from that point [m]', gt=0.0)
    azimuth: float = parameter(120.0, 'about z [degrees]')
    elevation: float = parameter(-25.0, 'above the horizon is negative [degrees]')


class Renderer:
    """
    Draws an ``MjModel`` and its ``MjData``; a change of the model makes it begin anew.

    :param view: size and camera.
    """

    def __init__(self, view: View) -> None:
        self._view = view
        self._model: Any = None
        self._renderer: Any = None

    def draw(self, model: Any, data: Any) -> NDArray[np.uint8]:
        """
        Return the picture (height, width, 3).

        :raises ResourceError: there is no OpenGL to draw with.
        """
        import mujoco

        view = self._view
        if self._model is not model:
            self.close()
            model.vis.global_.offwidth, model.vis.global_.offheight = view.width, view.height
            try:
                self._renderer = mujoco.Renderer(model, view.height, view.width)
            except Exception as error:
                raise ResourceError(
                    f'pictures need OpenGL without a screen: {error}; install {PACKAGES} (apt) '
                    'and set MUJOCO_GL=egl, or osmesa, before Python starts') from error
            self._model = model
        camera = mujoco.MjvCamera()
        camera.lookat[:] = view.lookat
        camera.distance, camera.azimuth = view.distance, view.azimuth
        camera.elevation = view.elevation
        self._renderer.update_scene(data, camera)
        picture: NDArray[np.uint8] = self._renderer.render().copy()
        return picture

    def close(self) -> None:
        """Give back what the graphics library holds."""
        if self._renderer is not None:
            self._renderer.close()
        self._model = self._renderer = None
