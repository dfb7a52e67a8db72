# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends EditorExportPlugin
## Puts the addon into games that are exported with selected scenes only: Godot takes the files that scenes name, and
## knows neither what scripts preload nor what shaders include.

const OF_EDITOR: Array[String] = ["export.gd", "plugin.gd", "post_import.gd"]


func _get_name() -> String:
	return "RadTex"


func _export_begin(_features: PackedStringArray, _is_debug: bool, _path: String, _flags: int) -> void:
	# What is exported as a whole has the addon.
	if has_method("get_export_preset"):
		var preset: Object = call("get_export_preset")
		if preset and preset.has_method("get_export_filter") and preset.call("get_export_filter") == 0:
			return
	_add(get_script().resource_path.get_base_dir())


func _add(folder: String) -> void:
	for file: String in DirAccess.get_files_at(folder):
		if file.get_extension() in ["gd", "gdshader", "gdshaderinc", "tres"] and not file in OF_EDITOR:
			var path := folder.path_join(file)
			add_file(path, FileAccess.get_file_as_bytes(path), false)
	for inner: String in DirAccess.get_directories_at(folder):
		_add(folder.path_join(inner))
