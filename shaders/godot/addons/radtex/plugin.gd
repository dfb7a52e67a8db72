# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends EditorPlugin
## Lets Godot's editor import what RadTex exports.

const Importer := preload("importer.gd")
const PostImport := preload("post_import.gd")
const Materials := preload("materials.gd")
const Export := preload("export.gd")
const AUTOLOAD := "RadTex"  ## Registers the same importer in the game, for .glb files that it loads itself.

var _importer: Importer
var _post_import: PostImport
var _export: Export


func _enable_plugin() -> void:
	var folder: String = get_script().resource_path.get_base_dir()
	add_autoload_singleton(AUTOLOAD, folder.path_join("runtime.gd"))


func _disable_plugin() -> void:
	remove_autoload_singleton(AUTOLOAD)


func _enter_tree() -> void:
	for setting: String in Materials.DEFAULTS:
		if not ProjectSettings.has_setting(setting):
			ProjectSettings.set_setting(setting, Materials.DEFAULTS[setting])
		ProjectSettings.set_initial_value(setting, Materials.DEFAULTS[setting])
		ProjectSettings.set_as_basic(setting, true)
	_importer = Importer.new()
	GLTFDocument.register_gltf_document_extension(_importer, true)
	_post_import = PostImport.new()
	add_scene_post_import_plugin(_post_import)
	_export = Export.new()
	add_export_plugin(_export)


func _exit_tree() -> void:
	remove_export_plugin(_export)
	remove_scene_post_import_plugin(_post_import)
	GLTFDocument.unregister_gltf_document_extension(_importer)
