# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What touches what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.arrays import Vector

_NOTHING = np.empty((0, 2), dtype=np.int32), np.empty(0)


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


def touching(model: Any, data: Any) -> tuple[NDArray[np.int32], Vector]:
    """Return bodies (n, 2) and overlaps (n,) [m] of the contacts of the last step."""
    if not data.ncon:
        return _NOTHING
    found = data.contact
    return model.geom_bodyid[found.geom[: data.ncon]], -found.dist[: data.ncon]
