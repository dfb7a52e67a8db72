# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## Opens mesh.glb as a game does while it runs, and saves what it found as the main scene, with a camera.


func _initialize() -> void:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	assert(document.append_from_file("res://mesh.glb", state) == OK)
	var scene: Node3D = document.generate_scene(state)
	var main := Node3D.new()
	var camera := Camera3D.new()
	camera.name = "Camera"
	main.add_child(scene)
	main.add_child(camera)
	for node: Node in main.find_children("*", "", true, false):
		node.owner = main
	var packed := PackedScene.new()
	packed.pack(main)
	ResourceSaver.save(packed, "res://main.tscn")
	main.free()
	quit()
