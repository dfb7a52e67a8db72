// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for the built-in pipeline's file of this name: see emulated.hlsl.
#include "emulated.hlsl"
