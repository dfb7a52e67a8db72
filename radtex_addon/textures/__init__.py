# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake's images as textures that engines load: formats, arrangements, the flat lightmap."""
