# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## Says of each Ball.glb what was made of its mesh, and whether its material is the addon's.


func _initialize() -> void:
	for folder: String in ["kept", "extracted"]:
		tell(load("res://%s/Ball.glb" % folder).instantiate())
	quit()


func tell(scene: Node) -> void:
	for node: MeshInstance3D in scene.find_children("*", "MeshInstance3D", true, false):
		var levels := 0
		for surface: Dictionary in node.mesh.get("_surfaces"):
			levels += surface.get("lods", []).size()
		var shader: Shader = node.mesh.surface_get_material(0).get("shader")
		var ours := "radtex/surfaces" if shader and "radtex/surfaces" in shader.code else "another"
		print("%s: %d surface, %d levels of detail, of %s" % [node.name, node.mesh.get_surface_count(), levels, ours])
	scene.free()
