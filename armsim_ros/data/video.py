# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Videos of an episode, as bytes that are equal for equal pictures."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armsim_ros.errors import extras_hint, ResourceError

#: Of all videos; a key frame every other frame, for random access.
_CODEC, _PIXELS = 'libx264', 'yuv420p'
_OPTIONS = {'crf': '18', 'g': '2', 'bf': '0', 'preset': 'medium', 'threads': '1'}
#: What ``info.json`` has of them.
VIDEO_INFO = {'video.codec': 'h264', 'video.pix_fmt': _PIXELS, 'video.g': 2, 'video.crf': 18}
Picture = NDArray[np.uint8]


def encoded(pictures: Iterable[Picture], fps: int) -> bytes:
    """
    Return an MP4 file.

    :param pictures: (h, w, 3) each, of equal and even size.
    :raises ResourceError: PyAV is not installed.
    """
    av, file = _pyav(), io.BytesIO()
    with av.open(file, 'w', format='mp4', options={'fflags': '+bitexact'}) as container:
        stream: Any = None
        for number, picture in enumerate(pictures):
            if stream is None:
                stream = container.add_stream(_CODEC, rate=fps, options=dict(_OPTIONS))
                stream.height, stream.width = picture.shape[:2]
                stream.pix_fmt = _PIXELS
                stream.codec_context.thread_count = 1
                stream.codec_context.time_base = Fraction(1, fps)
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format='rgb24')
            frame.pts, frame.time_base = number, Fraction(1, fps)
            container.mux(stream.encode(frame))
        if stream is not None:
            container.mux(stream.encode())
    return file.getvalue()


def decoded(content: bytes) -> list[Picture]:
    """Return the pictures (h, w, 3) of a file: MP4, or a single JPEG or PNG."""
    with _pyav().open(io.BytesIO(content)) as container:
        return [frame.to_ndarray(format='rgb24') for frame in container.decode(video=0)]


def _pyav() -> Any:
    try:
        import av
    except ImportError:
        raise ResourceError(
            'videos need PyAV, which is not installed: ' + extras_hint('data')) from None
    return av
