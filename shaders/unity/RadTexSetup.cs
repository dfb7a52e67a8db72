// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Sets @NAME@ up: Assets > RadTex > Set up @TITLE@. It sets how the textures are imported, makes the materials, and
// saves a prefab of the mesh with them. It may be run again, after another export too.

using System;
using System.Collections.Generic;
using System.IO;
using System.Runtime.CompilerServices;
using UnityEditor;
using UnityEditor.AssetImporters;
using UnityEngine;
using UnityEngine.Experimental.Rendering;
using UnityEngine.Rendering;

namespace RadTexExports.@IDENTIFIER@
{
    public static class SetUp
    {
        const string Name = "@NAME@";

        // Each texture's name in the shader, and its file.
        static readonly string[,] Textures =
        {
@TEXTURE_FILES@
        };

        // Each material's name in the mesh's file, and its number in the shader.
        static readonly Dictionary<string, int> Materials = new Dictionary<string, int>
        {
@MATERIAL_NUMBERS@
        };

        // The images that materials are shown by.
        static readonly OwnImage[] Images =
        {
@OWN_IMAGES@
        };

        [MenuItem("Assets/RadTex/Set up @TITLE@")]
        public static void Run()
        {
            if (PlayerSettings.colorSpace != ColorSpace.Linear)
            {
                throw new InvalidOperationException(
                    "RadTex: set Project Settings > Player > Color Space to Linear, then set up " + Name + " again");
            }
            CheckNames();
            string folder = Folder();
            ImportTextures(folder);
            Dictionary<int, Material> materials = MakeMaterials(folder);
            SavePrefab(folder, materials);
            AssetDatabase.SaveAssets();
        }

        // The export's folder, as the asset database names it: this file lies in its folder Editor.
        static string Folder([CallerFilePath] string here = "")
        {
            string project = Path.GetFullPath(".").Replace('\\', '/').TrimEnd('/') + "/";
            string folder = Path.GetDirectoryName(Path.GetDirectoryName(Path.GetFullPath(here))).Replace('\\', '/');
            if (!folder.StartsWith(project, StringComparison.OrdinalIgnoreCase))
            {
                throw new InvalidOperationException("RadTex: copy the folder of " + Name + " into Assets: " + folder);
            }
            return folder.Substring(project.Length);
        }

        static void CheckNames()
        {
            var files = new List<string> { Name + ".shader", "@MESH@" };
            var endings = new List<string[]> { new[] { ".shader" }, new[] { ".glb" } };
            for (int k = 0; k < Textures.GetLength(0); k++)
            {
                files.Add(Textures[k, 1]);
                endings.Add(new[] { ".dds", ".exr" });
            }
            foreach (OwnImage image in Images)
            {
                files.Add(image.File);
                endings.Add(new[] { ".png", ".jpg" });
            }
            for (int k = 0; k < files.Count; k++)
            {
                if (!IsPlain(files[k], endings[k]))
                {
                    throw new InvalidOperationException("RadTex: " + files[k] + " is no file of this folder: export it again");
                }
            }
        }

        // Whether it is the name of a file in the export's folder, with one of these endings: nothing else is opened. The rule
        // is that of docs/format.md of RadTex, "What a reader refuses".
        public static bool IsPlain(string name, params string[] endings)
        {
            if (name.Length > 255 || name.Trim() == "" || name[0] == '.' || name[0] == ' ')
            {
                return false;
            }
            foreach (char mark in name)
            {
                if (char.IsControl(mark) || mark == '\u2028' || mark == '\u2029' || "<>:\"/\\|?*".IndexOf(mark) >= 0)
                {
                    return false;
                }
            }
            string device = name.Split('.')[0].TrimEnd(' ').ToLowerInvariant();
            bool numbered = device.Length == 4 && device[3] >= '0' && device[3] <= '9';
            string[] devices = { "con", "prn", "aux", "nul" };
            if (Array.IndexOf(devices, device) >= 0 || (numbered && (device.StartsWith("com") || device.StartsWith("lpt"))))
            {
                return false;
            }
            return Array.Exists(endings, ending => name.EndsWith(ending, StringComparison.Ordinal));
        }

        static void ImportTextures(string folder)
        {
            for (int k = 0; k < Textures.GetLength(0); k++)
            {
                string path = folder + "/" + Textures[k, 1];
                if (path.EndsWith(".dds", StringComparison.OrdinalIgnoreCase))
                {
                    AssetDatabase.SetImporterOverride<DdsImporter>(path);
                    AssetDatabase.ImportAsset(path, ImportAssetOptions.ForceUpdate);
                }
                else
                {
                    ImportExr(path);
                }
            }
            var done = new HashSet<string>();
            foreach (OwnImage image in Images)
            {
                if (done.Add(image.File))
                {
                    ImportImage(folder + "/" + image.File, image);
                }
            }
        }

        static TextureImporter ImporterOf(string path)
        {
            var importer = AssetImporter.GetAtPath(path) as TextureImporter;
            if (importer == null)
            {
                throw new InvalidOperationException("RadTex: " + path + " is missing: copy the whole folder");
            }
            return importer;
        }

        // As large as it is. Colours are sRGB; a normal map is Unity's own kind, whose two channels the shader reads: y up.
        static void ImportImage(string path, OwnImage image)
        {
            TextureImporter importer = ImporterOf(path);
            bool normals = image.Texture == "@BUMP@";
            importer.textureType = normals ? TextureImporterType.NormalMap : TextureImporterType.Default;
            importer.sRGBTexture = image.Texture == "@BASE@";
            importer.alphaSource = TextureImporterAlphaSource.None;
            importer.npotScale = TextureImporterNPOTScale.None;
            importer.mipmapEnabled = true;
            importer.wrapMode = image.Wrap;
            importer.filterMode = FilterMode.Trilinear;
            importer.anisoLevel = 8;
            importer.textureCompression = TextureImporterCompression.CompressedHQ;
            importer.maxTextureSize = 16384;
            importer.SaveAndReimport();
        }

        static void ImportExr(string path)
        {
            TextureImporter importer = ImporterOf(path);
            importer.textureType = TextureImporterType.Default;
            importer.sRGBTexture = false;
            importer.alphaSource = TextureImporterAlphaSource.FromInput;
            importer.alphaIsTransparency = false;
            importer.npotScale = TextureImporterNPOTScale.None;
            importer.mipmapEnabled = false;
            importer.wrapMode = TextureWrapMode.Clamp;
            importer.filterMode = FilterMode.Bilinear;
            importer.textureCompression = TextureImporterCompression.Uncompressed;
            importer.maxTextureSize = 16384;
            TextureImporterPlatformSettings settings = importer.GetDefaultPlatformTextureSettings();
            settings.format = TextureImporterFormat.RGBAHalf;
            settings.maxTextureSize = 16384;
            importer.SetPlatformTextureSettings(settings);
            importer.SaveAndReimport();
        }

        static Dictionary<int, Material> MakeMaterials(string folder)
        {
            var shader = AssetDatabase.LoadAssetAtPath<Shader>(folder + "/" + Name + ".shader");
            var made = new Dictionary<int, Material>();
            foreach (int number in Materials.Values)
            {
                string path = folder + "/" + Name + (number == 0 ? "" : "-" + number) + ".mat";
                var material = AssetDatabase.LoadAssetAtPath<Material>(path);
                if (material == null)
                {
                    material = new Material(shader);
                    AssetDatabase.CreateAsset(material, path);
                }
                material.shader = shader;
                material.enableInstancing = true;
                if (number != 0)
                {
                    material.EnableKeyword("RADTEX_MATERIAL_" + number);
                }
                for (int k = 0; k < Textures.GetLength(0); k++)
                {
                    material.SetTexture(Textures[k, 0], Imported(folder + "/" + Textures[k, 1]));
                }
                foreach (OwnImage image in Images)
                {
                    if (image.Material == number)
                    {
                        material.SetTexture(image.Texture, Imported(folder + "/" + image.File));
                    }
                }
                EditorUtility.SetDirty(material);
                made[number] = material;
            }
            return made;
        }

        static Texture Imported(string file)
        {
            var texture = AssetDatabase.LoadAssetAtPath<Texture>(file);
            if (texture == null)
            {
                throw new InvalidOperationException("RadTex: Unity did not import " + file);
            }
            return texture;
        }

        static void SavePrefab(string folder, Dictionary<int, Material> materials)
        {
            var model = AssetDatabase.LoadAssetAtPath<GameObject>(folder + "/@MESH@");
            if (model == null)
            {
                throw new InvalidOperationException(
                    "RadTex: Unity did not import @MESH@: add the package com.unity.cloud.gltfast in the Package Manager");
            }
            var instance = (GameObject)PrefabUtility.InstantiatePrefab(model);
            try
            {
                foreach (MeshRenderer renderer in instance.GetComponentsInChildren<MeshRenderer>(true))
                {
                    Material[] given = renderer.sharedMaterials;
                    for (int k = 0; k < given.Length; k++)
                    {
                        int number;
                        string name = given[k] == null ? "" : given[k].name;
                        given[k] = materials[Materials.TryGetValue(name, out number) ? number : @FIRST_NUMBER@];
                    }
                    renderer.sharedMaterials = given;
                    renderer.lightProbeUsage = LightProbeUsage.Off;
                    renderer.reflectionProbeUsage = ReflectionProbeUsage.Off;
                }
                PrefabUtility.SaveAsPrefabAsset(instance, folder + "/" + Name + ".prefab");
            }
            finally
            {
                UnityEngine.Object.DestroyImmediate(instance);
            }
        }
    }

    // An image that a material is shown by: the material's number, the texture's name in the shader, and the file.
    struct OwnImage
    {
        public readonly int Material;
        public readonly string Texture, File;
        public readonly TextureWrapMode Wrap;

        public OwnImage(int material, string texture, string file, TextureWrapMode wrap)
        {
            Material = material;
            Texture = texture;
            File = file;
            Wrap = wrap;
        }
    }

    // Reads the DDS files of this export to the last bit: their mip levels, arrays and formats are as the shader wants
    // them. Unity's own importer takes no arrays.
    [ScriptedImporter(1, new string[0], new[] { "dds" })]
    public sealed class DdsImporter : ScriptedImporter
    {
        const int Header = 148;

        static readonly Dictionary<int, GraphicsFormat> Formats = new Dictionary<int, GraphicsFormat>
        {
            { 10, GraphicsFormat.R16G16B16A16_SFloat },
            { 28, GraphicsFormat.R8G8B8A8_UNorm },
            { 77, GraphicsFormat.RGBA_DXT5_UNorm },
            { 78, GraphicsFormat.RGBA_DXT5_SRGB },
            { 80, GraphicsFormat.R_BC4_UNorm },
            { 83, GraphicsFormat.RG_BC5_UNorm },
            { 95, GraphicsFormat.RGB_BC6H_UFloat },
            { 98, GraphicsFormat.RGBA_BC7_UNorm },
            { 99, GraphicsFormat.RGBA_BC7_SRGB },
        };

        public override void OnImportAsset(AssetImportContext context)
        {
            Texture texture = Read(File.ReadAllBytes(context.assetPath), context.assetPath);
            texture.name = Path.GetFileNameWithoutExtension(context.assetPath);
            context.AddObjectToAsset("texture", texture);
            context.SetMainObject(texture);
        }

        public static Texture Read(byte[] file, string name)
        {
            GraphicsFormat format;
            bool ours = file.Length > Header && BitConverter.ToUInt32(file, 0) == 0x20534444  // "DDS "
                && BitConverter.ToUInt32(file, 84) == 0x30315844;  // "DX10"
            if (!ours || !Formats.TryGetValue(BitConverter.ToInt32(file, 128), out format))
            {
                throw new InvalidDataException("RadTex: " + name + " is no DDS that RadTex writes: export it again");
            }
            int height = BitConverter.ToInt32(file, 12), width = BitConverter.ToInt32(file, 16);
            int levels = Math.Max(BitConverter.ToInt32(file, 28), 1), layers = BitConverter.ToInt32(file, 140);
            if (width < 1 || width > 16384 || height < 1 || height > 16384 || layers < 1 || layers > 2048
                || levels > 15 || Math.Max(width, height) >> (levels - 1) == 0)
            {
                throw new InvalidDataException("RadTex: " + name + " has impossible sizes: export it again");
            }
            long whole = 0;
            for (int level = 0; level < levels; level++)
            {
                whole += Bytes(format, Math.Max(width >> level, 1), Math.Max(height >> level, 1));
            }
            if (Header + whole * layers > file.Length)
            {
                throw new InvalidDataException("RadTex: " + name + " is cut short: export it again");
            }
            TextureCreationFlags flags = levels > 1 ? TextureCreationFlags.MipChain : TextureCreationFlags.None;
            Texture2D single = layers > 1 ? null : new Texture2D(width, height, format, levels, flags);
            Texture2DArray array = layers > 1 ? new Texture2DArray(width, height, layers, format, flags, levels) : null;
            int place = Header;
            for (int layer = 0; layer < layers; layer++)
            {
                for (int level = 0; level < levels; level++)
                {
                    var data = new byte[Bytes(format, Math.Max(width >> level, 1), Math.Max(height >> level, 1))];
                    Buffer.BlockCopy(file, place, data, 0, data.Length);
                    place += data.Length;
                    if (array == null)
                    {
                        single.SetPixelData(data, level);
                    }
                    else
                    {
                        array.SetPixelData(data, level, layer);
                    }
                }
            }
            Texture texture = single;
            if (array == null)
            {
                single.Apply(false, true);
            }
            else
            {
                array.Apply(false, true);
                texture = array;
            }
            texture.wrapMode = TextureWrapMode.Clamp;
            texture.filterMode = FilterMode.Trilinear;
            texture.anisoLevel = 1;
            return texture;
        }

        static long Bytes(GraphicsFormat format, int width, int height)
        {
            switch (format)
            {
                case GraphicsFormat.R16G16B16A16_SFloat:
                    return 8L * width * height;
                case GraphicsFormat.R8G8B8A8_UNorm:
                    return 4L * width * height;
                default:
                    long block = format == GraphicsFormat.R_BC4_UNorm ? 8 : 16;
                    return block * ((width + 3) / 4) * ((height + 3) / 4);
            }
        }
    }
}
