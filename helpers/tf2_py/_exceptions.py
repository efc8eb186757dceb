# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why a transform is not available."""


class TransformException(Exception):
    """Base of all exceptions of tf2."""


class ConnectivityException(TransformException):
    """The two frames belong to different trees."""


class LookupException(TransformException):
    """A frame does not exist, or the frames form a loop."""


class ExtrapolationException(TransformException):
    """The buffer has no data for the requested time."""


class InvalidArgumentException(TransformException):
    """A frame name is empty or begins with a slash."""


class TimeoutException(TransformException):
    """A remote buffer did not respond in time."""
