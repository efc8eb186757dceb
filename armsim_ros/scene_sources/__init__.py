# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What fills a planning scene: `.scene` files and the simulated world."""
