# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Objects that need no file: ``armsim://box?size=0.1,0.1,0.1&mass=0.3&color=1,0,0``."""

from __future__ import annotations

from collections.abc import Mapping
import math
from urllib.parse import parse_qsl

from pydantic import ValidationError

from armsim_ros.config.world import WorldObjectSettings
from armsim_ros.errors import nearest
from armsim_ros.model.world_objects import object_from_settings
from armsim_ros.sim.world_files.loaded import Fault, LoadedObject, ResourceFaultError

#: Shape -> its measures, with the count of numbers and what they are where not given.
MEASURES: Mapping[str, Mapping[str, tuple[int, str]]] = {
    'box': {'size': (3, '0.1,0.1,0.1')},
    'sphere': {'radius': (1, '0.05')},
    'cylinder': {'radius': (1, '0.05'), 'length': (1, '0.1')},
    'capsule': {'radius': (1, '0.05'), 'length': (1, '0.1')},
    'cone': {'radius': (1, '0.05'), 'length': (1, '0.1')},
}
#: What every shape may have; without a mass it never moves.
_COMMON = {'mass': 1, 'friction': 1, 'color': 0}


def shape_object(shape: str, query: str) -> LoadedObject:
    """
    Return the object that an address describes; it has no name.

    :param shape: such as ``box``.
    :param query: what follows the question mark.
    :raises ResourceFaultError: names the word that is wrong and what is allowed.
    """
    measures = MEASURES[shape]
    known = (*measures, *_COMMON)
    words = dict(parse_qsl(query, keep_blank_values=True))
    for word in words:
        if word not in known:
            hint = nearest(word, known) or f'allowed: {", ".join(known)}'
            raise _refused(f"'{word}' is not a word of armsim://{shape}; {hint}")
    content: dict[str, object] = {'type': shape}
    for word, (count, default) in measures.items():
        numbers = _numbers(word, words.get(word, default), count)
        content[word] = numbers if count > 1 else numbers[0]
    settings: dict[str, object] = {'parts': [{'shape': content}]}
    for word in ('mass', 'friction'):
        if word in words:
            settings[word] = _numbers(word, words[word], 1)[0]
    if 'color' in words:
        color = _numbers('color', words['color'], 0)
        settings['color'] = [*color, 1.0] if len(color) == 3 else color
    try:
        checked = WorldObjectSettings.model_validate(settings)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = '.'.join(str(key) for key in first['loc'])
        raise _refused(f"armsim://{shape}: {place}: {first['msg']}") from None
    return LoadedObject(object_from_settings('', checked))


def _numbers(word: str, text: str, count: int) -> list[float]:
    try:
        values = [float(part) for part in text.split(',')]
    except ValueError:
        values = []
    if not values or not all(map(math.isfinite, values)) or (count and len(values) != count):
        requested = f'{count} finite numbers' if count > 1 else 'a finite number'
        raise _refused(f'{word}={text[:60]} is wrong; allowed: {requested}, parted by commas')
    return values


def _refused(text: str) -> ResourceFaultError:
    return ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, text)
