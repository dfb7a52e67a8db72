// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// ReadDds.exe FILE BYTES: reads a DDS as the exported script does, says what it made of it, and writes what it gave.
// ReadDds.exe FILE: says which of the names in a file, one a line in Base64 of UTF-8, the script would open.

using System;
using System.IO;
using System.Text;
using RadTexExports._Made_up_radiance;

public static class ReadDds
{
    public static int Main(string[] arguments)
    {
        if (arguments.Length == 1)
        {
            foreach (string line in File.ReadAllLines(arguments[0]))
            {
                string name = Encoding.UTF8.GetString(Convert.FromBase64String(line));
                Console.WriteLine(SetUp.IsPlain(name, ".dds", ".exr"));
            }
            return 0;
        }
        try
        {
            UnityEngine.Texture texture = DdsImporter.Read(File.ReadAllBytes(arguments[0]), "the file");
            Console.WriteLine(string.Join("\n", texture.Made));
            File.WriteAllBytes(arguments[1], texture.Given.ToArray());
            return 0;
        }
        catch (InvalidDataException error)
        {
            Console.Error.WriteLine(error.Message);
            return 1;
        }
    }
}
