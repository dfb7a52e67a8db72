# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends EditorScenePostImportPlugin
## Keeps baked meshes as they are in the file: the editor makes simpler levels of detail of meshes that are not finished,
## whose triangles would look up elsewhere.

const Importer := preload("importer.gd")

var _made := {}  # by a node's path: the materials that the file says, one for each surface of its mesh


func _pre_process(scene: Node) -> void:
	var found := false
	_made.clear()
	for node: ImporterMeshInstance3D in scene.find_children("*", "ImporterMeshInstance3D", true, false):
		if node.mesh and node.mesh.has_meta(Importer.BAKED):
			node.mesh.get_mesh()
			_made[scene.get_path_to(node)] = range(node.mesh.get_surface_count()).map(node.mesh.get_surface_material)
			found = true
	if found and get_option_value(&"nodes/root_scale") != 1.0:
		push_error("RadTex: a baked mesh is imported with Root Scale %s, and looks things up at wrong places: set it back to 1 in the Import dock, and scale the node."
			% get_option_value(&"nodes/root_scale"))


## Materials: Extract exchanges a mesh's materials, after which it is unfinished again: what was made then is taken away.
func _post_process(scene: Node) -> void:
	for node: MeshInstance3D in scene.find_children("*", "MeshInstance3D", true, false):
		if node.mesh is ArrayMesh and node.mesh.has_meta(Importer.BAKED):
			_drop_lods(node.mesh)
			var made: Array = _made.get(scene.get_path_to(node), [])
			for surface in mini(made.size(), node.mesh.get_surface_count()):
				_compare(node.mesh.surface_get_material(surface), made[surface])


## Godot goes on to use a material's file, which Materials: Extract once made, also after another export.
static func _compare(used: Material, made: Material) -> void:
	if made is ShaderMaterial and used != made and used.resource_path and not _is_as(used as ShaderMaterial, made):
		push_warning("RadTex: %s is the material of another export, or another addon, and looks things up at wrong places: delete this file and import the .glb again; what you had set in it is lost."
			% used.resource_path)


## Whether a material has the shader and the values of one that was just made; it may have further ones.
static func _is_as(used: ShaderMaterial, made: ShaderMaterial) -> bool:
	if not used or not used.shader or used.shader.code != made.shader.code:
		return false
	for uniform: Dictionary in made.shader.get_shader_uniform_list():
		var wanted: Variant = made.get_shader_parameter(uniform.name)
		var found: Variant = used.get_shader_parameter(uniform.name)
		if wanted is Texture:  # one that was read by the addon has no file
			if not found is Texture or (wanted.resource_path and found.resource_path != wanted.resource_path):
				return false
		elif wanted != null and not _is_near(found, wanted):
			return false
	return true


## Whether two values are the same but for what a text file rounds.
static func _is_near(found: Variant, wanted: Variant) -> bool:
	if typeof(found) != typeof(wanted):
		return false
	if wanted is PackedVector4Array:
		return found.size() == wanted.size() and range(wanted.size()).all(
			func(row: int) -> bool: return found[row].is_equal_approx(wanted[row]))
	if wanted is float:
		return is_equal_approx(found, wanted)
	return found.is_equal_approx(wanted) if wanted is Vector3 or wanted is Vector4 or wanted is Basis else found == wanted


static func _drop_lods(mesh: ArrayMesh) -> void:
	var surfaces: Array = mesh.get(&"_surfaces")  # as scenes store them: to the last bit
	var found := false
	for surface: Dictionary in surfaces:
		found = surface.erase("lods") or found
	if found:
		mesh.set(&"_surfaces", surfaces)
