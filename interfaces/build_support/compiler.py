# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Compile the generated code of each package into one library, its Python extension module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import shlex
import shutil
import subprocess
import sysconfig

from build_support.errors import BuildError
from build_support.packages import InterfacePackage

# Libraries that the generated code calls, besides those of the packages it depends on.
RUNTIME_LIBRARIES = (
    'rosidl_typesupport_c', 'rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_fastrtps_cpp',
    'rosidl_typesupport_introspection_c', 'rosidl_runtime_c', 'rosidl_dynamic_typesupport',
    'fastcdr', 'rcutils', 'rmw')

# The parts of an interface package that upstream installs as libraries of their own.
PACKAGE_LIBRARIES = (
    'rosidl_generator_c', 'rosidl_typesupport_c', 'rosidl_typesupport_fastrtps_c',
    'rosidl_typesupport_introspection_c', 'rosidl_generator_py')

DISPATCH = (
    '-Drosidl_typesupport_c__get_message_typesupport_handle_function=armsim_message_typesupport',
    '-Drosidl_typesupport_c__get_service_typesupport_handle_function=armsim_service_typesupport')


# Sources in one run of the compiler: few enough to keep a second core busy.
JOINED = 40


@dataclass(frozen=True)
class Unit:
    """One run of the compiler: a source file and the object that it becomes."""

    source: Path
    object: Path
    is_cpp: bool
    flags: tuple[str, ...] = ()


@dataclass(frozen=True)
class Toolchain:
    """Compilers, include folders and library folders."""

    cc: tuple[str, ...]
    cxx: tuple[str, ...]
    includes: tuple[Path, ...]
    libraries: tuple[Path, ...]
    generated: Path

    def compile(self, unit: Unit) -> None:
        """
        Compile one unit.

        :raises BuildError: the compiler reported an error; the text holds its output.
        """
        language = (*self.cxx, '-std=c++17', '-DNDEBUG') if unit.is_cpp else (
            *self.cc, '-std=gnu11')
        run(f'compiling {unit.source.name}',
            [*language, '-O1', '-g0', '-fPIC', '-w', *unit.flags,
             f'-ffile-prefix-map={self.generated}=.',  # assert() names its file
             *(f'-I{folder}' for folder in self.includes),
             '-c', str(unit.source), '-o', str(unit.object)])

    def link(self, target: Path, objects: Sequence[Path], inputs: Sequence[str]) -> None:
        """
        Link objects to a shared library that finds its neighbours by relative paths.

        :param target: the library to write; its folder is the Python package.
        :param objects: object files.
        :param inputs: further libraries, as paths or -l options.
        :raises BuildError: the linker reported an error.
        """
        run(f'linking {target.name}',
            [*self.cxx, '-shared', '-s', '-o', str(target), *map(str, objects),
             *(f'-L{folder}' for folder in self.libraries), '-Wl,--as-needed', *inputs, '-ldl',
             f'-Wl,-soname,{target.name}'])


def find_toolchain(
    prefix: Path, generated: Path, provided: Mapping[str, Path], environ: Mapping[str, str],
) -> Toolchain:
    """
    Find the compilers and headers, before anything slow begins.

    :param prefix: the prefix that holds the wheels of the build environment.
    :param generated: the folder that the generators write to.
    :param provided: for each package of a sourced ROS, its prefix.
    :param environ: the environment; CC and CXX are read.
    :raises BuildError: no compiler, or no Python.h.
    """
    import numpy

    compilers: list[tuple[str, ...]] = []
    for variable, names in (('CC', ('gcc', 'cc', 'clang')), ('CXX', ('g++', 'c++', 'clang++'))):
        given = shlex.split(environ.get(variable, ''))
        candidates = [given] if given else [[name] for name in names]
        command = next((tuple(c) for c in candidates if shutil.which(c[0])), None)
        if command is None:
            tried = ', '.join(c[0] for c in candidates)
            raise BuildError(
                f'no {"C++" if variable == "CXX" else "C"} compiler found (looked for {tried}); '
                'install one (Debian, Ubuntu: apt install g++) or name it in '
                f'{variable}')
        compilers.append(command)
    python = [Path(sysconfig.get_path(name)) for name in ('include', 'platinclude')]
    if not any((folder / 'Python.h').is_file() for folder in python):
        raise BuildError(
            f'Python.h is not in {python[0]}; install the headers of this Python '
            f'(Debian, Ubuntu: apt install python{sysconfig.get_python_version()}-dev)')
    includes = [generated / name for name in ('include', 'introspection', 'typesupport')]
    includes += sorted(folder for folder in (prefix / 'include').iterdir() if folder.is_dir())
    includes += [prefix / 'include']
    includes += [root / 'include' / name for name, root in provided.items()]
    includes += [*python, Path(numpy.get_include())]
    libraries = dict.fromkeys([prefix / 'lib', *(root / 'lib' for root in provided.values())])
    cc, cxx = compilers
    return Toolchain(cc, cxx, tuple(dict.fromkeys(includes)), tuple(libraries), generated)


def units(package: InterfacePackage, generated: Path, objects: Path) -> list[Unit]:
    """
    Return the runs of the compiler that one package needs.

    Small sources of one kind are joined, because most of a run goes into reading headers.

    :param package: the package.
    :param generated: the folder that the generators wrote to.
    :param objects: the folder for joined sources and objects.
    """
    name = package.name
    objects.mkdir(parents=True, exist_ok=True)

    def sources(folder: str, pattern: str) -> list[Path]:
        return sorted((generated / folder / name).rglob(pattern))

    groups = {
        'functions': [*sources('include', '*__functions.c'),
                      *sources('include', '*__type_support.c')],
        'introspection': sources('introspection', '*__type_support.c'),
        'python': [*sources('python', '*_s.c'), *sources('python', '*.ep.*.c')],
        'fastrtps': sources('include', '*__type_support_c.cpp'),
        'typesupport': sources('typesupport', '*__type_support.cpp'),
    }
    result = []
    for group, files in groups.items():
        is_cpp = files[0].suffix == '.cpp'
        for start in range(0, len(files), JOINED):
            joined = objects / f'{name}__{group}_{start // JOINED}{files[0].suffix}'
            joined.write_text(
                ''.join(f'#include "{path}"\n' for path in files[start:start + JOINED]), 'utf-8')
            flags = DISPATCH if group == 'typesupport' else ()
            result.append(Unit(joined, joined.with_suffix('.o'), is_cpp, flags))
    for path in sources('include', '*__description.c'):
        target = objects / f'{name}__{path.parts[-3]}_{path.stem}.o'
        result.append(Unit(path, target, False, ('-O0',)))  # data alone: nothing to optimize
    dispatch = Path(__file__).with_name('dispatch.c')
    result.append(Unit(dispatch, objects / f'{name}__dispatch.o', False))
    return result


def link_inputs(package: InterfacePackage, built: Mapping[str, Path]) -> list[str]:
    """
    Return the libraries that a package's module is linked with, and where it finds them.

    Its neighbours lie in their own packages beside it, the wheels' libraries in the environment's
    lib folder, three above the package.

    :param package: the package.
    :param built: for each package that is built here, its library.
    """
    inputs = []
    origins = ['$ORIGIN/../../..']
    for name in package.dependencies:
        if name in built:
            inputs.append(str(built[name]))
            origins.append(f'$ORIGIN/../{name}')
        else:
            inputs += [f'-l{name}__{library}' for library in PACKAGE_LIBRARIES]
    inputs += [f'-l{library}' for library in RUNTIME_LIBRARIES]
    return [*inputs, f'-Wl,-rpath,{":".join(origins)}']


def run(
    what: str, command: Sequence[str], environ: Mapping[str, str] | None = None,
) -> None:
    """
    Run a tool quietly.

    :param what: what it does, for the message.
    :raises BuildError: it failed; the text holds its output.
    """
    done = subprocess.run(
        command, env=environ, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    if done.returncode:
        output = done.stderr.decode('utf-8', 'replace').strip()
        raise BuildError(f'{what} failed (status {done.returncode}):\n{output}')
