# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends EditorScenePostImportPlugin
## Keeps baked meshes as they are in the file: the editor makes simpler levels of detail of meshes that are not finished,
## whose triangles would look up elsewhere.

const Importer := preload("importer.gd")


func _pre_process(scene: Node) -> void:
	var found := false
	for node: ImporterMeshInstance3D in scene.find_children("*", "ImporterMeshInstance3D", true, false):
		if node.mesh and node.mesh.has_meta(Importer.BAKED):
			node.mesh.get_mesh()
			found = true
	if found and get_option_value(&"nodes/root_scale") != 1.0:
		push_error("RadTex: a baked mesh is imported with Root Scale %s, and looks things up at wrong places: set it back to 1 in the Import dock, and scale the node."
			% get_option_value(&"nodes/root_scale"))


## Materials: Extract exchanges a mesh's materials, after which it is unfinished again: what was made then is taken away.
func _post_process(scene: Node) -> void:
	for node: MeshInstance3D in scene.find_children("*", "MeshInstance3D", true, false):
		if node.mesh is ArrayMesh and node.mesh.has_meta(Importer.BAKED):
			_drop_lods(node.mesh)


static func _drop_lods(mesh: ArrayMesh) -> void:
	var surfaces: Array = mesh.get(&"_surfaces")  # as scenes store them: to the last bit
	var found := false
	for surface: Dictionary in surfaces:
		found = surface.erase("lods") or found
	if found:
		mesh.set(&"_surfaces", surfaces)
