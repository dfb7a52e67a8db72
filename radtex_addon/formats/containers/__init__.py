# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Standard file formats of pixels and meshes: EXR, DDS, KTX2, PNG, glTF, NumPy."""
