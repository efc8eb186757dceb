# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What touches what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco

#: Overlap at the start that is worth a word [m].
START_OVERLAP = 1e-3


@dataclass(frozen=True, slots=True)
class BodyContact:
    """
    Two bodies that touch.

    :param bodies: ``robot/link``, ``object/name`` or ``world``.
    :param depth: how far they overlap [m]; negative where there is still a gap.
    """

    bodies: tuple[str, str]
    depth: float


def contacts(model: Any, data: Any) -> tuple[BodyContact, ...]:
    """Return the contacts of the last step, the deepest first."""
    found = []
    for contact in data.contact[: data.ncon]:
        owners = (int(model.geom_bodyid[geom]) for geom in contact.geom)
        first, second = (model.body(owner).name for owner in owners)
        found.append(BodyContact((first, second), -float(contact.dist)))
    return tuple(sorted(found, key=lambda contact: -contact.depth))


def start_overlaps(model: Any, data: Any, robot: str) -> list[str]:
    """
    Return a line for each pair that overlaps at the start and has a link of the robot in it.

    :param model: the ``MjModel``.
    :param data: its ``MjData`` at the start.
    :param robot: the robot's name.
    """
    mujoco.mj_forward(model, data)
    lines: dict[tuple[str, str], str] = {}
    for contact in contacts(model, data):
        mine = [name for name in contact.bodies if name.startswith(f'{robot}/')]
        if mine and contact.depth > START_OVERLAP:
            first, second = contact.bodies
            lines.setdefault(
                contact.bodies,
                f"'{first}' and '{second}' overlap by {contact.depth * 1e3:.1f} mm at the start; "
                'move the robot or the object, or disable the pair in the SRDF',
            )
    return list(lines.values())
