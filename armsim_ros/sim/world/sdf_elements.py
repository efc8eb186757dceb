# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Values of SDF elements, with what is allowed in the message where one is wrong.

All functions raise ResourceFaultError for a value that is wrong or missing, with its line.
"""

from __future__ import annotations

import math

import numpy as np

from armsim_ros.arrays import Matrix
from armsim_ros.model.description.xml_tree import XmlElement
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.sim.world.loaded_world import Fault, ResourceFaultError

Triple = tuple[float, float, float]
#: Words for a truth value, in any case, as sdformat's Param.cc reads them.
_FLAGS = {'true': True, '1': True, 'false': False, '0': False}


def pose_of(element: XmlElement) -> Matrix:
    """Return the pose (4, 4) that a ``<pose>`` holds."""
    if not element.content:
        return np.eye(4)
    if element.get('rotation_format') == 'quat_xyzw':
        raise refused(element, "rotation_format='quat_xyzw' is not read; give euler_rpy")
    values = floats_of(element, 6)
    turn = values[3:]
    if _is_true(element, element.get('degrees', 'false')):
        turn = [math.radians(value) for value in turn]
    return pose_matrix(values[:3], turn)


def color_of(visual: XmlElement) -> tuple[float, float, float, float] | None:
    """Return the diffuse colour of a visual, red, green, blue and opacity 0 to 1, if any."""
    material = visual.first('material')
    given = material.first('diffuse') if material is not None else None
    if given is None:
        return None
    r, g, b, *rest = (min(max(value, 0.0), 1.0) for value in floats_of(given, 3, 4))
    return r, g, b, rest[0] if rest else 1.0


def text_of(element: XmlElement, tag: str, default: str | None = None) -> str:
    """Return the text of a child; without a default there must be one."""
    child = element.first(tag)
    if child is None or not child.content:
        if default is None:
            raise refused(element, f'<{element.tag}> has no <{tag}>')
        return default
    return child.content


def flag_of(element: XmlElement, tag: str, default: bool = False) -> bool:
    """Return the truth value of a child."""
    return _is_true(element, text_of(element, tag, str(default)))


def auto_of(inertial: XmlElement) -> bool:
    """Return whether mass and inertia of an ``<inertial>`` follow from the collisions."""
    return _is_true(inertial, inertial.get('auto', 'false'))


def _is_true(element: XmlElement, word: str) -> bool:
    if word.lower() not in _FLAGS:
        raise refused(element, f"'{word[:60]}' is not a truth value; allowed: {', '.join(_FLAGS)}")
    return _FLAGS[word.lower()]


def numbers_of(element: XmlElement, tag: str, count: int, default: tuple[float, ...] = ()
               ) -> list[float]:
    """Return the numbers of a child; without a default there must be one."""
    child = element.first(tag)
    if child is None:
        if not default:
            raise refused(element, f'<{element.tag}> has no <{tag}>')
        return list(default)
    return floats_of(child, count)


def floats_of(element: XmlElement, *counts: int) -> list[float]:
    """Return the numbers of an element, whose count is one of some."""
    try:
        values = [float(word) for word in element.content.split()]
    except ValueError:
        values = []
    if len(values) not in counts or not all(map(math.isfinite, values)):
        raise refused(element, f"<{element.tag}> is '{element.content[:60]}'; allowed: "
                      f"{' or '.join(map(str, counts))} finite numbers")
    return values


def triple(values: list[float]) -> Triple:
    """Return three numbers as a tuple."""
    x, y, z = values
    return x, y, z


def positive(element: XmlElement, value: float) -> float:
    """Return a measure that has to be above 0."""
    if not value > 0.0:
        raise refused(element, f'<{element.tag}> has the measure {value:g}; allowed: above 0')
    return value


def named(element: XmlElement) -> str:
    """Return tag and name of an element for a message."""
    name = element.get('name')
    return f"<{element.tag} name='{name}'>" if name else f'<{element.tag}>'


def refused(element: XmlElement, text: str) -> ResourceFaultError:
    """Return the error of an element."""
    return ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, f'{element.where}: {text}')
