# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Finds objects and worlds by address, reads them, and keeps to the folders that are allowed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
import re
import sys
from typing import TypeVar

import numpy as np

from armsim_ros.config.base import read_settings
from armsim_ros.config.world import WorldObjectSettings, WorldSettings
from armsim_ros.config.yaml_source import parse_yaml
from armsim_ros.errors import ConfigError, nearest, Problem, ResourceError, Severity
from armsim_ros.model.description.xml_tree import LARGEST_TEXT
from armsim_ros.model.geometry import Mesh
from armsim_ros.model.meshes import load_mesh
from armsim_ros.model.world_objects import object_from_settings, world_objects, WorldObject
from armsim_ros.packages import Packages, sourced_prefixes
from armsim_ros.resources import check_inside, PACKAGE, resolve_uri, share_folder
from armsim_ros.sim.world.loaded_world import (
    Fault,
    LoadedObject,
    LoadedWorld,
    MEASURES,
    ResourceFaultError,
    shape_object,
    urdf_object,
)
from armsim_ros.sim.world.mjcf import mjcf_object, mjcf_world
from armsim_ros.sim.world.sdf import MeshReader, ModelReader, sdf_object, sdf_world

SCHEME = 'armsim://'
#: What a text may be.
FORMATS = ('sdf', 'urdf', 'mjcf', 'yaml')
#: Endings of files that hold worlds.
WORLD_ENDINGS = ('.yaml', '.yml', '.sdf', '.world', '.xml', '.mjcf')
#: Files of a folder that are searched at most.
MOST_FILES = 1000

_ROOTS = {'sdf': 'sdf', 'model': 'sdf', 'robot': 'urdf', 'mujoco': 'mjcf'}
_ELEMENT, _COMMENT = re.compile(r'<([A-Za-z_][\w.-]*)'), re.compile(r'<!--.*?-->', re.DOTALL)

Triple = tuple[float, float, float]
AnySettings = TypeVar('AnySettings', WorldObjectSettings, WorldSettings)


class WorldResources:
    """
    Objects and worlds by address or content.

    Files are read below the package's own folder, the installed packages, and the folders of the
    user's; nothing else, and nothing from a network.

    :param folders: the user's ``resource_paths``.
    :param packages: where packages are searched.
    """

    def __init__(self, folders: Iterable[Path] = (), packages: Packages | None = None) -> None:
        self._packages = packages or Packages()
        self.folders = tuple(Path(os.path.abspath(folder)) for folder in folders)
        installed = [prefix / 'share' for prefix in (*sourced_prefixes(), Path(sys.prefix))]
        self._allowed = (*self.folders, share_folder(PACKAGE), *installed)

    def object(self, uri: str, text: str, name: str) -> LoadedObject:
        """
        Return the object that an address or a text describes; its pose is not changed.

        Its name is that which the resource gives it, '' where it gives none.

        :param text: used where there is no address.
        :param name: what messages call the text.
        :raises ResourceFaultError: neither is given, or it cannot be used.
        """
        if not uri:
            return self._object(_given(text), name or 'text', None)
        if uri.startswith(SCHEME):
            return self._own(uri)
        file = self._file(uri)
        return self._object(_read(file), file.name, file)

    def world(self, uri: str, text: str, *, ignore_assets: bool = False) -> LoadedWorld:
        """
        Return the world that an address, a name or a text describes.

        :param text: used where there is no address.
        :param ignore_assets: leave out meshes and models that are missing or cannot be read.
        :raises ResourceFaultError: neither is given, or it cannot be used.
        """
        if not uri:
            return self._world(_given(text), 'text', None, ignore_assets)
        name = uri.removeprefix(SCHEME)
        found = self.worlds()
        file = found[name] if name in found else self._file(uri)
        return self._world(_read(file), file.name, file, ignore_assets)

    def worlds(self, more: Iterable[Path] = ()) -> dict[str, Path]:
        """
        Return the worlds that there are: name -> file.

        :param more: further folders to search, which must be allowed.
        :raises ResourceError: a folder of ``more`` is not there or not allowed.
        """
        for folder in more:
            check_inside(folder, self._allowed)
            if not folder.is_dir():
                raise ResourceError(f"folder '{folder}' does not exist")
        places = (share_folder(PACKAGE) / 'worlds', *self.folders, *more)
        files = [file for place in places if place.is_dir()
                 for file in sorted(place.iterdir())[:MOST_FILES]]
        found: dict[str, Path] = {}
        for file in files:
            if file.suffix in WORLD_ENDINGS and file.is_file() and _is_world(file):
                found.setdefault(file.stem, file)
        return found

    def spawnables(self) -> dict[str, LoadedObject]:
        """Return the ``armsim://`` addresses that there are, with what they give."""
        found = {f'{SCHEME}{shape}': shape_object(shape, '') for shape in MEASURES}
        for name in self.worlds():
            try:
                world = self.world(name, '')
            except ResourceFaultError:
                continue  # loading it reports why it cannot be read
            found.update((f'{SCHEME}{name}/{item.name}', LoadedObject(item))
                         for item in world.items)
        return found

    def _own(self, uri: str) -> LoadedObject:
        place, _, query = uri.removeprefix(SCHEME).partition('?')
        if place in MEASURES:
            return shape_object(place, query)
        world, _, name = place.partition('/')
        worlds = self.worlds()
        if world not in worlds or not name:
            allowed = [*MEASURES, *(f'{known}/<object>' for known in worlds)]
            raise ResourceFaultError(
                Fault.MISSING_ASSETS, f"'{uri}' does not name an object; allowed: {SCHEME}"
                + f', {SCHEME}'.join(allowed))
        items = {item.name: item for item in self.world(world, '').items}
        if name not in items:
            hint = nearest(name, tuple(items)) or f'it has: {", ".join(items) or "none"}'
            raise ResourceFaultError(
                Fault.MISSING_ASSETS, f"world '{world}' has no object '{name}'; {hint}")
        return LoadedObject(replace(items[name], pose=np.eye(4)))

    def _file(self, uri: str) -> Path:
        if '://' in uri and not uri.startswith(('file://', 'package://', 'model://')):
            raise ResourceFaultError(
                Fault.UNSUPPORTED_FORMAT, f"'{uri[:200]}' cannot be read; allowed: a path, "
                f'file://, package://, {SCHEME}; there is no download')
        try:
            file = resolve_uri(uri, self._packages, within=self._allowed)
        except ResourceError as error:
            raise ResourceFaultError(Fault.MISSING_ASSETS, str(error)) from None
        if file.is_dir():
            file = file / 'model.sdf'
        if not file.is_file():
            raise ResourceFaultError(Fault.MISSING_ASSETS, f"'{uri}' is not a file")
        return _inside(file, self._allowed)

    def _object(self, text: str, name: str, file: Path | None) -> LoadedObject:
        kind, read_mesh = _kind(text, name), partial(self._mesh, file)
        if kind == 'sdf':
            return sdf_object(text, name, read_mesh, partial(self._model, file))
        if kind == 'urdf':
            return urdf_object(text, name, read_mesh)
        if kind == 'mjcf':
            return mjcf_object(text, name, read_mesh)
        return LoadedObject(replace(
            _yaml_object(text, name), name=file.stem if file is not None else ''))

    def _world(self, text: str, name: str, file: Path | None, ignore_assets: bool) -> LoadedWorld:
        kind, read_mesh = _kind(text, name), partial(self._mesh, file)
        stem = file.stem if file is not None else ''
        if kind == 'sdf':
            world = sdf_world(
                text, name, read_mesh, partial(self._model, file), ignore_assets=ignore_assets)
        elif kind == 'mjcf':
            world = mjcf_world(text, name, read_mesh, ignore_assets=ignore_assets)
        elif kind == 'urdf':
            raise ResourceFaultError(
                Fault.UNSUPPORTED_FORMAT,
                f'{name}: a URDF is not a world; allowed: sdf, mjcf, yaml')
        else:
            world = _yaml_world(text, name)
        return replace(world, name=stem or world.name)

    def _mesh(self, file: Path | None, uri: str, scale: Triple) -> Mesh:
        base = file.parent if file is not None else None
        if base is None and '://' not in uri and not os.path.isabs(uri):
            raise ResourceFaultError(
                Fault.MISSING_ASSETS, f"mesh '{uri}': a text has no folder, so its files need a "
                'package:// or file:// address')
        for folder in self.folders if uri.startswith('model://') else ():
            if (folder / uri[len('model://'):]).is_file():
                uri = str(folder / uri[len('model://'):])
        fault, within = Fault.MISSING_ASSETS, self._within(file)
        try:
            resolve_uri(uri, self._packages, base=base, within=within)
            fault = Fault.UNSUPPORTED_ASSETS
            return load_mesh(uri, scale, packages=self._packages, base=base, within=within)
        except ResourceError as error:
            raise ResourceFaultError(fault, str(error)) from None

    def _model(self, file: Path | None, uri: str) -> tuple[str, MeshReader, ModelReader]:
        """Return the text of an included model, and what reads the files that it names."""
        found = self._included(file, uri)
        return _read(found), partial(self._mesh, found), partial(self._model, found)

    def _included(self, file: Path | None, uri: str) -> Path:
        if '://' in uri and not uri.startswith(('file://', 'package://', 'model://')):
            raise ResourceFaultError(
                Fault.MISSING_ASSETS, f"'{uri[:200]}' is not on this machine; includes are read "
                'from files only')
        name = uri.partition('://')[2] if uri.startswith('model://') else uri
        places = [file.parent, file.parent.parent] if file is not None else []
        for place in (*places, *self.folders):
            found = place / name
            if found.is_dir():
                found = found / 'model.sdf'
            if found.is_file():
                return _inside(found, self._within(file))
        return self._file(uri)

    def _within(self, file: Path | None) -> tuple[Path, ...]:
        return self._allowed if file is None else (file.parent, *self._allowed)


def _given(text: str) -> str:
    if not text:
        raise ResourceFaultError(Fault.NO_RESOURCE, "neither 'uri' nor 'resource_string' is given")
    return text


def _kind(text: str, name: str) -> str:
    """Return the format of a text by its content."""
    if not text.lstrip('\ufeff \t\r\n').startswith('<'):
        return 'yaml'
    root = _ELEMENT.search(_COMMENT.sub('', text))
    if root is not None and root[1] in _ROOTS:
        return _ROOTS[root[1]]
    raise ResourceFaultError(
        Fault.UNSUPPORTED_FORMAT, f'{name}: the text is none of {", ".join(FORMATS)}: its root '
        'element is none of <sdf>, <model>, <robot>, <mujoco>')


def _yaml_object(text: str, name: str) -> WorldObject:
    settings = _checked(WorldObjectSettings, text, name)
    return object_from_settings(Path(name).stem, settings)


def _yaml_world(text: str, name: str) -> LoadedWorld:
    settings = _checked(WorldSettings, text, name)
    return LoadedWorld(Path(name).stem, world_objects(settings), settings.floor_height,
                       gravity=settings.gravity)


def _checked(kind: type[AnySettings], text: str, name: str) -> AnySettings:
    problems: list[Problem] = []
    try:
        node = parse_yaml(text, name)
        settings = read_settings(kind, node, problems, title='world', tolerant=False)
    except ConfigError as error:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, str(error)) from None
    errors = [str(problem) for problem in problems if problem.severity is Severity.ERROR]
    if settings is None or errors:
        raise ResourceFaultError(Fault.RESOURCE_PARSE_ERROR, '; '.join(errors))
    return settings


def _inside(file: Path, folders: Iterable[Path]) -> Path:
    """Return a file that lies in the folders also where links lead."""
    try:
        check_inside(file.resolve(), [folder.resolve() for folder in folders])
    except ResourceError as error:
        raise ResourceFaultError(Fault.MISSING_ASSETS, str(error)) from None
    return file


def _read(file: Path) -> str:
    if file.stat().st_size > LARGEST_TEXT:
        raise ResourceFaultError(
            Fault.UNSUPPORTED_FORMAT, f"'{file.name}' is larger than {LARGEST_TEXT >> 20} MiB")
    try:
        return file.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError):
        raise ResourceFaultError(
            Fault.UNSUPPORTED_FORMAT, f"'{file.name}' is not a text that can be read") from None


def _is_world(file: Path) -> bool:
    """Return whether a file begins as a world does."""
    try:
        head = file.read_bytes()[:4096]
    except OSError:
        return False
    if file.suffix in ('.yaml', '.yml'):
        return any(line.startswith((b'objects:', b'floor:')) for line in head.splitlines())
    return b'<world' in head or b'<mujoco' in head
