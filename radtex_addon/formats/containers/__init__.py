# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of pixels and meshes as any program knows them: EXR, DDS, KTX2, PNG, glTF, NumPy."""
