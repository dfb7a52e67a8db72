// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for URP's file of this name: see emulated.hlsl. Its world begins where the scene's does.
#define EMULATED_CAMERA _WorldSpaceCameraPos
#include "emulated.hlsl"
