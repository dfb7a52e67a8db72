// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// The code of a material's Custom node that shows @NAME@.
// @SCRIPT@ makes the node. It gives light, premultiplied, and alpha: CMOT Float 4. Its inputs are @SETS@
// (Texture Coordinates), Viewer (CameraVectorWS, transformed from world to local space)@MORE@.
//
// The mesh carries the frame of the bake in its last four uv sets, in the world of the bake: the tangent and the
// bitangent's sign, then the normal. Before them is that of the bake; if there are six, the first is the images'.
#if PIXELSHADER
#define RADTEX_LEVEL(uv, texels, levels) radtex_level(uv, texels, levels)
#define RADTEX_STEADY 0.16  // what moves does not shimmer
// #define RADTEX_TEMPORAL  // cheaper, with noise that TAA and TSR average away; has no effect on buckets
#else  // hit shaders have no derivatives
#define RADTEX_LEVEL(uv, texels, levels) 0.0
#define RADTEX_NO_DERIVATIVES
#endif
@DEFINES@
@STRUCTS@
struct RadtexLookup {
@MEMBERS@
@FUNCTIONS@
float4 radtex_light(@ARGUMENTS@) {
@LOOKUP@
}
};
RadtexLookup radtex;
@VALUES@
// From the mesh as Unreal imports glTF to the world of the bake, z up.
float3x4 radtex_baked = float3x4(@BAKED@);
float4 radtex_found = radtex.radtex_light(
    float2(@LIGHT_UV@.x, 1.0 - @LIGHT_UV@.y), UV0,  // Unreal's v grows downwards, as images do
    mul(radtex_baked, float4(@PLACE@, 1.0)),
    @FRAME@,
    mul((float3x3)radtex_baked, Viewer), @SUN@);
@UNDEFINES@
#undef RADTEX_STEADY
#undef RADTEX_TEMPORAL
return radtex_found;
