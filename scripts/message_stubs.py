# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Plugin of mypy that writes stubs of the installed interface packages that bring none.

mypy loads it before it resolves imports, so that ``mypy`` alone suffices, also in an editor. The
stubs are in build/stubs and are written again when a definition file or their generator changes.
"""

from __future__ import annotations

from collections.abc import Iterator
import hashlib
from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import sys

from mypy.plugin import Plugin

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / 'build' / 'stubs'
GENERATOR = ROOT / 'interfaces' / 'build_support' / 'stubs.py'


def plugin(version: str) -> type[Plugin]:
    """Return a plugin without hooks, with the stubs in place."""
    packages = dict(untyped_packages())
    identity = hashlib.sha256(GENERATOR.read_bytes())
    for folder in packages.values():
        for file in sorted(folder.glob('*/*')):
            if file.suffix in {'.msg', '.srv', '.action'}:
                status = file.stat()
                identity.update(f'{file}\0{status.st_size}\0{status.st_mtime_ns}\0'.encode())
    stamp = TARGET / 'identity'
    if not stamp.is_file() or stamp.read_text('utf-8') != identity.hexdigest():
        sys.path.insert(0, str(GENERATOR.parent.parent))
        from build_support.stubs import write_stubs
        shutil.rmtree(TARGET, ignore_errors=True)
        for name, folder in packages.items():
            write_stubs(name, folder, TARGET / name)
        stamp.write_text(identity.hexdigest(), 'utf-8')
    return Plugin


def untyped_packages() -> Iterator[tuple[str, Path]]:
    """Yield name and share folder of each interface package without ``py.typed``."""
    prefixes = [*os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep), sys.prefix]
    for prefix in reversed([Path(prefix) for prefix in prefixes if prefix]):
        index = prefix / 'share/ament_index/resource_index/rosidl_interfaces'
        for marker in index.iterdir() if index.is_dir() else ():
            module = find_spec(marker.name)
            if module is not None and module.origin is not None \
                    and not Path(module.origin).with_name('py.typed').is_file():
                yield marker.name, prefix / 'share' / marker.name
