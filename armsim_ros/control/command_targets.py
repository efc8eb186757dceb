# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The interfaces that a controller's commands go to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from armsim_ros.arrays import selector, Vector
from armsim_ros.control.hardware_interface import EFFORT, HardwareInterface, POSITION, VELOCITY


class CommandTargets:
    """
    Writes commands as they are: what a joint can do is the hardware's matter.

    :param targets: (owner, interface) of each of the m values of a command; an owner is a joint, a
        sensor or gpio, or a joint of a following controller.
    :param hardware: has them.
    """

    def __init__(self, targets: Sequence[tuple[str, str]], hardware: HardwareInterface) -> None:
        columns: dict[str, list[int]] = {}
        for column, (owner, kind) in enumerate(targets):
            columns.setdefault(kind if owner in hardware.index else '', []).append(column)
        others = ['/'.join(targets[column]) for column in columns.get('', ())]
        self._other_columns = selector(columns.pop('', []))
        self._others = [(hardware.store_of(name), name) for name in others]
        self._joints = [
            (
                kind,
                hardware.command.of(kind),
                selector([hardware.index[targets[column][0]] for column in places]),
                selector(places),
            )
            for kind, places in columns.items()
        ]

    def take_over(self) -> None:
        """Leave the joints to the drives, which hold them until a command comes."""
        for kind, command, places, _ in self._joints:
            if kind != POSITION:
                command[places] = np.nan

    def write(self, values: Vector) -> None:
        """Write a command (m,)."""
        for _, command, places, columns in self._joints:
            command[places] = values[columns]
        for (store, name), value in zip(
            self._others, values[self._other_columns].tolist(), strict=True
        ):
            store[name] = value

    def stop(self, *, effort: float = 0.0) -> None:
        """
        Stop velocities; positions and what is not a joint's stay as they are.

        :param effort: of joints that follow efforts, NaN leaves them to the drives.
        """
        for kind, command, places, _ in self._joints:
            if kind == VELOCITY:
                command[places] = 0.0
            elif kind == EFFORT:
                command[places] = effort
