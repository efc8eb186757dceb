# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What differs from episode to episode: ranges, and what is drawn from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from pydantic import field_validator, ValidationError

from armsim_ros.config.base import parameter, Settings
from armsim_ros.config.simulation import Triple
from armsim_ros.config.world import WorldObjectSettings, WorldSettings
from armsim_ros.errors import ConfigError, nearest, Problem
from armsim_ros.model.robot_model import RobotModel

AnySettings = TypeVar('AnySettings', bound=Settings)
Span = tuple[float, float]
Spans = tuple[Triple, Triple]


def _both_ends(value: Any, width: int) -> Any:
    """Return (low, high) of a value that is meant as it is; ranges stay."""
    depth = np.ndim(value)
    if depth == (1 if width > 1 else 0):
        return value, value
    return value


class ObjectRanges(Settings):
    """What may differ of an object; each is (low, high), or a fixed value."""

    xyz: Spans | None = parameter(None, 'position in the world [m]')
    rpy: Spans | None = parameter(None, 'roll, pitch, yaw in the world [rad]')
    mass: Span | None = parameter(None, '[kg]')
    friction: Span | None = parameter(None, 'coefficient of sliding friction')
    color: Spans | None = parameter(None, 'r, g, b in 0..1')

    @field_validator('xyz', 'rpy', 'color', mode='before')
    @classmethod
    def _triples(cls, value: Any) -> Any:
        return _both_ends(value, 3)

    @field_validator('mass', 'friction', mode='before')
    @classmethod
    def _numbers(cls, value: Any) -> Any:
        return None if value is None else _both_ends(value, 1)

    @field_validator('xyz', 'rpy', 'mass', 'friction', 'color')
    @classmethod
    def _in_order(cls, value: Any) -> Any:
        if value is not None and not np.all(np.less_equal(*value)):
            raise ValueError('a range is (low, high), finite, with low not above high')
        return value


class Ranges(Settings):
    """What differs from episode to episode."""

    objects: dict[str, ObjectRanges] = parameter({}, 'object -> its ranges')
    joints: dict[str, Span] = parameter({}, 'joint -> where it starts [rad or m]')

    @field_validator('joints', mode='before')
    @classmethod
    def _positions(cls, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {name: _both_ends(span, 1) for name, span in value.items()}


@dataclass(frozen=True)
class Episode:
    """
    What was drawn for an episode.

    :param world: with the objects as they are in it.
    :param joints: joint -> where it starts [rad or m]; those that are not there start as usual.
    :param seed: of the planner's random numbers.
    """

    world: WorldSettings
    joints: Mapping[str, float]
    seed: int


def checked(kind: type[AnySettings], given: Mapping[str, Any], title: str) -> AnySettings:
    """
    Return settings that a program has given as words.

    :param title: what they are, for messages.
    :raises ConfigError: each word that there is not, each value that cannot be.
    """
    try:
        return kind.model_validate(dict(given))
    except ValidationError as error:
        raise ConfigError([
            Problem(f'{title}: {".".join(map(str, detail["loc"]))}: {detail["msg"]}',
                    allowed=', '.join(kind.model_fields))
            for detail in error.errors(include_url=False)
        ]) from None


def ranges_from(given: Mapping[str, Any], world: WorldSettings, model: RobotModel) -> Ranges:
    """
    Return checked ranges.

    :param given: ``objects`` and ``joints``, as in ``Ranges``.
    :raises ConfigError: a word, object or joint that there is not, or a value that cannot be.
    """
    ranges = checked(Ranges, given, 'ranges')
    for kind, names, known in (('object', ranges.objects, tuple(world.objects)),
                               ('joint', ranges.joints, model.active_joints)):
        for name in names:
            if name not in known:
                raise ConfigError(Problem(
                    f"there is no {kind} '{name}' to vary", allowed=', '.join(known) or 'none',
                    remedy=nearest(name, known)))
    for name, object_ranges in ranges.objects.items():
        if object_ranges.mass is not None and world.objects[name].mass is None:
            raise ConfigError(Problem(
                f"object '{name}' never moves, so its mass cannot vary",
                remedy='give it a mass in the world file'))
    return ranges


def merged(ranges: Ranges, over: Ranges) -> Ranges:
    """Return ranges with others over them, word by word."""
    objects = dict(ranges.objects)
    for name, object_ranges in over.objects.items():
        words = {word: value for word in ObjectRanges.model_fields
                 if (value := getattr(object_ranges, word)) is not None}
        objects[name] = objects.get(name, ObjectRanges()).model_copy(update=words)
    return Ranges(objects=objects, joints={**ranges.joints, **over.joints})


def drawn(ranges: Ranges, world: WorldSettings, random: np.random.Generator) -> Episode:
    """
    Return an episode; equal ranges and random numbers give equal ones.

    :raises ConfigError: a value that an object cannot have.
    """
    objects = dict(world.objects)
    for name, object_ranges in sorted(ranges.objects.items()):
        objects[name] = _drawn_object(name, object_ranges, objects[name], random)
    joints = {name: float(random.uniform(*span)) for name, span in sorted(ranges.joints.items())}
    seed = int(random.integers(2**31))
    return Episode(world.model_copy(update={'objects': objects}), joints, seed)


def _drawn_object(
    name: str, ranges: ObjectRanges, item: WorldObjectSettings, random: np.random.Generator
) -> WorldObjectSettings:
    values: dict[str, Any] = {}
    for word in ObjectRanges.model_fields:
        span = getattr(ranges, word)
        if span is not None:
            chosen = random.uniform(*span)
            values[word] = tuple(chosen.tolist()) if np.ndim(chosen) else float(chosen)
    if 'color' in values:
        values['color'] = (*values['color'], item.color[3])
    return checked(WorldObjectSettings, {**dict(item), **values}, f"object '{name}'")
