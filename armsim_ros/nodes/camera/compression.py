# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures as JPEG and PNG, in the forms of image_transport's plugins."""

from __future__ import annotations

from io import BytesIO
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

FORMAT_OF_COLOUR = 'rgb8; jpeg compressed bgr8'
FORMAT_OF_DEPTH = '32FC1; compressedDepth png'
DEFAULT_QUALITY = 95
#: A stored value v is the depth _SCALE / (v - _OFFSET); 0 is none. As the transport's defaults,
#: which quantize 1 m by a tenth of a millimetre and end at 10 m.
_LONGEST, _AT_ONE_METRE = 10.0, 100.0
_SCALE = _AT_ONE_METRE * (_AT_ONE_METRE + 1.0)
_OFFSET = 1.0 - _SCALE / _LONGEST
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
    """Return depths (h, w) [m] as a header and a PNG of 16 bits of their inverses."""
    stored = np.zeros(depth.shape, dtype=np.uint16)
    seen = np.isfinite(depth) & (depth > 0.0) & (depth < _LONGEST)
    values = _SCALE / depth[seen].astype(np.float64) + _OFFSET
    stored[seen] = np.clip(np.round(values), 0, 65535).astype(np.uint16)
    return _HEADER.pack(0, _SCALE, _OFFSET) + _encoded(stored, 'PNG', compress_level=1)


def _encoded(pixels: NDArray[Any], kind: str, **options: Any) -> bytes:
    from PIL import Image

    content = BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(content, kind, **options)
    return content.getvalue()
