# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Transforming of stamped messages, for every kind of buffer."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any, ClassVar

from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from std_msgs.msg import Header

AT_ONCE = Duration()


class TypeException(Exception):
    """No function is registered for a type."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(Exception):
    """A subclass of BufferInterface lacks a look-up method."""

    def __init__(self) -> None:
        super().__init__()
        self.errstr = 'CanTransform or LookupTransform not implemented'

    def __str__(self) -> str:
        """Return the reason."""
        return self.errstr


class TransformRegistration:
    """
    The functions that transform messages, by type; shared by all buffers.

    tf2_geometry_msgs registers those of geometry_msgs when it is imported.
    """

    _functions: ClassVar[dict[Any, Callable[[Any, TransformStamped], Any]]] = {}

    def print_me(self) -> None:
        """Print what is registered."""
        print(self._functions)

    def add(self, key: Any, callback: Callable[[Any, TransformStamped], Any]) -> None:
        """
        Register a function.

        :param key: the type that it transforms.
        :param callback: returns its first argument, transformed by its second.
        """
        self._functions[key] = callback

    def get(self, key: Any) -> Callable[[Any, TransformStamped], Any]:
        """
        Return the function for a type.

        :raises TypeException: there is none.
        """
        return _registered(self._functions, key)


class ConvertRegistration:
    """The functions that convert between types; shared by all."""

    _to_msg: ClassVar[dict[Any, Callable[[Any], Any]]] = {}
    _from_msg: ClassVar[dict[Any, Callable[[Any], Any]]] = {}
    _convert: ClassVar[dict[Any, Callable[[Any], Any]]] = {}

    def add_from_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register the function that makes a type from its message."""
        self._from_msg[key] = callback

    def add_to_msg(self, key: Any, callback: Callable[[Any], Any]) -> None:
        """Register the function that makes the message of a type."""
        self._to_msg[key] = callback

    def add_convert(self, key: tuple[Any, Any], callback: Callable[[Any], Any]) -> None:
        """Register the function that converts the first type of key to the second."""
        self._convert[key] = callback

    def get_from_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return what add_from_msg registered; TypeException where that is nothing."""
        return _registered(self._from_msg, key)

    def get_to_msg(self, key: Any) -> Callable[[Any], Any]:
        """Return what add_to_msg registered; TypeException where that is nothing."""
        return _registered(self._to_msg, key)

    def get_convert(self, key: tuple[Any, Any]) -> Callable[[Any], Any]:
        """Return what add_convert registered; TypeException where that is nothing."""
        return _registered(self._convert, key)


class BufferInterface:
    """Base of buffers: subclasses bring the look-ups, this class transforms messages."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(self, object_stamped: Any, target_frame: str, timeout: Duration = AT_ONCE,
                  new_type: Any = None) -> Any:
        """
        Return a stamped object in another frame.

        :param object_stamped: of a registered type, with a header.
        :param timeout: how long to wait for the transform.
        :param new_type: the type of the result (default: the object's).
        :raises TypeException: the type is not registered.
        :raises tf2_py.TransformException: the transform is not available.
        """
        return self._transformed(object_stamped, new_type, lambda header: self.lookup_transform(
            target_frame, header.frame_id, header.stamp, timeout))

    def transform_full(self, object_stamped: Any, target_frame: str, target_time: Any,
                       fixed_frame: str, timeout: Duration = AT_ONCE,
                       new_type: Any = None) -> Any:
        """
        Return a stamped object in another frame at another time.

        :param target_time: of the target frame.
        :param fixed_frame: the frame that is fixed between the two times.

        Other parameters and exceptions as transform.
        """
        return self._transformed(
            object_stamped, new_type, lambda header: self.lookup_transform_full(
                target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout))

    def _transformed(self, object_stamped: Any, new_type: Any,
                     look_up: Callable[[Header], TransformStamped]) -> Any:
        function = self.registration.get(type(object_stamped))
        result = function(object_stamped, look_up(object_stamped.header))
        return result if new_type is None else convert(result, new_type)

    def lookup_transform(self, target_frame: str, source_frame: str, time: Any,
                         timeout: Duration = AT_ONCE) -> TransformStamped:
        """Return the pose of a frame in another; subclasses implement it."""
        raise NotImplementedException()

    def lookup_transform_full(self, target_frame: str, target_time: Any, source_frame: str,
                              source_time: Any, fixed_frame: str,
                              timeout: Duration = AT_ONCE) -> TransformStamped:
        """Return the pose of a frame in another at two times; subclasses implement it."""
        raise NotImplementedException()

    def can_transform(self, target_frame: str, source_frame: str, time: Any,
                      timeout: Duration = AT_ONCE) -> Any:
        """Return whether a look-up is possible; subclasses implement it."""
        raise NotImplementedException()

    def can_transform_full(self, target_frame: str, target_time: Any, source_frame: str,
                           source_time: Any, fixed_frame: str,
                           timeout: Duration = AT_ONCE) -> Any:
        """Return whether a look-up at two times is possible; subclasses implement it."""
        raise NotImplementedException()


def Stamped(obj: Any, stamp: Any, frame_id: str) -> Any:
    """Return the object with a new header."""
    obj.header = Header(frame_id=frame_id, stamp=stamp)
    return obj


def convert(a: Any, b_type: Any) -> Any:
    """
    Return an object as another type, through its message where there is no direct conversion.

    :raises TypeException: no conversion is registered.
    """
    registration = ConvertRegistration()
    try:
        function = registration.get_convert((type(a), b_type))
    except TypeException:
        if type(a) is b_type:
            return deepcopy(a)
        return registration.get_from_msg(b_type)(registration.get_to_msg(type(a))(a))
    return function(a)


def _registered(functions: dict[Any, Callable[..., Any]], key: Any) -> Callable[..., Any]:
    try:
        return functions[key]
    except KeyError:
        raise TypeException(f'Type {key} is not loaded or supported; for geometry_msgs: '
                            'import tf2_geometry_msgs') from None
