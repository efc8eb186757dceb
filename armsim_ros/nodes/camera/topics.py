# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topics of a camera: colour, depth, points, compressed, and its ``/diagnostics``."""

from __future__ import annotations

from array import array
from io import BytesIO
import struct
import sys
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
import numpy as np
from numpy.typing import NDArray
from rclpy.duration import Duration
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2, PointField

from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.polling_node import PollingNode
from armsim_ros.sim.camera import Camera, Picture, points

FORMAT_OF_COLOUR = 'rgb8; jpeg compressed bgr8'
FORMAT_OF_DEPTH = '32FC1; compressedDepth png'
DEFAULT_QUALITY = 95
#: A stored value v is the depth _SCALE / (v - _OFFSET); 0 is none. As the transport's defaults,
#: which quantize 1 m by a tenth of a millimetre and end at 10 m.
_LONGEST, _AT_ONE_METRE = 10.0, 100.0
_SCALE = _AT_ONE_METRE * (_AT_ONE_METRE + 1.0)
_OFFSET = 1.0 - _SCALE / _LONGEST
_SHORTEST = _SCALE / (np.iinfo(np.uint16).max - _OFFSET)
#: Kind of the content, the two numbers above.
_HEADER = struct.Struct('<iff')


def why_not() -> str:
    """Return why pictures cannot be compressed; '' where they can."""
    try:
        import PIL.Image  # noqa: F401
    except ImportError:
        return "Pillow is not installed; the extra 'web' brings it"
    return ''


def jpeg(colour: NDArray[np.uint8], quality: int) -> bytes:
    """
    Return a picture (h, w, 3) as JPEG.

    :param quality: 1 .. 100; others are the nearest of these.
    """
    return _encoded(colour, 'JPEG', quality=min(max(quality, 1), 100))


def depth_as_png(depth: NDArray[np.float32]) -> bytes:
    """
    Return depths (h, w) [m] as a header and a PNG of 16 bits of their inverses.

    Depths whose inverses do not fit, below 0.152 m or from 10 m on, are stored as none.
    """
    stored = np.zeros(depth.shape, dtype=np.uint16)
    seen = np.isfinite(depth) & (depth >= _SHORTEST) & (depth < _LONGEST)
    stored[seen] = np.round(_SCALE / depth[seen].astype(np.float64) + _OFFSET)
    return _HEADER.pack(0, _SCALE, _OFFSET) + _encoded(stored, 'PNG', compress_level=1)


def _encoded(pixels: NDArray[Any], kind: str, **options: Any) -> bytes:
    from PIL import Image

    content = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(content, kind, **options)
    return content.getvalue()


_BIG_ENDIAN = sys.byteorder == 'big'
_POINT_FIELDS = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
                 for i, name in enumerate(('x', 'y', 'z', 'rgb'))]
_POINT_SIZE = 16
_LONGEST_TRANSPORT = Duration(seconds=10)


class CameraTopics:
    """
    ``<name>/color/image_raw``, ``<name>/depth/image_raw``, their infos, ``<name>/depth/points``.

    Compressed as by image_transport: ``color/image_raw/compressed`` and
    ``depth/image_raw/compressedDepth``; without Pillow these are not there.
    """

    def __init__(self, node: Node, camera: Camera) -> None:
        self._node, self._camera = node, camera

        def publisher(kind: Any, topic: str) -> Any:
            return node.create_publisher(kind, f'/{camera.name}/{topic}', qos.PICTURES)

        self._colour = publisher(Image, 'color/image_raw')
        self._depth = publisher(Image, 'depth/image_raw')
        self._points = publisher(PointCloud2, 'depth/points')
        self._compressed: dict[str, Any] = {}
        if why_not():
            node.get_logger().info(f'no compressed pictures: {why_not()}')
        else:
            self._compressed = {topic: publisher(CompressedImage, topic) for topic in (
                'color/image_raw/compressed', 'depth/image_raw/compressedDepth')}
            self._quality = f'{camera.name}.color.image_raw.compressed.jpeg_quality'
            if not node.has_parameter(self._quality):
                node.declare_parameter(self._quality, DEFAULT_QUALITY)
        self._infos = [publisher(CameraInfo, f'{kind}/camera_info') for kind in ('color', 'depth')]
        self._info = camera_info(camera)

    def close(self) -> None:
        """Take the topics down."""
        for publisher in (*self._drawn, *self._infos):
            self._node.destroy_publisher(publisher)

    @property
    def wanted(self) -> bool:
        """Whether there are subscribers."""
        return self.seen or any(publisher.get_subscription_count() for publisher in self._infos)

    @property
    def seen(self) -> bool:
        """Whether there are subscribers to drawn pictures."""
        return any(publisher.get_subscription_count() for publisher in self._drawn)

    @property
    def _drawn(self) -> tuple[Any, ...]:
        """Publishers of what has to be drawn."""
        return self._colour, self._depth, self._points, *self._compressed.values()

    def publish(self, time_ns: int, picture: Picture | None) -> None:
        """
        Publish a picture to the subscribers; None publishes what is known without a picture.

        :param time_ns: of the state that it shows [ns].
        """
        fill_time(self._info.header.stamp, time_ns)
        if picture is not None:
            self._publish_picture(picture)
        for info in self._infos:
            if info.get_subscription_count():
                info.publish(self._info)

    def wait_until_taken(self) -> None:
        """Wait until all reliable subscriptions have what was published, or are too slow."""
        for publisher in (*self._drawn, *self._infos):
            if publisher.get_subscription_count():
                publisher.wait_for_all_acked(_LONGEST_TRANSPORT)

    def _publish_picture(self, picture: Picture) -> None:
        if self._colour.get_subscription_count():
            self._colour.publish(self._image(picture.colour, 'rgb8'))
        if self._depth.get_subscription_count():
            self._depth.publish(self._image(picture.depth, '32FC1'))
        if self._points.get_subscription_count():
            camera = self._camera
            self._points.publish(PointCloud2(
                header=self._info.header, height=camera.height, width=camera.width,
                fields=_POINT_FIELDS, is_bigendian=_BIG_ENDIAN, point_step=_POINT_SIZE,
                row_step=_POINT_SIZE * camera.width, is_dense=False,
                data=_bytes(points(picture, camera))))

        for topic, publisher in self._compressed.items():
            if publisher.get_subscription_count():
                publisher.publish(self._compressed_image(topic, picture))

    def _compressed_image(self, topic: str, picture: Picture) -> CompressedImage:
        message = CompressedImage(header=self._info.header)
        if topic.startswith('color'):
            quality = int(self._node.get_parameter(self._quality).value)
            message.format, content = FORMAT_OF_COLOUR, jpeg(picture.colour, quality)
        else:
            message.format, content = FORMAT_OF_DEPTH, depth_as_png(picture.depth)
        message.data = array('B', content)
        return message

    def _image(self, pixels: Any, encoding: str) -> Image:
        return Image(
            header=self._info.header, height=pixels.shape[0], width=pixels.shape[1],
            encoding=encoding, is_bigendian=_BIG_ENDIAN,
            step=pixels[0].nbytes, data=_bytes(pixels))


def camera_info(camera: Camera) -> CameraInfo:
    """Return how a camera maps points to pixels, without a time."""
    focal, (u, v) = camera.focal, camera.centre
    message = CameraInfo(
        height=camera.height, width=camera.width, distortion_model='plumb_bob', d=[0.0] * 5,
        k=[focal, 0.0, u, 0.0, focal, v, 0.0, 0.0, 1.0],
        r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p=[focal, 0.0, u, 0.0, 0.0, focal, v, 0.0, 0.0, 0.0, 1.0, 0.0])
    message.header.frame_id = camera.optical_frame
    return message


def _bytes(pixels: Any) -> array[int]:
    """Return pixels as what rclpy copies in a single piece."""
    content = array('B')
    content.frombytes(pixels.tobytes())
    return content


#: Wall time between two messages [s].
_PERIOD = 1.0


class RenderingDiagnostics:
    """Publishes whether pictures are drawn, and how quickly."""

    def __init__(self, node: PollingNode) -> None:
        self._node = node
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', qos.DIAGNOSTICS)
        self._due = 0.0
        self._pictures, self._seconds = 0, 0.0
        self.backend = ''
        """What draws."""
        self.fault = ''
        """Why nothing can be drawn."""
        self.cameras = 0
        """How many cameras the simulation has; 0 as long as there is none."""

    def count(self, seconds: float) -> None:
        """Count a picture that took so long [s]."""
        self._pictures += 1
        self._seconds += seconds

    def publish(self) -> None:
        """Publish when it is due and there are subscribers."""
        now = time.monotonic()
        if now < self._due or not self._publisher.get_subscription_count():
            return
        self._due = now + _PERIOD
        level, text = DiagnosticStatus.OK, 'Pictures are drawn'
        if self.fault:
            level, text = DiagnosticStatus.ERROR, self.fault
        elif not self.cameras:
            level, text = DiagnosticStatus.WARN, 'No simulation with camera:=true is there'
        values = {
            'backend': self.backend,
            'cameras': str(self.cameras),
            'pictures': str(self._pictures),
            'drawing_ms': f'{self._seconds / max(self._pictures, 1) * 1e3:.1f}',
        }
        message = DiagnosticArray(status=[DiagnosticStatus(
            level=level, name='camera: Rendering', message=text,
            hardware_id=self._node.get_fully_qualified_name(),
            values=[KeyValue(key=key, value=value) for key, value in values.items()])])
        self._node.catch_up()
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
