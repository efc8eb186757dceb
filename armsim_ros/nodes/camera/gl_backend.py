# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which library can draw on this machine without a screen."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import subprocess
import sys

from armsim_ros.cli.environment import die_with_parent
from armsim_ros.errors import ArmsimError

VARIABLE = 'MUJOCO_GL'
#: The libraries without a screen -> the packages that they are in.
PACKAGES = {'egl': 'libegl1 libegl-mesa0 libgl1-mesa-dri', 'osmesa': 'libosmesa6'}
#: Draws a picture of nothing, as it is to be done later.
_TRIAL = """
import mujoco
window = mujoco.GLContext(16, 16)
window.make_current()
model = mujoco.MjSpec().compile()
mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50).free()
print('drawn', flush=True)
import os
os._exit(0)
"""
#: Time between checks whether a trial has ended [s].
_LOOK = 0.05
#: A trial on a busy machine takes no longer [s].
_LONGEST_TRIAL = 120.0


class NoRenderingError(ArmsimError):
    """Nothing on this machine can draw; the text names what to install."""


def choose_backend(
    environment: Mapping[str, str], stop_wanted: Callable[[], bool] = lambda: False
) -> str:
    """
    Return the value of MUJOCO_GL that draws here: the user's own, else EGL, else OSMesa.

    Each is tried in a process of its own: what does not work may end that.

    :param environment: of the process; may hold the user's value.
    :param stop_wanted: ends the trials; '' is returned.
    :raises NoRenderingError: none works.
    """
    given = environment.get(VARIABLE, '').lower()
    for backend in (given,) if given else tuple(PACKAGES):
        if _draws(backend, environment, stop_wanted):
            return backend
        if stop_wanted():
            return ''
    if given:
        raise NoRenderingError(
            f"no pictures: {VARIABLE} is '{given}', which cannot draw here; unset it, or set it "
            f"to one of {', '.join(PACKAGES)} and install {_packages()}")
    raise NoRenderingError(
        f'no pictures: neither EGL nor OSMesa can draw here; install {_packages()}')


def _packages() -> str:
    return f"the packages {PACKAGES['egl']}, or {PACKAGES['osmesa']}"


def _draws(backend: str, environment: Mapping[str, str], stop_wanted: Callable[[], bool]) -> bool:
    """Return whether a child could draw."""
    with subprocess.Popen(
        [sys.executable, '-c', _TRIAL], env={**environment, VARIABLE: backend},
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        preexec_fn=die_with_parent(holds_sigint=False),
    ) as child:
        waited = 0.0
        while waited < _LONGEST_TRIAL and not stop_wanted():
            try:
                output, _ = child.communicate(timeout=_LOOK)
            except subprocess.TimeoutExpired:
                waited += _LOOK
                continue
            return b'drawn' in output
        child.kill()
    return False
