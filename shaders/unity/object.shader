// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Shows @NAME@, a radiance texture: light that was path traced, for every direction that one may look from. One
// subshader for each render pipeline; Unity takes the one that it is for. Unlit: lamps of the scene add nothing.
Shader @TITLE@
{
    Properties
    {
@PROPERTIES@
        _RadtexExposure ("Exposure", Range(0, 16)) = 1
        [ToggleUI] _RadtexFollowExposure ("Follow HDRP's exposure", Float) = 0
@SUN@    }

    SubShader
    {
        PackageRequirements { "com.unity.render-pipelines.universal": "12.0" }
        Tags { "RenderPipeline" = "UniversalPipeline" "RenderType" = "@TYPE@" "Queue" = "@QUEUE@" "DisableBatching" = "True" }
        Cull @CULL@

        HLSLINCLUDE
        #pragma target 4.5
        #pragma multi_compile_instancing
        @KEYWORDS@
        #include "Packages/com.unity.render-pipelines.universal/ShaderLibrary/Core.hlsl"
        #define RADTEX_TO_WORLD(position) TransformObjectToWorld(position)
        #define RADTEX_TO_WORLD_NORMAL(normal) TransformObjectToWorldNormal(normal)
        #define RADTEX_TO_VIEWER(world) GetWorldSpaceViewDir(world)
        #define RADTEX_TO_OBJECT(direction) mul((float3x3)GetWorldToObjectMatrix(), direction)
        #define RADTEX_PIPELINE_EXPOSURE 1.0
        #ifndef RADTEX_STEADY
        #define RADTEX_STEADY 0.16  // what moves does not shimmer
        #endif
        #include @NUMBERS@
        ENDHLSL

        Pass
        {
            Name "Radiance"
            Tags { "LightMode" = "UniversalForwardOnly" }
            @BLEND@
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_pixel
            #define RADTEX_TO_CLIP(world, v) TransformWorldToHClip(world)
            #include "shaders/radtex_unity.hlsl"
            ENDHLSL
        }
        Pass
        {
            Name "ShadowCaster"
            Tags { "LightMode" = "ShadowCaster" }
            ColorMask 0
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_depth
            #pragma multi_compile_vertex _ _CASTING_PUNCTUAL_LIGHT_SHADOW
            #include "Packages/com.unity.render-pipelines.universal/ShaderLibrary/Shadows.hlsl"
            float3 _LightDirection, _LightPosition;

            // The place in a lamp's shadow map, moved away from the surface as the lamp's bias says.
            float4 radtex_shadow_place(float3 world, float3 normal)
            {
            #if _CASTING_PUNCTUAL_LIGHT_SHADOW
                float3 towards = normalize(_LightPosition - world);
            #else
                float3 towards = _LightDirection;
            #endif
                float4 place = TransformWorldToHClip(ApplyShadowBias(world, normal, towards));
            #if UNITY_REVERSED_Z
                place.z = min(place.z, UNITY_NEAR_CLIP_VALUE * place.w);
            #else
                place.z = max(place.z, UNITY_NEAR_CLIP_VALUE * place.w);
            #endif
                return place;
            }
            #define RADTEX_TO_CLIP(world, v) radtex_shadow_place(world, TransformObjectToWorldNormal(v.normal))
            #include "shaders/radtex_unity.hlsl"
            ENDHLSL
        }
        Pass
        {
            Name "DepthOnly"
            Tags { "LightMode" = "DepthOnly" }
            ColorMask R
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_depth
            #define RADTEX_TO_CLIP(world, v) TransformWorldToHClip(world)
            #include "shaders/radtex_unity.hlsl"
            ENDHLSL
        }
        Pass
        {
            Name "DepthNormalsOnly"
            Tags { "LightMode" = "DepthNormalsOnly" }
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_normals
            #define RADTEX_TO_CLIP(world, v) TransformWorldToHClip(world)
            #include "shaders/radtex_unity.hlsl"
            ENDHLSL
        }
    }

    SubShader
    {
        PackageRequirements { "com.unity.render-pipelines.high-definition": "12.0" }
        Tags { "RenderPipeline" = "HDRenderPipeline" "RenderType" = "@TYPE@" "Queue" = "@QUEUE@" "DisableBatching" = "True" }
        Cull @CULL@

        // The world begins at the camera here: places are taken from the object's space, and the way to the viewer from
        // HDRP's own function, so that nothing is a difference of large numbers.
        HLSLINCLUDE
        #pragma target 4.5
        #pragma only_renderers d3d11 playstation xboxone xboxseries vulkan metal switch
        #pragma multi_compile_instancing
        @KEYWORDS@
        #include "Packages/com.unity.render-pipelines.core/ShaderLibrary/Common.hlsl"
        #include "Packages/com.unity.render-pipelines.high-definition/Runtime/ShaderLibrary/ShaderVariables.hlsl"
        #define RADTEX_TO_WORLD(position) TransformObjectToWorld(position)
        #define RADTEX_TO_WORLD_NORMAL(normal) TransformObjectToWorldNormal(normal)
        #define RADTEX_TO_VIEWER(world) GetWorldSpaceViewDir(world)
        #define RADTEX_TO_OBJECT(direction) mul((float3x3)GetWorldToObjectMatrix(), direction)
        #define RADTEX_TO_CLIP(world, v) TransformWorldToHClip(world)
        #define RADTEX_PIPELINE_EXPOSURE lerp(1.0, GetCurrentExposureMultiplier(), _RadtexFollowExposure)
        #ifndef RADTEX_STEADY
        #define RADTEX_STEADY 0.16  // what moves does not shimmer
        #endif
        #include @NUMBERS@
        #include "shaders/radtex_unity.hlsl"
        ENDHLSL

        Pass
        {
            Name "ForwardOnly"
            Tags { "LightMode" = "ForwardOnly" }
            ZTest LEqual
            @BLEND@
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_pixel
            ENDHLSL
        }
        Pass
        {
            Name "ShadowCaster"
            Tags { "LightMode" = "ShadowCaster" }
            ColorMask 0
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_depth
            ENDHLSL
        }
        Pass
        {
            Name "DepthForwardOnly"
            Tags { "LightMode" = "DepthForwardOnly" }
            ColorMask 0
            HLSLPROGRAM
            #pragma vertex radtex_vertex
            #pragma fragment radtex_depth
            ENDHLSL
        }
    }

    SubShader
    {
        Tags { "RenderType" = "@TYPE@" "Queue" = "@QUEUE@" "DisableBatching" = "True" }
        Cull @CULL@

        Pass
        {
            Name "Radiance"
            Tags { "LightMode" = "Always" }
            @BLEND@
            HLSLPROGRAM
            #pragma target 4.5
            #pragma multi_compile_instancing
            #pragma vertex radtex_vertex
            #pragma fragment radtex_pixel
            @KEYWORDS@
            #include "UnityCG.cginc"
            #define RADTEX_TO_WORLD(position) mul(unity_ObjectToWorld, float4(position, 1.0)).xyz
            #define RADTEX_TO_WORLD_NORMAL(normal) UnityObjectToWorldNormal(normal)
            #define RADTEX_TO_CLIP(world, v) mul(UNITY_MATRIX_VP, float4(world, 1.0))
            #define RADTEX_TO_VIEWER(world) (unity_OrthoParams.w < 0.5 ? _WorldSpaceCameraPos - world : UNITY_MATRIX_V[2].xyz)
            #define RADTEX_TO_OBJECT(direction) mul((float3x3)unity_WorldToObject, direction)
            #define RADTEX_PIPELINE_EXPOSURE 1.0
            #ifndef RADTEX_STEADY
            #define RADTEX_STEADY 0.16  // what moves does not shimmer
            #endif
        #include @NUMBERS@
            #include "shaders/radtex_unity.hlsl"
            ENDHLSL
        }
        UsePass "Legacy Shaders/VertexLit/SHADOWCASTER"
    }
}
