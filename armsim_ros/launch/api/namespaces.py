# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Namespaces of nodes, relative and absolute."""

from __future__ import annotations


def is_root_namespace(ns: str) -> bool:
    """Return whether a namespace is ``/``."""
    return ns == '/'


def is_namespace_absolute(ns: str) -> bool:
    """Return whether a namespace begins with a slash."""
    return ns.startswith('/')


def make_namespace_absolute(ns: str | None) -> str | None:
    """Return a namespace with a slash at its begin, None for None."""
    return ns if ns is None or is_namespace_absolute(ns) else f'/{ns}'


def prefix_namespace(base_ns: str | None, ns: str | None) -> str | None:
    """
    Return a namespace relative to another one; an absolute one stays as it is.

    :param base_ns: None where there is none.
    :param ns: None where there is none; both None give None.
    """
    if ns is None:
        combined = base_ns
    elif not base_ns or is_namespace_absolute(ns):
        combined = ns
    else:
        combined = f'{"" if is_root_namespace(base_ns) else base_ns}/{ns}'
    if combined is None or is_root_namespace(combined):
        return combined
    return combined.rstrip('/')
