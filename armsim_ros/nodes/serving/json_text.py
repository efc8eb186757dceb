# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""JSON text that browsers read."""

from __future__ import annotations

import json
import math
from typing import Any


def to_json(value: Any) -> str:
    """Return JSON text without blanks; a number that is not finite becomes null."""
    try:
        return json.dumps(value, allow_nan=False, separators=(',', ':'))
    except ValueError:
        return json.dumps(_finite(value), allow_nan=False, separators=(',', ':'))


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return value
