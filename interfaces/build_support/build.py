# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Build interface packages: generate, compile, link, and lay out what a wheel installs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import as_completed, Future, ThreadPoolExecutor
import json
import os
from pathlib import Path
import shutil
import sys
import sysconfig

from build_support.compiler import find_toolchain, link_inputs, run, units
from build_support.errors import BuildError
from build_support.packages import InterfacePackage, SELECTION_VARIABLE
from build_support.stubs import write_stubs

INDEX = 'share/ament_index/resource_index'


def build(
    packages: list[InterfacePackage], provided: Mapping[str, Path], work: Path, target: Path,
    report: Callable[[str], None],
) -> None:
    """
    Build packages into ``target/python`` (importable) and ``target/data`` (share/).

    :param packages: what to build, each after those it depends on.
    :param provided: packages left out and the ROS prefix that provides each.
    :param work: a scratch folder.
    :param target: the folder to write to.
    :param report: is called with one line a package.
    :raises BuildError: something is missing, or a tool failed.
    """
    prefix = wheels_prefix()
    toolchain = find_toolchain(prefix, work, provided, os.environ)
    pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
    try:
        generated: dict[str, Future[None]] = {}
        for package in packages:
            earlier = [generated[name] for name in package.dependencies if name in generated]
            generated[package.name] = pool.submit(
                generate, package, packages, prefix, provided, work, earlier)
        wait_for(generated.values())
        compiled = {package.name: units(package, work, work / 'objects') for package in packages}
        wait_for([
            pool.submit(toolchain.compile, unit) for plan in compiled.values() for unit in plan])
    finally:
        pool.shutdown(cancel_futures=True)
    suffix = sysconfig.get_config_var('EXT_SUFFIX')
    built: dict[str, Path] = {}
    for package in packages:
        folder = target / 'python' / package.name
        shutil.copytree(
            work / 'python' / package.name, folder, ignore=shutil.ignore_patterns('*.c'))
        write_stubs(package.name, package.folder, folder)
        library = folder / f'{package.name}_s__rosidl_typesupport_c{suffix}'
        toolchain.link(
            library, [unit.object for unit in compiled[package.name]],
            link_inputs(package, built))
        built[package.name] = library
        write_share(package, work / 'share' / package.name, target / 'data')
        report(f'{package.name}: {len(package.definitions)} types')


def wait_for(futures: Iterable[Future[None]]) -> None:
    """Wait until all are done; the first error is raised at once."""
    for future in as_completed(futures):
        future.result()


def wheels_prefix() -> Path:
    """
    Return the prefix that holds the wheels of the build environment.

    :raises BuildError: the rosidl generators are not installed.
    """
    try:
        import rosidl_generator_c
    except ImportError as error:
        raise BuildError(
            f'the rosidl generators cannot be imported ({error}); build with pip, which installs '
            'what pyproject.toml requires') from None
    return Path(rosidl_generator_c.__file__).resolve().parents[4]


def generate(
    package: InterfacePackage, packages: list[InterfacePackage], prefix: Path,
    provided: Mapping[str, Path], work: Path, earlier: list[Future[None]],
) -> None:
    """Run the generators for one package in a process of its own, after its dependencies."""
    wait_for(earlier)
    here = {other.name for other in packages}
    descriptions = {
        name: str((work if name in here else provided.get(name, prefix)) / 'share' / name)
        for name in package.dependencies}
    missing = [name for name, folder in descriptions.items() if not Path(folder).is_dir()]
    if missing:
        places = ', '.join(
            f'{name} ({package.named[name]})' if name in package.named else name
            for name in missing)
        raise BuildError(
            f'{package.name} needs {places}, neither built here nor part of a sourced ROS; put it '
            f'beside {package.name}, or add it to {SELECTION_VARIABLE} if it is there')
    task = work / f'{package.name}.json'
    task.write_text(json.dumps({
        'package': package.name, 'folder': str(package.folder), 'output': str(work),
        'definitions': [path.as_posix() for path in package.definitions],
        'descriptions': descriptions}), 'utf-8')
    # Generated code lists some things in the order of a set.
    environ = {**os.environ, 'PYTHONHASHSEED': '0', 'PYTHONDONTWRITEBYTECODE': '1'}
    run(f'generating {package.name}',
        [sys.executable, str(Path(__file__).with_name('generate.py')), str(task)], environ)


def write_share(package: InterfacePackage, generated: Path, data: Path) -> None:
    """Lay out share/ as upstream does: definitions, .idl, .json, package.xml, index markers."""
    share = data / 'share' / package.name
    shutil.copytree(generated, share)
    shutil.copy(package.folder / 'package.xml', share)
    listed = []
    for path in package.definitions:
        shutil.copy(package.folder / path, share / path)
        listed += [path.with_suffix('.idl').as_posix(), path.as_posix()]
    for resource, text in (('packages', ''), ('rosidl_interfaces', '\n'.join(listed))):
        marker = data / INDEX / resource / package.name
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.write_text(text, 'utf-8')
