# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in processes of their own, so that Blender's window stays alive.

Data goes one way: the session's scene into a folder (`handover`), an order for a bake, a comparison or an
export (`order`, `orders`), a process that says where it is (`process`), and all of them one after another
(`queue`), told as plain data (`job`).
"""
