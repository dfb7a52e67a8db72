# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## What the addon's check says of each extension object of made.json.


func _initialize() -> void:
	var check: GDScript = load("res://addons/radtex/checks.gd")
	var found := []
	for facts: Dictionary in JSON.parse_string(FileAccess.get_file_as_string("res://made.json")):
		found.append(check.new(facts).problem)
	FileAccess.open("res://found.json", FileAccess.WRITE).store_string(JSON.stringify(found))
	quit()
