# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends GLTFDocumentExtension
## Reads the glTF extension RADTEX_radiance_texture: gives materials their shader and their textures.
##
## A material whose textures cannot be loaded keeps what glTF says of it: the flat lightmap.

const Checks := preload("checks.gd")
const Materials := preload("materials.gd")
const Textures := preload("textures.gd")
const EXTENSION := "RADTEX_radiance_texture"
const QUANTIZATION := "KHR_mesh_quantization"  ## Godot reads such vertices, but does not say so.
const MESHOPT := "EXT_meshopt_compression"
const BAKED := &"radtex_baked"  ## Metadata of a mesh with such materials.
const FOUND := &"radtex"  ## Additional data of a GLTFState: new materials, by their numbers in the file.


func _import_preflight(state: GLTFState, extensions: PackedStringArray) -> Error:
	if EXTENSION not in extensions:
		return ERR_SKIP
	if MESHOPT in extensions:
		push_error("%s is compressed by %s, which Godot does not read: export it for Godot, or with a plain mesh" % [
			state.filename, MESHOPT
		])
		return ERR_UNAVAILABLE
	var found := {}
	var textures := Textures.new(state.base_path)
	var listed := _materials_of(state.json)
	for number in listed.size():
		var facts := _facts_of(listed[number])
		if facts and _is_readable(facts):
			var material_number: int = facts.get("material", 0)
			var material := Materials.made(facts, material_number, textures)
			if material:
				material.resource_name = str(listed[number].get("name", ""))
				found[number] = material
	state.set_additional_data(FOUND, found)
	var plain := found.values().filter(func(made: ShaderMaterial) -> bool: return not Materials.is_of_images(made))
	if found and plain.size() == listed.size():
		_drop_flat_lightmaps(state.json)
	return OK


func _get_supported_extensions() -> PackedStringArray:
	return PackedStringArray([EXTENSION, QUANTIZATION])


func _import_post_parse(state: GLTFState) -> Error:
	var found: Dictionary = state.get_additional_data(FOUND)
	var by_old := {}
	for number: int in found:
		var old := state.materials[number]
		by_old[old] = found[number]
		if Materials.is_of_images(found[number]):
			Materials.set_images(found[number], old)
	for index in state.meshes.size():
		var holder: GLTFMesh = state.meshes[index]
		if _has_any(holder.mesh, by_old):
			holder.mesh = _exact(holder.mesh, by_old)
			_tell_place(holder.mesh, _world_of(state, index))
	return OK


## A file's materials; none where its JSON is not as glTF has it, which Godot itself tells of.
static func _materials_of(json: Dictionary) -> Array:
	var found: Variant = json.get("materials")
	return found if found is Array and found.all(func(each: Variant) -> bool: return each is Dictionary) else []


## The extension's JSON in that of a material, whose base colour texture has it; empty if there is none.
static func _facts_of(material: Dictionary) -> Dictionary:
	var found: Variant = material
	for key: String in ["pbrMetallicRoughness", "baseColorTexture", "extensions", EXTENSION]:
		found = found.get(key) if found is Dictionary else null
	return found if found is Dictionary else {}


static func _is_readable(facts: Dictionary) -> bool:
	var version: Variant = facts.get("version")
	if (version is float or version is int) and version != Checks.VERSION:
		push_error("RadTex: %s was exported in version %s of the format, this addon reads %s: update the addon in addons/radtex, or export with the RadTex that it came with."
			% [JSON.stringify(facts.get("name")).left(80), version, Checks.VERSION])
		return false
	var problem := Checks.new(facts).problem
	if problem:
		push_error("RadTex: a material is not as this addon knows it, %s: its flat lightmap is shown. Update addons/radtex to that of the export, or ask who made the .glb." % problem)
	return problem.is_empty()


## Nobody sees the flat lightmaps, which the editor would write into the project as pictures.
static func _drop_flat_lightmaps(json: Dictionary) -> void:
	for material: Dictionary in _materials_of(json):
		material.get("pbrMetallicRoughness", {}).erase("baseColorTexture")
	for list: String in ["images", "textures", "samplers"]:
		json.erase(list)


static func _has_any(mesh: ImporterMesh, by_old: Dictionary) -> bool:
	for surface in mesh.get_surface_count():
		if by_old.has(mesh.get_surface_material(surface)):
			return true
	return false


## The mesh with its new materials, its attributes not compressed.
static func _exact(mesh: ImporterMesh, by_old: Dictionary) -> ImporterMesh:
	var made := ImporterMesh.new()
	made.resource_name = mesh.resource_name
	for surface in mesh.get_surface_count():
		var old := mesh.get_surface_material(surface)
		var flags := mesh.get_surface_format(surface) & ~Mesh.ARRAY_FLAG_COMPRESS_ATTRIBUTES
		made.add_surface(mesh.get_surface_primitive_type(surface), mesh.get_surface_arrays(surface), [], {},
			by_old.get(old, old), mesh.get_surface_name(surface), flags)
	made.set_meta(BAKED, true)
	return made


## How the mesh stood when it was baked, by the first node that has it.
static func _world_of(state: GLTFState, mesh: int) -> Transform3D:
	for node: GLTFNode in state.nodes:
		if node.mesh == mesh:
			var world := node.xform
			var above := node.parent
			while above >= 0:
				world = state.nodes[above].xform * world
				above = state.nodes[above].parent
			return world
	return Transform3D.IDENTITY


static func _tell_place(mesh: ImporterMesh, world: Transform3D) -> void:
	for surface in mesh.get_surface_count():
		var material := mesh.get_surface_material(surface) as ShaderMaterial
		if material:
			Materials.set_baked(material, world)
