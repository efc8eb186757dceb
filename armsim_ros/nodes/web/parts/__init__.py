# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the page does, a part a file; each answers what its piece of the panel asks."""
