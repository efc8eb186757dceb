# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The error that ends a build with one message and no traceback."""


class BuildError(Exception):
    """A build that cannot go on; the text says what is missing and what to do."""
