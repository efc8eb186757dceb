# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Compiles a specification without blocking Python, and carries the state over by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import SimulationError

_NAME = 'world.mjb'


def compile_model(spec: Any) -> Any:
    """
    Return the ``MjModel`` of a specification; it must not be edited meanwhile.

    MuJoCo's Python call keeps the interpreter to itself for all of the compilation. This call
    calls the same function of the C library by ctypes, which lets the others run, and takes the
    finished model over as bytes. It costs a fraction of a millisecond in which they wait.

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
        raise SimulationError(f"no MuJoCo library lies in '{folder}'; reinstall mujoco")
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


Places = NDArray[np.intp]
Pair = tuple[Places, Places]

#: Entries of a joint in qpos and in qvel.
_QPOS = {int(mujoco.mjtJoint.mjJNT_FREE): 7, int(mujoco.mjtJoint.mjJNT_BALL): 4}
_DOFS = {int(mujoco.mjtJoint.mjJNT_FREE): 6, int(mujoco.mjtJoint.mjJNT_BALL): 3}


class StateTransfer:
    """
    Where the state of what two models have in common lies in each of them.

    To look that up takes time, to copy takes next to none: the one is done beside the loop that
    runs the old model, the other between two of its steps.

    :param old: the ``MjModel`` that runs.
    :param new: the model that takes its place.
    """

    def __init__(self, old: Any, new: Any) -> None:
        self._old, self._new = old, new
        kinds = mujoco.mjtObj
        self._joints = _places(old, new, kinds.mjOBJ_JOINT)
        self._bodies = _places(old, new, kinds.mjOBJ_BODY)
        self._actuators = _places(old, new, kinds.mjOBJ_ACTUATOR)
        self._equalities = _places(old, new, kinds.mjOBJ_EQUALITY)
        self._qpos = self._entries('jnt_qposadr', _QPOS)
        self._dofs = self._entries('jnt_dofadr', _DOFS)

    def copy(self, source: Any, target: Any) -> None:
        """
        Copy the state, and what was set in the old model while it ran.

        :param source: the ``MjData`` of the old model.
        :param target: that of the new model; what is new keeps its start.
        """
        target.time = source.time
        _copy(source.qpos, target.qpos, self._qpos)
        for name in ('qvel', 'qacc', 'qfrc_applied', 'qacc_warmstart'):
            _copy(getattr(source, name), getattr(target, name), self._dofs)
        _copy(source.xfrc_applied, target.xfrc_applied, self._bodies)
        for name in ('ctrl', 'actuator_force'):
            _copy(getattr(source, name), getattr(target, name), self._actuators)
        _copy(self._old.actuator_biasprm, self._new.actuator_biasprm, self._actuators)
        _copy(source.eq_active, target.eq_active, self._equalities)
        _copy(self._old.eq_data, self._new.eq_data, self._equalities)

    def _entries(self, address: str, widths: Mapping[int, int]) -> Pair:
        olds: list[int] = []
        news: list[int] = []
        for old, new in zip(*self._joints, strict=True):
            width = widths.get(int(self._old.jnt_type[old]), 1)
            start, begin = getattr(self._old, address)[old], getattr(self._new, address)[new]
            olds.extend(range(start, start + width))
            news.extend(range(begin, begin + width))
        return _pair(olds, news)


def _places(old: Any, new: Any, kind: Any) -> Pair:
    """Return the numbers of the named elements of a kind that both models have."""
    before, now = _numbers(old, kind), _numbers(new, kind)
    both = [name for name in before if name in now]
    return _pair([before[name] for name in both], [now[name] for name in both])


def _numbers(model: Any, kind: Any) -> dict[str, int]:
    count = {
        mujoco.mjtObj.mjOBJ_JOINT: model.njnt,
        mujoco.mjtObj.mjOBJ_BODY: model.nbody,
        mujoco.mjtObj.mjOBJ_ACTUATOR: model.nu,
        mujoco.mjtObj.mjOBJ_EQUALITY: model.neq,
    }[kind]
    names = {mujoco.mj_id2name(model, kind, number): number for number in range(count)}
    return {name: number for name, number in names.items() if name}


def _pair(old: Iterable[int], new: Iterable[int]) -> Pair:
    return np.array(list(old), dtype=np.intp), np.array(list(new), dtype=np.intp)


def _copy(source: Any, target: Any, places: Pair) -> None:
    target[places[1]] = source[places[0]]
