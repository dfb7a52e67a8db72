# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in processes of their own, so that Blender's window stays alive.

Data goes one way: the session's scene is saved into a folder (`handover`), an order for a bake, a comparison
or an export is written beside it (`order`, `orders`), and a process does it and reports its progress
(`process`). The queue runs one process after another (`queue`); the panel draws its jobs (`job`).
"""
