# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Compiles a specification without holding up the threads that run Python."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import mujoco

from armsim_ros.errors import SimulationError

_NAME = 'world.mjb'


def compile_model(spec: Any) -> Any:
    """
    Return the ``MjModel`` of a specification; it must not be edited meanwhile.

    MuJoCo's Python call keeps the interpreter to itself for all of the compilation. This call
    calls the same function of the C library by ctypes, which lets the others run, and takes the
    finished model over as bytes. It costs a fraction of a millisecond in which they wait.

    :param spec: the ``MjSpec``.
    :raises SimulationError: MuJoCo refuses it; its words are the text.
    """
    library = _library()
    compiled = library.mj_compile(spec._address, None)
    if not compiled:
        raise SimulationError(library.mjs_getError(spec._address).decode(errors='replace').strip())
    try:
        content = _content(compiled)
    finally:
        library.mj_deleteModel(compiled)
    return model_from_bytes(content)


def model_to_bytes(model: Any) -> bytes:
    """Return an ``MjModel`` as bytes, while other threads run."""
    return _content(model._address)


def model_from_bytes(content: bytes) -> Any:
    """Return the ``MjModel`` of ``model_to_bytes``, of the same version of MuJoCo."""
    return mujoco.MjModel.from_binary_path(_NAME, {_NAME: content})


def _content(address: int) -> bytes:
    library = _library()
    # Some versions return 32 bits here, and leave the upper half of the register as it was.
    size = library.mj_sizeModel(address) & 0x7FFFFFFF
    buffer = ctypes.create_string_buffer(size)
    library.mj_saveModel(address, None, buffer, size)
    return buffer.raw


@cache
def _library() -> Any:
    """Return the C library that MuJoCo's Python package has loaded."""
    folder = Path(mujoco.__file__).parent
    files = [*folder.glob('libmujoco*.so*'), *folder.glob('libmujoco*.dylib')]
    if not files:
        raise SimulationError(f"no MuJoCo library lies in '{folder}'; install mujoco anew")
    library: Any = ctypes.CDLL(str(files[0]))
    pointer, text = ctypes.c_void_p, ctypes.c_char_p
    for name, result, arguments in (
        ('mj_compile', pointer, [pointer, pointer]),
        ('mj_sizeModel', ctypes.c_int64, [pointer]),
        ('mj_saveModel', None, [pointer, text, pointer, ctypes.c_int64]),
        ('mj_deleteModel', None, [pointer]),
        ('mjs_getError', text, [pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
