# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What differs between the arms of vendors: a table per vendor, read by name or by plugin."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module

from armsim_ros.errors import ConfigError, nearest, Problem
from armsim_ros.vendors.vendor import Vendor

__all__ = ['Vendor', 'find_vendor']

#: Vendor -> the module of its table.
TABLES = {
    'ur': 'armsim_ros.vendors.universal_robots',
    'franka': 'armsim_ros.vendors.franka',
    'kinova': 'armsim_ros.vendors.kinova',
}


def find_vendor(name: str, plugins: Iterable[str] = ()) -> Vendor | None:
    """
    Return the table of a vendor, None where there is none.

    :param name: a key of ``TABLES``, the name of a module with a ``VENDOR``, ``none``; or '' for
        the vendor whose table names one of the plugins.
    :param plugins: of the robot's hardware.
    :raises ConfigError: there is no such vendor, or its module has no table.
    """
    if name == 'none':
        return None
    if name:
        return _table(name)
    used = set(plugins)
    tables = (_table(known) for known in TABLES) if used else ()
    return next((table for table in tables if used.intersection(table.plugins)), None)


def _table(name: str) -> Vendor:
    try:
        vendor = getattr(import_module(TABLES.get(name, name)), 'VENDOR', None)
    except ImportError as error:
        raise ConfigError(Problem(
            f"hardware.vendor: '{name}' is not a vendor, and as a Python module it cannot be "
            f'imported: {error}', allowed=f'{", ".join(TABLES)}, none, or a module on PYTHONPATH',
            remedy=nearest(name, tuple(TABLES)))) from None
    if not isinstance(vendor, Vendor):
        raise ConfigError(Problem(
            f"hardware.vendor: the module '{name}' has no VENDOR",
            remedy='give it VENDOR = armsim_ros.vendors.Vendor(...)'))
    return vendor
