// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for the core library's file of this name: see emulated.hlsl.
