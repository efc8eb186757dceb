# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What touches what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


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
