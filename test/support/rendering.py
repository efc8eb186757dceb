# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Whether this machine can draw without a screen."""

from functools import cache
import os

from armsim_ros.nodes.camera.program import choose_backend, NoRenderingError


@cache
def rendering_backend():
    """Return the value of MUJOCO_GL that draws here; None where nothing does."""
    try:
        return choose_backend(os.environ)
    except NoRenderingError:
        return None
