# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.utils``: parameter files; and the logger of scripts that plan."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
import sys
from tempfile import NamedTemporaryFile
from typing import Any

import yaml


def create_params_file_from_dict(params: Mapping[str, Any], node_name: str) -> str:
    """Write parameters of a node to a temporary file and return its path."""
    with NamedTemporaryFile(
            'w', prefix='launch_params_', suffix='.yaml', delete=False, encoding='utf-8') as file:
        yaml.safe_dump({node_name: {'ros__parameters': dict(params)}}, file)
    return file.name


def get_launch_params_filepaths(cli_args: Sequence[str] | None = None) -> list[str]:
    """
    Return the files after each ``--params-file``.

    :param cli_args: the words; those of this process where None.
    :raises ValueError: the last ``--params-file`` has no file.
    """
    words = list(sys.argv if cli_args is None else cli_args)
    places = [place for place, word in enumerate(words) if word == '--params-file']
    if places and places[-1] + 1 == len(words):
        raise ValueError("'--params-file' is the last word; it needs the path of a file")
    return [words[place + 1] for place in places]


_reported: set[str] = set()


def logger() -> Any:
    """Return the logger."""
    from rclpy.logging import get_logger  # launch files use the rest without ROS

    return get_logger('moveit_py')


def warn_once(text: str) -> None:
    """Log a warning once per process."""
    if text not in _reported:
        _reported.add(text)
        logger().warning(text)


def warn_unused(names: Iterable[str], prefix: str, used: Collection[str]) -> None:
    """Log once which of the parameters below a prefix are not used, and those that are known."""
    below = (name.removeprefix(prefix) for name in names if name.startswith(prefix))
    unused = [name for name in below if name not in used]
    if unused:
        warn_once(f"parameters {prefix}*: {', '.join(unused)} not used; "
                  f"known: {', '.join(used)}")
