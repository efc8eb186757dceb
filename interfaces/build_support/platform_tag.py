# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The platform tag of a wheel, from the symbol versions that its libraries need."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
import re

from elftools.elf.elffile import ELFFile
from elftools.elf.gnuversions import GNUVerNeedSection, GNUVerSymSection
from elftools.elf.sections import SymbolTableSection

#: The tag of the rclpy wheels, without the machine.
MANYLINUX = 'manylinux_2_28'
#: The newest symbol versions of AlmaLinux 8, whose libraries define that tag; gcc 8.5.
NEWEST = {
    'GLIBC': (2, 28), 'GLIBCXX': (3, 4, 25), 'CXXABI': (1, 3, 11), 'GCC': (8, 0, 0),
}
MACHINES = {'x86_64', 'aarch64'}


def newer_symbols(library: Path) -> list[str]:
    """
    Return the symbols of a library that a machine with the oldest supported glibc lacks.

    :param library: an ELF file.
    :returns: ``symbol@VERSION``, sorted.
    """
    with open(library, 'rb') as stream:
        needed = list(_needed_versions(ELFFile(stream)))
    return sorted(f'{symbol}@{version}' for symbol, version in needed if not _is_old(version))


def platform_tag(libraries: Iterable[Path], machine: str) -> str:
    """
    Return the platform tag of a wheel.

    :param libraries: the shared libraries in the wheel.
    :param machine: the processor, as ``platform.machine()`` names it.
    :returns: the tag of the rclpy wheels, or ``linux_MACHINE`` where a symbol is newer.
    """
    portable = machine in MACHINES and not any(newer_symbols(path) for path in libraries)
    return f'{MANYLINUX if portable else "linux"}_{machine}'


def _needed_versions(elf: ELFFile) -> Iterator[tuple[str, str]]:
    """Yield the name and the version of each symbol that other libraries have to define."""
    sections = list(elf.iter_sections())
    needed = {auxiliary['vna_other']: auxiliary.name
              for section in sections if isinstance(section, GNUVerNeedSection)
              for _, auxiliaries in section.iter_versions() for auxiliary in auxiliaries}
    versions = next((s for s in sections if isinstance(s, GNUVerSymSection)), None)
    symbols = next((s for s in sections if isinstance(s, SymbolTableSection)
                    and s.name == '.dynsym'), None)
    if versions is None or symbols is None:
        return
    for version, symbol in zip(versions.iter_symbols(), symbols.iter_symbols(), strict=True):
        index = version['ndx']
        if index in needed:
            yield symbol.name, needed[index]


def _is_old(version: str) -> bool:
    name, _, number = version.partition('_')
    if name not in NEWEST or not re.fullmatch(r'\d+(\.\d+)*', number):
        return name not in NEWEST  # GLIBC_PRIVATE and the like are in no other glibc
    return tuple(int(part) for part in number.split('.')) <= NEWEST[name]
