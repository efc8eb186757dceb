# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Run the rosidl generators for one interface package.

Runs as a program of its own, one process a package: ``generate.py ARGUMENTS.json``. The argument
file names the package, its folder and definition files, the folder to write to and the folders
that hold the type descriptions of the packages it depends on.
"""

from __future__ import annotations

from collections.abc import Callable
import json
from pathlib import Path
import sys
from typing import Any

import em
import rosidl_adapter
import rosidl_generator_c
import rosidl_generator_py.generate_py_impl
import rosidl_generator_type_description
import rosidl_parser.parser
import rosidl_pycommon
import rosidl_typesupport_c
import rosidl_typesupport_fastrtps_c
import rosidl_typesupport_introspection_c

# .../lib/pythonX.Y/site-packages/rosidl_generator_c/__init__.py
PREFIX = Path(rosidl_generator_c.__file__).resolve().parents[4]

TYPE_SUPPORTS = ('rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c')


def parse_each_file_once() -> None:
    """
    Let all generators of this process share one parse of each .idl file.

    Each of them would parse every file again, which takes longer than what it generates.
    """
    parse = rosidl_parser.parser.parse_idl_file
    parsed: dict[str, Any] = {}

    def parse_once(locator: Any, png_file: str | None = None) -> Any:
        key = str(locator.get_absolute_path())
        if key not in parsed:
            parsed[key] = parse(locator, png_file)
        return parsed[key]

    for module in (
            rosidl_pycommon, rosidl_generator_py.generate_py_impl,
            rosidl_generator_type_description):
        module.parse_idl_file = parse_once


def scan_each_template_once() -> None:
    """
    Let empy remember where the expressions of a template end.

    It searches for the end character by character, again for every file made from a template;
    the answer depends on the text alone.
    """
    def remember(search: Callable[..., int]) -> Callable[..., int]:
        ends: dict[tuple[Any, ...], int | str] = {}

        def search_once(scanner: Any, *arguments: Any) -> int:
            key = (scanner.buffer, scanner.pointer, arguments)
            if key not in ends:
                try:
                    ends[key] = search(scanner, *arguments)
                except em.ParseError as error:
                    if isinstance(error, em.TransientParseError):
                        raise
                    ends[key] = str(error)
            end = ends[key]
            if isinstance(end, str):
                raise em.ParseError(end)
            return end

        return search_once

    for name in ('complex', 'next'):
        setattr(em.Scanner, name, remember(getattr(em.Scanner, name)))


def generate(
    package: str, folder: Path, definitions: list[str], output: Path,
    descriptions: dict[str, str],
) -> None:
    """
    Write everything that one package needs.

    Below the output folder: ``share/<package>`` (.idl and .json), ``include/<package>`` (C code),
    ``introspection/<package>``, ``typesupport/<package>`` and ``python/<package>``.

    :param package: the package's name.
    :param folder: the package's folder.
    :param definitions: definition files, relative to the folder.
    :param output: the folder to write to.
    :param descriptions: for each package it depends on, the folder of its .json descriptions.
    """
    share = output / 'share' / package
    include = output / 'include' / package
    interfaces = [Path(definition) for definition in definitions]
    for interface in interfaces:
        rosidl_adapter.convert_to_idl(folder, package, interface, share)
    idls = [interface.with_suffix('.idl').as_posix() for interface in interfaces]
    common = {
        'package_name': package,
        'idl_tuples': [f'{share}:{idl}' for idl in idls],
        'ros_interface_dependencies': [],
        'target_dependencies': [],
    }

    def run(generator: str, call: Callable[[str], Any], output_dir: Path, **more: Any) -> None:
        output_dir.mkdir(parents=True, exist_ok=True)
        arguments = {
            **common, 'output_dir': str(output_dir),
            'template_dir': str(PREFIX / 'share' / generator / 'resource'), **more}
        path = output / f'{package}__{generator}.json'
        path.write_text(json.dumps(arguments), encoding='utf-8')
        call(str(path))

    run('rosidl_generator_type_description', rosidl_generator_type_description.generate_type_hash,
        share, include_paths=[f'{name}:{path}' for name, path in descriptions.items()])
    hashed = {
        'type_description_tuples': [
            f'{idl}:{share / Path(idl).with_suffix(".json")}' for idl in idls],
        'ros_interface_files': [str(folder / interface) for interface in interfaces],
    }
    run('rosidl_generator_c', rosidl_generator_c.generate_c, include, **hashed)
    run('rosidl_typesupport_fastrtps_c',
        rosidl_typesupport_fastrtps_c.generate_typesupport_fastrtps_c, include, **hashed)
    run('rosidl_typesupport_introspection_c', rosidl_typesupport_introspection_c.generate_c,
        output / 'introspection' / package, **hashed)
    run('rosidl_typesupport_c',
        lambda path: rosidl_typesupport_c.generate_c(path, list(TYPE_SUPPORTS)),
        output / 'typesupport' / package, **hashed)
    run('rosidl_generator_py',
        lambda path: rosidl_generator_py.generate_py_impl.generate_py(
            path, ['rosidl_typesupport_c']),
        output / 'python' / package, **hashed)
    (output / 'python' / package / '__init__.py').touch()
    write_visibility_headers(package, output)


def write_visibility_headers(package: str, output: Path) -> None:
    """Fill in the export macros' headers, which upstream's CMake files do."""
    for generator, folder in (
            ('rosidl_generator_c', 'include'),
            ('rosidl_typesupport_fastrtps_c', 'include'),
            ('rosidl_typesupport_introspection_c', 'introspection')):
        header = f'{generator}__visibility_control.h'
        template = PREFIX / 'share' / generator / 'resource' / f'{header}.in'
        text = template.read_text('utf-8').replace('@PROJECT_NAME_UPPER@', package.upper())
        target = output / folder / package / 'msg' / header
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text.replace('@PROJECT_NAME@', package), encoding='utf-8')


if __name__ == '__main__':
    task = json.loads(Path(sys.argv[1]).read_text(encoding='utf-8'))
    parse_each_file_once()
    scan_each_template_once()
    generate(task['package'], Path(task['folder']), task['definitions'], Path(task['output']),
             task['descriptions'])
