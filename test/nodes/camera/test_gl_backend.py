# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How it is found out what can draw."""

import os
import subprocess
import sys

import pytest
from rendering import rendering_backend

from armsim_ros.nodes.camera.program import choose_backend, NoRenderingError


def test_what_cannot_draw_is_said_with_the_packages_that_can():
    """A user's own value counts, and the message says how to get rid of it."""
    with pytest.raises(NoRenderingError) as refused:
        choose_backend({**os.environ, 'MUJOCO_GL': 'nothing'})
    text = str(refused.value)
    assert "MUJOCO_GL is 'nothing'" in text
    assert 'libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6' in text


def test_a_machine_without_libraries_is_told_what_to_install():
    """Either one of the libraries draws, or the message names all packages."""
    if rendering_backend() is not None:
        assert rendering_backend() in ('egl', 'osmesa')
        return
    with pytest.raises(NoRenderingError, match=r'neither EGL nor OSMesa .*libosmesa6'):
        choose_backend(os.environ)


def test_a_signal_ends_the_trials():
    """Nobody waits for them then."""
    assert choose_backend(os.environ, lambda: True) == ''


def test_the_program_chooses_before_it_imports_mujoco():
    """MuJoCo reads MUJOCO_GL when it is imported: without a screen, its default draws nothing."""
    subprocess.run(
        [sys.executable, '-c', 'import armsim_ros.nodes.camera.program, sys\n'
         'assert "mujoco" not in sys.modules'], check=True)
