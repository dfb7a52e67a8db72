# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends RefCounted
## Makes a bake's ShaderMaterial from the JSON of the extension, and that of mirrors that show it.

const Textures := preload("textures.gd")
const MIRROR := &"radtex_mirror"  ## Metadata of a bake's material: what mirror.gd needs.
const TO_BLENDER := Basis(Vector3(1, 0, 0), Vector3(0, 0, 1), Vector3(0, -1, 0))
const OF_IMAGES := "radtex_images"  ## A material's values, where it is shown by its own images.
const REPLACED := ["colour", "tint", "normal"]  ## The layers in whose place these are read.
const STEPS := 16  ## Of curves over the cosine to the normal: so many rows has each of a material's two lobes.
const STEADY := 0.16  ## By how much lobes widen where normals spread within a pixel: what moves does not shimmer.
## The project setting of cheaper lookups, whose noise temporal antialiasing averages away. What was imported before is as it was.
const TEMPORAL := "radtex/lookups/temporal"
## The project setting of tint, exposure and opacity of each node. What was imported before is as it was.
const OBJECT_VALUES := "radtex/materials/object_values"
## The project setting by which opaque bakes of light are drawn among what is transparent, so that they can fade.
const FADING := "radtex/materials/fading"
const DEFAULTS := {TEMPORAL: false, OBJECT_VALUES: true, FADING: false}
const TRANSPARENT := "RGBA16F"  ## The only format of light that has alpha.


## A shader and the values of its uniforms, as they are put together.
class Recipe:
	var textures: Textures
	var surface: String  ## The name of the include that has vertex() and fragment().
	var modes := PackedStringArray()
	var lookups := PackedStringArray()
	var defines := {}
	var values := {}
	var complete := true  ## False after an error: a texture cannot be loaded.

	func _init(its_surface: String, its_textures: Textures) -> void:
		surface = its_surface
		textures = its_textures

	func put(uniform: String, entry: Dictionary) -> void:
		values[uniform] = textures.loaded(entry)
		complete = complete and values[uniform] != null

	func blend(mode: String) -> void:
		defines["BLENDED"] = 1
		modes.append_array(["blend_premul_alpha", mode])

	func material() -> ShaderMaterial:
		if not complete:
			return null
		var made := ShaderMaterial.new()
		made.shader = Shader.new()
		made.shader.code = code()
		for uniform: String in values:
			made.set_shader_parameter(uniform, values[uniform])
		return made

	func code() -> String:
		var folder := (Textures as GDScript).resource_path.get_base_dir()
		var lines := PackedStringArray(["shader_type spatial;", "render_mode %s;" % ", ".join(modes)])
		for name: String in defines:
			lines.append("#define %s %s" % [name, defines[name]])
		for name in lookups:
			lines.append('#include "%s/lookups/%s.gdshaderinc"' % [folder, name])
		lines.append('#include "%s/surfaces/%s.gdshaderinc"' % [folder, surface])
		return "\n".join(lines) + "\n"


## The material with that number among the bake's; null, after an error, if a texture cannot be loaded.
static func made(facts: Dictionary, number: int, textures: Textures) -> ShaderMaterial:
	var recipe := _recipe(facts, number, textures)
	var material := recipe.material()
	if material and facts.has("mirror"):
		var ball := _mirror(facts, textures).material()
		if not ball:
			return null
		var path: Dictionary = facts.mirror
		material.set_meta(MIRROR, {
			"material": ball,
			"middle": Vector3(path.middle[0], path.middle[1], path.middle[2]),
			"across": Vector2(path.across[0], path.across[1]),
			"radius": path.radius,
			"baked": Transform3D(TO_BLENDER),
		})
	return material


## Tell a material how its mesh stood in the bake's scene, in glTF's axes.
static func set_baked(material: ShaderMaterial, world: Transform3D) -> void:
	var baked := Transform3D(TO_BLENDER) * world
	if material.get_shader_parameter("baked") != null:
		material.set_shader_parameter("baked", baked.basis)
		material.set_shader_parameter("baked_place", baked.origin)
	if material.has_meta(MIRROR):
		material.get_meta(MIRROR).baked = baked


## One of the project settings in DEFAULTS.
static func setting(name: String) -> bool:
	return ProjectSettings.get_setting(name, DEFAULTS[name])


## Whether a material shows its own images, which `set_images` gives it.
static func is_of_images(material: ShaderMaterial) -> bool:
	return material.shader.code.contains("#define RADTEX_IMAGES")


## Give a material its own images, as glTF has them in `old`.
static func set_images(material: ShaderMaterial, old: BaseMaterial3D) -> void:
	material.set_shader_parameter("radtex_base_map", old.albedo_texture)
	material.set_shader_parameter("radtex_metal_map", old.metallic_texture)
	material.set_shader_parameter("radtex_bump_map", old.normal_texture)


static func _recipe(facts: Dictionary, number: int, textures: Textures) -> Recipe:
	var recipe := _recipe_of_kind(facts, number, textures)
	if setting(OBJECT_VALUES):
		recipe.defines["OBJECT_VALUES"] = 1
	return recipe


static func _recipe_of_kind(facts: Dictionary, number: int, textures: Textures) -> Recipe:
	match facts.bake.kind:
		"shadow":
			return _shadow(facts, textures)
		"ao":
			return _ambient(facts, textures)
		"transfer":
			return _transfer(facts, textures)
	return _layered(facts, number, textures) if facts.has("shader") else _buckets(facts, textures)


static func _buckets(facts: Dictionary, textures: Textures) -> Recipe:
	var recipe := Recipe.new("buckets", textures)
	var hull: bool = facts.bake.kind == "proxy"  # is seen from outside only
	recipe.modes = ["unshaded", "cull_back" if hull else "cull_disabled"]
	var entry: Dictionary = facts.textures[facts.bake.kind]
	_put_matrix(recipe, entry, facts.bake)
	if hull:
		recipe.defines["HULL"] = 1
	if entry.format == TRANSPARENT or setting(FADING):
		recipe.blend("depth_draw_always")
	return recipe


static func _layered(facts: Dictionary, number: int, textures: Textures) -> Recipe:
	var recipe := Recipe.new("layered", textures)
	recipe.modes = ["unshaded", "cull_back" if facts.get("culled", false) else "cull_disabled"]
	var own: Dictionary = facts.shader.materials[number]
	var of_images := own.has(OF_IMAGES)
	_put_layers(recipe, facts, REPLACED if of_images else [])
	recipe.defines["RADTEX_STEADY"] = STEADY
	if setting(TEMPORAL):
		recipe.defines["RADTEX_TEMPORAL"] = 1
	if _is_of_one_lobe(own):
		recipe.defines["RADTEX_SECOND_LOBE"] = 0
	if of_images:
		recipe.defines["RADTEX_IMAGES"] = 1
	if recipe.defines.has("RADTEX_THROUGH"):
		recipe.lookups.append("radtex_layered_through")
	if recipe.defines.has("RADTEX_ALPHA"):
		recipe.blend("depth_prepass_alpha")
	elif setting(FADING):
		recipe.blend("depth_draw_always")  # the other one is wrong in Mobile
	for uniform: String in own:
		recipe.values[uniform] = _vectors(own[uniform])
	recipe.values["baked"] = TO_BLENDER
	recipe.values["baked_place"] = Vector3.ZERO
	return recipe


static func _ambient(facts: Dictionary, textures: Textures) -> Recipe:
	var recipe := Recipe.new("ambient", textures)
	recipe.modes = ["cull_disabled"]
	_put_matrix(recipe, facts.textures.ao, facts.bake)
	return recipe


static func _shadow(facts: Dictionary, textures: Textures) -> Recipe:
	var recipe := Recipe.new("shadow", textures)
	recipe.modes = ["cull_disabled", "shadows_disabled"]
	recipe.lookups = ["radtex", "radtex_shadow"]
	var entry: Dictionary = facts.textures.shadow
	if entry.layers > 1:
		recipe.defines["RADTEX_SHADOW_LAYERS"] = 1
	recipe.values = {"texels": _pair(entry.texels), "cells": int(facts.bake.bucket)}
	recipe.put("bits", entry)
	return recipe


static func _transfer(facts: Dictionary, textures: Textures) -> Recipe:
	var recipe := Recipe.new("transfer", textures)
	recipe.modes = ["cull_disabled", "shadows_disabled", "ambient_light_disabled"]
	var entry: Dictionary = facts.textures.transfer
	_put_matrix(recipe, entry, facts.bake)
	recipe.defines.erase("RADTEX_HARDWARE_LINEAR")
	recipe.lookups.append("radtex_transfer")
	recipe.values["texels"] = _pair(facts.bake.texels)
	var views: int = facts.bake.transfer.get("views", 1)
	if views > 1:
		recipe.defines["VIEWS"] = views
	if entry.format == TRANSPARENT:
		recipe.blend("depth_draw_always")
	return recipe


## A chrome ball that mirrors the bake.
static func _mirror(facts: Dictionary, textures: Textures) -> Recipe:
	var recipe := Recipe.new("mirror_ball", textures)
	recipe.modes = ["unshaded", "cull_back", "shadows_disabled"]
	var clear: bool
	if facts.has("shader"):
		_put_layers(recipe, facts)
		_put_materials(recipe, facts.shader.materials)
		clear = recipe.defines.has("RADTEX_ALPHA")
		recipe.defines["LAYERED"] = 1
		recipe.defines["RADTEX_NO_DERIVATIVES"] = 1
		if recipe.defines.has("RADTEX_MIRRORS") or recipe.defines.has("RADTEX_THROUGH"):
			recipe.defines["SURROUNDED"] = 1
	else:
		var entry: Dictionary = facts.textures[facts.bake.kind]
		_put_matrix(recipe, entry, facts.bake)
		clear = entry.format == TRANSPARENT
	recipe.lookups.append("radtex_trace")
	recipe.defines["SURFACES"] = 4 if clear else 1
	recipe.defines["CULLED"] = "true" if facts.get("culled", false) else "false"
	var sky: Array = facts.mirror.sky
	recipe.values["sky"] = Vector3(sky[0], sky[1], sky[2])
	recipe.values["nodes"] = int(facts.mirror.nodes)
	recipe.put("tree", facts.mirror)
	return recipe


## What surfaces/matrix.gdshaderinc takes: a bucket matrix, or its slices.
static func _put_matrix(recipe: Recipe, entry: Dictionary, bake: Dictionary) -> void:
	recipe.lookups.append("radtex")
	recipe.values["cells"] = int(bake.bucket)
	if entry.arrangement == "slices":
		recipe.defines["SLICES"] = 1
		recipe.put("slices", entry)
		return
	recipe.values["texels"] = _pair(entry.texels)
	if entry.layers > 1:
		recipe.defines["RADTEX_PAGES"] = 1
		recipe.values["pages"] = Vector4i(entry.pages[0], entry.pages[1], entry.page_texels[0], entry.page_texels[1])
	else:
		recipe.defines["RADTEX_HARDWARE_LINEAR"] = 1
	if entry.levels > 1:
		recipe.defines["LEVELS"] = 1
		recipe.values["levels"] = int(entry.levels)
	recipe.put("atlas", entry)


## What radtex_layered.gdshaderinc takes, but for the values of single materials, and without some layers.
static func _put_layers(recipe: Recipe, facts: Dictionary, without: Array = []) -> void:
	recipe.lookups.append("radtex_layered")
	for name: String in facts.shader.defines:
		recipe.defines[name] = int(facts.shader.defines[name])
	for uniform: String in facts.shader["values"]:
		recipe.values[uniform] = _vectors(facts.shader["values"][uniform])
	for layer: String in facts.shader.layers:
		if layer in without:
			continue
		var entry: Dictionary = facts.textures[layer]
		if entry.format.ends_with("_SRGB"):  # Godot decodes it of no file that it did not import
			recipe.defines["RADTEX_SRGB"] = 1
		recipe.put("radtex_%s_map" % layer, entry)


## Whether a material has no second lobe, though others of its bake may have one.
static func _is_of_one_lobe(material: Dictionary) -> bool:
	var second: Array = material.get("radtex_lobes", []).slice(STEPS)
	return second.size() > 0 and second.all(func(row: Array) -> bool: return row.slice(0, 3).max() == 0)


## The values of all materials, one behind the other.
static func _put_materials(recipe: Recipe, materials: Array) -> void:
	recipe.defines["RADTEX_MATERIALS"] = materials.size()
	for uniform: String in materials[0]:
		var rows := []
		for each: Dictionary in materials:
			rows.append_array(each[uniform])
		recipe.values[uniform] = _vectors(rows)


static func _pair(numbers: Array) -> Vector2i:
	return Vector2i(numbers[0], numbers[1])


## Four numbers, or rows of four, as a uniform's value.
static func _vectors(numbers: Array) -> Variant:
	if numbers[0] is not Array:
		return Vector4(numbers[0], numbers[1], numbers[2], numbers[3])
	var rows := PackedVector4Array()
	for row: Array in numbers:
		rows.append(_vectors(row))
	return rows
