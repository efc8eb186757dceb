# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The defaults and the ranges of all numbers that users may set."""

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import annotated_types as limits
import yaml

from armsim_ros import config
from armsim_ros.config.base import Settings

RANGES = Path(__file__).with_name('ranges.yaml')
#: Limit of pydantic -> how it is written in the file, and its attribute.
WORDS = {limits.Ge: ('>=', 'ge'), limits.Gt: ('>', 'gt'), limits.Le: ('<=', 'le'),
         limits.Lt: ('<', 'lt'), limits.MinLen: ('length >=', 'min_length'),
         limits.MaxLen: ('length <=', 'max_length')}


def kinds(base: type[Settings]) -> Iterator[type[Settings]]:
    """Yield all kinds of settings of the configuration."""
    for kind in base.__subclasses__():
        if kind.__module__.startswith(f'{config.__name__}.'):
            yield kind
            yield from kinds(kind)


def ranges() -> dict[str, str]:
    """Return ``module.Kind.name`` -> default and limits, of numbers and of what has limits."""
    found = {}
    for module in walk_packages(config.__path__, f'{config.__name__}.'):
        import_module(module.name)
    for kind in kinds(Settings):
        for name in set(kind.__annotations__) & set(kind.model_fields):
            field = kind.model_fields[name]
            words = [f'{word[0]} {getattr(limit, word[1]):g}' for limit in field.metadata
                     if (word := WORDS.get(type(limit)))]
            if isinstance(field.default, (int, float)) or words:
                place = f'{kind.__module__.removeprefix("armsim_ros.config.")}.{kind.__name__}'
                words.insert(0, 'needed' if field.is_required() else repr(field.default))
                found[f'{place}.{name}'] = ', '.join(words)
    return dict(sorted(found.items()))


def test_defaults_and_ranges_are_as_listed() -> None:
    """A changed default or range changes the robots of users; ``ranges.yaml`` has all of them."""
    assert ranges() == yaml.safe_load(RANGES.read_text())
