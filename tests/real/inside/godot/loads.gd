# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D
## Loads a .glb of the folder files beside the scene as a game does while it runs.


func _ready() -> void:
	var folder := owner.scene_file_path.get_base_dir().path_join("files")
	for file in DirAccess.get_files_at(folder):
		if file.ends_with(".glb"):
			var document := GLTFDocument.new()
			var state := GLTFState.new()
			assert(document.append_from_file(folder.path_join(file), state) == OK)
			add_child(document.generate_scene(state))
