# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D
## Loads a .glb of the folder files as a game does while it runs.


func _ready() -> void:
	for file in DirAccess.get_files_at("res://files"):
		if file.ends_with(".glb"):
			var document := GLTFDocument.new()
			var state := GLTFState.new()
			assert(document.append_from_file("res://files".path_join(file), state) == OK)
			add_child(document.generate_scene(state))
