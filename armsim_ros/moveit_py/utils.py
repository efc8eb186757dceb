# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``moveit.utils``: parameter files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
