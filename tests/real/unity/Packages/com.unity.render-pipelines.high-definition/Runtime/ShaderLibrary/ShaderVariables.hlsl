// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for HDRP's file of this name: see emulated.hlsl. Its world begins at the camera: object matrices, too.
#define EMULATED_CAMERA float3(0.0, 0.0, 0.0)
#include "emulated.hlsl"
uniform float emulated_exposure;
float GetCurrentExposureMultiplier() { return emulated_exposure; }
