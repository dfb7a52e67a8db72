// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Stands for the files of Unity that its shaders include: what Unity's manual and its shaders name, written anew and no
// longer than our shaders need it. SHOWN_PER_PIXEL makes its variables ones that a test sets.
#ifndef EMULATED_HLSL
#define EMULATED_HLSL

#ifdef SHOWN_PER_PIXEL
#define CBUFFER_START(name) cbuffer name : register(b1) {
#else
#define CBUFFER_START(name) cbuffer name {
#endif
#define CBUFFER_END };

#ifdef STEREO_INSTANCING_ON
#define UNITY_VERTEX_INPUT_INSTANCE_ID uint instanceID : SV_InstanceID;
#define UNITY_VERTEX_OUTPUT_STEREO uint stereoTargetEyeIndex : SV_RenderTargetArrayIndex;
#define UNITY_SETUP_INSTANCE_ID(v) unity_InstanceID = v.instanceID >> 1; unity_StereoEyeIndex = v.instanceID & 1
#define UNITY_TRANSFER_INSTANCE_ID(v, o) o.instanceID = v.instanceID
#define UNITY_INITIALIZE_VERTEX_OUTPUT_STEREO(o) o.stereoTargetEyeIndex = unity_StereoEyeIndex
#define UNITY_SETUP_STEREO_EYE_INDEX_POST_VERTEX(f) unity_StereoEyeIndex = f.stereoTargetEyeIndex
static uint unity_InstanceID, unity_StereoEyeIndex;
#else
#define UNITY_VERTEX_INPUT_INSTANCE_ID
#define UNITY_VERTEX_OUTPUT_STEREO
#define UNITY_SETUP_INSTANCE_ID(v)
#define UNITY_TRANSFER_INSTANCE_ID(v, o)
#define UNITY_INITIALIZE_VERTEX_OUTPUT_STEREO(o)
#define UNITY_SETUP_STEREO_EYE_INDEX_POST_VERTEX(f)
#endif

#ifdef SHOWN_PER_PIXEL
#define UNIFORM static
#else
#define UNIFORM uniform
#endif
UNIFORM float4x4 unity_ObjectToWorld, unity_WorldToObject, UNITY_MATRIX_VP, UNITY_MATRIX_V;
UNIFORM float3 _WorldSpaceCameraPos;
UNIFORM float4 unity_OrthoParams;

float3 emulated_normal(float3 normal) {
    return normalize(mul(normal, (float3x3)unity_WorldToObject));
}

// The common part of URP's and HDRP's libraries; places are where the pipeline's world begins.
float4x4 GetObjectToWorldMatrix() { return unity_ObjectToWorld; }
float4x4 GetWorldToObjectMatrix() { return unity_WorldToObject; }
float3 TransformObjectToWorld(float3 position) { return mul(GetObjectToWorldMatrix(), float4(position, 1.0)).xyz; }
float4 TransformWorldToHClip(float3 position) { return mul(UNITY_MATRIX_VP, float4(position, 1.0)); }
float3 TransformObjectToWorldNormal(float3 normal) { return emulated_normal(normal); }
float3 UnityObjectToWorldNormal(float3 normal) { return emulated_normal(normal); }

#ifdef EMULATED_CAMERA
float3 GetWorldSpaceViewDir(float3 world) {
    return unity_OrthoParams.w == 0.0 ? EMULATED_CAMERA - world : UNITY_MATRIX_V[2].xyz;
}
#endif

#endif
