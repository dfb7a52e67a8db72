// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What RadTexSetup.cs uses of Unity's scripting API, declared anew after its reference (docs.unity3d.com/ScriptReference),
// so that a compiler can hold the script to it. Textures keep what they are given; all else does nothing.

using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public enum ColorSpace { Gamma = 0, Linear = 1 }
    public enum TextureWrapMode { Repeat, Clamp, Mirror, MirrorOnce }
    public enum FilterMode { Point, Bilinear, Trilinear }

    public class Object
    {
        public string name { get; set; }
        public static void DestroyImmediate(Object obj) { }
    }

    public class Component : Object { }

    public class Renderer : Component
    {
        public Material[] sharedMaterials { get; set; }
        public Rendering.LightProbeUsage lightProbeUsage { get; set; }
        public Rendering.ReflectionProbeUsage reflectionProbeUsage { get; set; }
    }

    public class MeshRenderer : Renderer { }

    public sealed class GameObject : Object
    {
        public T[] GetComponentsInChildren<T>(bool includeInactive) { return new T[0]; }
    }

    public sealed class Shader : Object { }

    public class Material : Object
    {
        public Material(Shader shader) { this.shader = shader; }
        public Shader shader { get; set; }
        public bool enableInstancing { get; set; }
        public void EnableKeyword(string keyword) { }
        public void SetTexture(string name, Texture value) { }
    }

    public class Texture : Object
    {
        public TextureWrapMode wrapMode { get; set; }
        public FilterMode filterMode { get; set; }
        public int anisoLevel { get; set; }

        // Not Unity's: what a test looks at.
        public readonly List<string> Made = new List<string>();
        public readonly List<byte> Given = new List<byte>();
    }

    public sealed class Texture2D : Texture
    {
        public Texture2D(
            int width, int height, Experimental.Rendering.GraphicsFormat format, int mipCount,
            Experimental.Rendering.TextureCreationFlags flags)
        {
            Made.Add("2D " + width + " " + height + " " + format + " " + mipCount + " " + flags);
        }

        public void SetPixelData<T>(T[] data, int mipLevel, int sourceDataStartIndex = 0)
        {
            Made.Add("level " + mipLevel);
            Given.AddRange((byte[])(object)data);
        }

        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) { }
    }

    public sealed class Texture2DArray : Texture
    {
        public Texture2DArray(
            int width, int height, int depth, Experimental.Rendering.GraphicsFormat format,
            Experimental.Rendering.TextureCreationFlags flags, int mipCount)
        {
            Made.Add("array " + width + " " + height + " " + depth + " " + format + " " + mipCount + " " + flags);
        }

        public void SetPixelData<T>(T[] data, int mipLevel, int element, int sourceDataStartIndex = 0)
        {
            Made.Add("level " + mipLevel + " of " + element);
            Given.AddRange((byte[])(object)data);
        }

        public void Apply(bool updateMipmaps, bool makeNoLongerReadable) { }
    }
}

namespace UnityEngine.Rendering
{
    public enum LightProbeUsage { Off, BlendProbes, UseProxyVolume, ExplicitIndex, CustomProvided }
    public enum ReflectionProbeUsage { Off, BlendProbes, BlendProbesAndSkybox, Simple }
}

namespace UnityEngine.Experimental.Rendering
{
    [Flags]
    public enum TextureCreationFlags { None = 0, MipChain = 1 }

    public enum GraphicsFormat
    {
        None, R8G8B8A8_UNorm, R16G16B16A16_SFloat, RGBA_DXT5_SRGB, RGBA_DXT5_UNorm, R_BC4_UNorm, RG_BC5_UNorm,
        RGB_BC6H_UFloat, RGBA_BC7_SRGB, RGBA_BC7_UNorm,
    }
}

namespace UnityEditor
{
    using UnityEngine;

    [AttributeUsage(AttributeTargets.Method)]
    public sealed class MenuItem : Attribute { public MenuItem(string itemName) { } }

    public static class PlayerSettings { public static ColorSpace colorSpace { get; set; } }

    public static class EditorUtility { public static void SetDirty(Object target) { } }

    public class AssetImporter : Object
    {
        public static AssetImporter GetAtPath(string path) { return null; }
        public void SaveAndReimport() { }
    }

    public enum TextureImporterType { Default, NormalMap }
    public enum TextureImporterAlphaSource { None, FromInput, FromGrayScale }
    public enum TextureImporterNPOTScale { None, ToNearest, ToLarger, ToSmaller }
    public enum TextureImporterCompression { Uncompressed, Compressed, CompressedHQ, CompressedLQ }
    public enum TextureImporterFormat { Automatic = -1, RGBAHalf = 17 }

    public sealed class TextureImporterPlatformSettings
    {
        public TextureImporterFormat format { get; set; }
        public int maxTextureSize { get; set; }
    }

    public sealed class TextureImporter : AssetImporter
    {
        public TextureImporterType textureType { get; set; }
        public bool sRGBTexture { get; set; }
        public TextureImporterAlphaSource alphaSource { get; set; }
        public bool alphaIsTransparency { get; set; }
        public TextureImporterNPOTScale npotScale { get; set; }
        public bool mipmapEnabled { get; set; }
        public TextureWrapMode wrapMode { get; set; }
        public FilterMode filterMode { get; set; }
        public int anisoLevel { get; set; }
        public TextureImporterCompression textureCompression { get; set; }
        public int maxTextureSize { get; set; }
        public TextureImporterPlatformSettings GetDefaultPlatformTextureSettings() { return null; }
        public void SetPlatformTextureSettings(TextureImporterPlatformSettings platformSettings) { }
    }

    [Flags]
    public enum ImportAssetOptions { Default = 0, ForceUpdate = 1 }

    public static class AssetDatabase
    {
        public static void ImportAsset(string path, ImportAssetOptions options) { }
        public static void SetImporterOverride<T>(string path) where T : AssetImporter { }
        public static T LoadAssetAtPath<T>(string assetPath) where T : Object { return null; }
        public static void CreateAsset(Object asset, string path) { }
        public static void SaveAssets() { }
    }

    public static class PrefabUtility
    {
        public static Object InstantiatePrefab(Object assetComponentOrGameObject) { return null; }
        public static GameObject SaveAsPrefabAsset(GameObject instanceRoot, string assetPath) { return null; }
    }
}

namespace UnityEditor.AssetImporters
{
    using UnityEngine;

    public sealed class AssetImportContext
    {
        public string assetPath { get { return ""; } }
        public void AddObjectToAsset(string identifier, Object obj) { }
        public void SetMainObject(Object obj) { }
    }

    public abstract class ScriptedImporter : AssetImporter
    {
        public abstract void OnImportAsset(AssetImportContext ctx);
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class ScriptedImporterAttribute : Attribute
    {
        public ScriptedImporterAttribute(int version, string[] exts, string[] overrideExts) { }
    }
}
