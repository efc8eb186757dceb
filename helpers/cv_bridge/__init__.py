# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Between image messages and arrays, with NumPy; OpenCV only for what NumPy cannot do."""

from cv_bridge.core import CvBridge, CvBridgeError

__all__ = ['CvBridge', 'CvBridgeError']
