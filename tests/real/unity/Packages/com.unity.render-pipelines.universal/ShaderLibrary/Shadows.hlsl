// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for URP's file of this name: see emulated.hlsl.
#define UNITY_REVERSED_Z 1
#define UNITY_NEAR_CLIP_VALUE 1.0
uniform float4 _ShadowBias;
float3 ApplyShadowBias(float3 position, float3 normal, float3 towards) {
    return position + towards * _ShadowBias.x + normal * ((1.0 - saturate(dot(towards, normal))) * _ShadowBias.y);
}
