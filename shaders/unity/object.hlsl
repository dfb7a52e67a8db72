// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// How @NAME@ is looked up: RadTex wrote its numbers into this file. @NAME@.shader includes it.

#ifndef RADTEX_OBJECT_HLSL
#define RADTEX_OBJECT_HLSL

@DEFINES@
#define RADTEX_LEVEL radtex_level

SamplerState radtex_trilinear_clamp_sampler;  // Unity knows by its name what it is
@TEXTURES@

@CONSTANTS@

// From the mesh, as importers of glTF give it to Unity, to the world of the bake, z up.
static const float3x4 RADTEX_BAKED = float3x4(@BAKED@);

@INCLUDES@

float4 radtex_light(@ARGUMENTS@) {
@LOOKUP@
}

#endif
