# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends RefCounted
## Whether the JSON of the extension is such as RadTex writes. Anybody may have made it: before it is checked here, nothing of
## it is opened, or becomes part of a shader.
##
## The rules are those of docs/format.md, "What a reader refuses".

const VERSION := 1.0  ## Of the extension's JSON.
const CONTAINERS := ["ktx2", "dds", "exr"]
const KINDS := ["radiance", "incident", "reflection", "proxy", "shadow", "ao", "transfer"]
const SEEN := ["radiance", "incident", "reflection", "proxy"]  ## Those that the layered layout can hold.
const LAYOUTS := ["buckets", "sphere", "layered"]
const FORMATS := ["RGBA16F", "RGB9E5", "BC6H", "BC3", "BC3_SRGB", "BC4", "BC5", "BC7", "BC7_SRGB", "RGBA8", "RGBA32F", "R32UI",
	"RG32UI"]
const ARRANGEMENTS := ["matrix", "slices", "image", "words", "tree"]
const LAYERS := ["colour", "irradiance", "tint", "normal", "width", "alpha", "tangent", "own", "rest", "world", "plane",
	"things", "distances", "exit_direction", "exit_place", "field",
	"through_colour", "through_rest"]
## What may be defined in a shader of the layered layout, and from which whole number to which.
const DEFINES := {
	"RADTEX_TINT": [1, 1], "RADTEX_NORMAL": [1, 1], "RADTEX_WIDTH": [1, 1], "RADTEX_ALPHA": [1, 1],
	"RADTEX_TANGENT": [1, 1], "RADTEX_BEHIND": [1, 1],
	"RADTEX_PLANE": [1, 1], "RADTEX_THINGS": [1, 1], "RADTEX_MIRRORS": [1, 1], "RADTEX_GLOSSES": [1, 1], "RADTEX_SHAPES": [1, 1], "RADTEX_THROUGH": [1, 1], "RADTEX_FIELD": [1, 1],
	"RADTEX_SRGB": [1, 1], "RADTEX_LAMPS": [0, 8], "RADTEX_SHELL": [2, 8], "RADTEX_BOXES": [1, 8], "RADTEX_STEPS": [0, 2], "RADTEX_SECOND_LOBE": [0, 1],
	"RADTEX_OWN_TAPS": [0, 4], "RADTEX_REST_TAPS": [3, 4], "RADTEX_EXIT_TAPS": [4, 16],
	"RADTEX_OWN_CELLS": [1, 64], "RADTEX_REST_CELLS": [1, 64], "RADTEX_EXIT_CELLS": [1, 64], "RADTEX_THROUGH_CELLS": [1, 64],
}
## Its uniforms of one vector, but for those that each layer has; and its arrays, with their lengths, for each material.
const VECTORS := ["radtex_middle", "radtex_own_tile", "radtex_rest_tile", "radtex_exit_tile", "radtex_through_rest_tile",
	"radtex_world_levels", "radtex_plane_levels", "radtex_things_levels", "radtex_distances_size", "radtex_plane_place",
	"radtex_plane_eye", "radtex_things_eye", "radtex_field_low", "radtex_field_size", "radtex_field_glass", "radtex_field_tint"]
## Of as many vectors as there are lamps, planes or boxes.
const COUNTED := {"radtex_lamp_place": "RADTEX_LAMPS", "radtex_lamp_light": "RADTEX_LAMPS", "radtex_lamp_across": "RADTEX_LAMPS",
	"radtex_lamp_up": "RADTEX_LAMPS", "radtex_shell": "RADTEX_SHELL", "radtex_box_low": "RADTEX_BOXES", "radtex_box_high": "RADTEX_BOXES"}
const OF_IMAGES := "radtex_images"  ## Of materials that are shown by their own images.
const OF_MATERIAL := {"radtex_material": 16, "radtex_lobes": 32, "radtex_gloss": 1, "radtex_brush": 1, OF_IMAGES: 3}
const MOST_PIXELS := 16384
const MOST_LAYERS := 2048
const MOST_TEXELS := 1 << 24
const MOST_VIEWS := 16
const MOST_MATERIALS := 1024
const MOST_TEXTURES := 64
const MOST_CHARACTERS := 255
const DEVICES := ["con", "prn", "aux", "nul"]  ## And com0 to lpt9: files that Windows has in every folder.

var problem := ""  ## The first thing that is wrong, as the end of a sentence; empty if nothing is.


func _init(facts: Dictionary) -> void:
	_expect(_is_whole(facts.get("version"), 1, 1), "version", facts.get("version"), "1")
	_expect(is_plain_stem(facts.get("name")), "name", facts.get("name"), "what its files are called")
	_check_file("mesh", facts.get("mesh"), "glb")
	_check_file("flat", facts.get("flat"), "png")
	var scale: Variant = facts.get("flat_scale")
	_expect(_is_number(scale) and scale > 0.0, "flat_scale", scale, "a number above 0")
	for key: String in ["culled", "images"]:
		var flag: Variant = facts.get(key, false)
		_expect(flag is bool, key, flag, "true or false")
	var textures := _inner(facts, "textures")
	_check_bake(_inner(facts, "bake"), textures, facts.has("shader"))
	_expect(textures.size() in range(1, MOST_TEXTURES + 1), "textures", textures.size(), "1 to %d" % MOST_TEXTURES)
	for name: String in textures:
		_expect(_is_word(name), "textures", name, "names of layers")
		_check_texture("textures." + name, _inner(textures, name))
	if facts.has("shader"):
		_check_shader(_inner(facts, "shader"), textures)
		var number: Variant = facts.get("material", 0)
		var last: int = facts.shader.materials.size() - 1 if problem.is_empty() else 0
		_expect(_is_whole(number, 0, last), "material", number, "a whole number from 0 to %d" % last)
	if facts.has("mirror"):
		_check_mirror(_inner(facts, "mirror"))


## Whether it is the name of a file beside the .glb, and ends in .ending.
static func is_plain_file(name: Variant, ending: String) -> bool:
	return name is String and name.length() <= MOST_CHARACTERS and name.ends_with("." + ending) and is_plain_stem(name)


## Whether files may have names that begin so: it leads nowhere, and is one line of text.
static func is_plain_stem(name: Variant) -> bool:
	if name is not String or name.strip_edges().is_empty() or name[0] in [".", " "]:
		return false
	for place: int in name.length():
		var code: int = name.unicode_at(place)
		if code < 32 or code in range(127, 160) or code in [0x2028, 0x2029] or name[place] in '<>:"/\\|?*':
			return false
	var device: String = name.get_slice(".", 0).strip_edges().to_lower()
	return not (device in DEVICES or (device.length() == 4 and device.left(3) in ["com", "lpt"] and device[3].is_valid_int()))


## The first thing that is wrong is what is told.
func _expect(fine: bool, key: String, value: Variant, expected: String) -> void:
	if not fine and problem.is_empty():
		problem = "%s is %s, expected %s" % [JSON.stringify(key).left(80), JSON.stringify(value).left(80), expected]


## The object with that key; an empty one, after a problem, if it is none.
func _inner(outer: Dictionary, key: String) -> Dictionary:
	var value: Variant = outer.get(key)
	_expect(value is Dictionary, key, value, "an object")
	return value if value is Dictionary else {}


func _check_file(key: String, name: Variant, ending: String) -> void:
	_expect(is_plain_file(name, ending), key, name, "the name of a .%s beside the .glb" % ending)


func _check_choice(part: Dictionary, key: String, among: Array) -> void:
	var value: Variant = part.get(key)
	_expect(value is String and value in among, key, value, " or ".join(PackedStringArray(among)))


func _check_whole(part: Dictionary, key: String, least: int, most: int) -> void:
	_expect(_is_whole(part.get(key), least, most), key, part.get(key), "a whole number from %d to %d" % [least, most])


func _check_size(part: Dictionary, key: String, most: int) -> void:
	var value: Variant = part.get(key)
	var fine: bool = value is Array and value.size() == 2 and _is_whole(value[0], 1, most) and _is_whole(value[1], 1, most)
	_expect(fine, key, value, "two whole numbers from 1 to %d" % most)


func _check_numbers(part: Dictionary, key: String, count: int) -> void:
	_expect(_are_numbers(part.get(key), count), key, part.get(key), "%d numbers" % count)


func _check_bake(bake: Dictionary, textures: Dictionary, has_shader: bool) -> void:
	_check_choice(bake, "kind", KINDS)
	_check_choice(bake, "layout", LAYOUTS)
	_check_size(bake, "texels", MOST_TEXELS)
	_check_whole(bake, "bucket", 1, MOST_PIXELS)
	_expect(has_shader or bake.get("layout") != "layered", "shader", null, "an object")
	if has_shader:
		_check_choice(bake, "kind", SEEN)
	elif problem.is_empty():
		_expect(textures.has(bake.kind), "textures", textures.keys(), "one of its kind, %s" % bake.kind)
	if problem.is_empty() and bake.kind == "transfer":
		var transfer := _inner(bake, "transfer")
		if transfer.has("views"):
			_check_whole(transfer, "views", 2, MOST_VIEWS)


func _check_texture(key: String, entry: Dictionary) -> void:
	_check_choice(entry, "container", CONTAINERS)
	if problem:
		return
	_check_file(key + ".file", entry.get("file"), entry.container)
	if entry.has("uri") and problem.is_empty():
		_expect(entry.uri is String and entry.uri.uri_decode() == entry.file, key + ".uri", entry.uri, "its file")
	_check_choice(entry, "format", FORMATS)
	_check_choice(entry, "arrangement", ARRANGEMENTS)
	for part: String in ["size", "page_texels"]:
		_check_size(entry, part, MOST_PIXELS)
	for part: String in ["texels", "stored"]:
		_check_size(entry, part, MOST_TEXELS)
	_check_size(entry, "pages", MOST_LAYERS)
	_check_whole(entry, "layers", 1, MOST_LAYERS)
	if entry.has("range"):
		_check_numbers(entry, "range", 2)
	if problem.is_empty():
		_check_sizes(key, entry)


## Whether the sizes of a texture, which are numbers, agree.
func _check_sizes(key: String, entry: Dictionary) -> void:
	_check_whole(entry, "levels", 1, most_levels(entry.size))
	for side in 2:
		var paged: bool = entry.pages[side] * entry.page_texels[side] == entry.stored[side]
		_expect(paged and entry.texels[side] <= entry.stored[side], key, entry.stored, "pages that hold its texels")
	var of_pages: bool = entry.arrangement not in ["slices", "words"]
	_expect(not of_pages or entry.layers == entry.pages[0] * entry.pages[1], key, entry.layers, "a layer for each page")


## How many mip levels an image can have.
static func most_levels(size: Array) -> int:
	var levels := 1
	while maxi(size[0], size[1]) >> levels > 0:
		levels += 1
	return levels


func _check_shader(shader: Dictionary, textures: Dictionary) -> void:
	var defines := _inner(shader, "defines")
	for name: String in defines:
		var bounds: Array = DEFINES.get(name, [0, -1])
		_expect(_is_whole(defines[name], bounds[0], bounds[1]), "defines." + name, defines[name], "a number that shaders know")
	var layers: Variant = shader.get("layers")
	_expect(layers is Array and layers.size() <= LAYERS.size(), "layers", layers, "names of layers")
	if problem.is_empty():
		for layer: Variant in layers:
			_expect(layer is String and layer in LAYERS and textures.has(layer), "layers", layer, "layers that have a texture")
	var values := _inner(shader, "values")
	for name: String in values:
		var rows: int = int(defines.get(COUNTED.get(name, ""), 0)) if problem.is_empty() else 0
		_check_value(name, values[name], rows, name in COUNTED or name in VECTORS or _is_range(name))
	var materials: Variant = shader.get("materials")
	var count: int = materials.size() if materials is Array else 0
	_expect(count in range(1, MOST_MATERIALS + 1), "materials", count, "1 to %d" % MOST_MATERIALS)
	for number in count if problem.is_empty() else 0:
		_expect(materials[number] is Dictionary, "materials", materials[number], "objects")
		if problem:
			return
		for name: String in materials[number]:
			_check_value(name, materials[number][name], OF_MATERIAL.get(name, 0), name in OF_MATERIAL)
		var names: Array = materials[0].keys().filter(func(name: String) -> bool: return name != OF_IMAGES)
		_expect(materials[number].has_all(names), "materials", number, "the same values of each")
		var coloured: bool = materials[number].has(OF_IMAGES) or textures.has("colour")
		_expect(coloured, "materials", number, "%s, or a texture of colours" % OF_IMAGES)


## Check a uniform's value, four numbers, or so many `rows` of four.
func _check_value(name: String, value: Variant, rows: int, known: bool) -> void:
	var fine: bool = known and value is Array
	if fine and rows:
		fine = value.size() == rows and value.all(func(row: Variant) -> bool: return _are_numbers(row, 4))
	elif fine:
		fine = _are_numbers(value, 4)
	_expect(fine, name, value, "the value of a uniform that shaders know")


## Whether it is the range of a layer's texture.
static func _is_range(name: String) -> bool:
	return name.begins_with("radtex_") and name.ends_with("_range") and name.trim_prefix("radtex_").trim_suffix("_range") in LAYERS


func _check_mirror(mirror: Dictionary) -> void:
	_check_texture("mirror", mirror)
	_check_whole(mirror, "nodes", 1, MOST_TEXELS)
	_check_whole(mirror, "triangles", 1, MOST_TEXELS)
	_check_numbers(mirror, "sky", 3)
	_check_numbers(mirror, "middle", 3)
	_check_numbers(mirror, "across", 2)
	var radius: Variant = mirror.get("radius")
	_expect(_is_number(radius) and radius > 0.0, "radius", radius, "a number above 0")
	if problem.is_empty():
		var texels: int = 2 * int(mirror.nodes) + 9 * int(mirror.triangles)
		_expect(texels <= int(mirror.size[0]) * int(mirror.size[1]), "mirror", texels, "as many pixels at least")


static func _is_number(value: Variant) -> bool:
	return (value is float or value is int) and is_finite(value)


static func _is_whole(value: Variant, least: int, most: int) -> bool:
	return _is_number(value) and value == floorf(value) and value >= least and value <= most


static func _are_numbers(value: Variant, count: int) -> bool:
	return value is Array and value.size() == count and value.all(_is_number)


## Whether it is a layer's name: letters, digits and _.
static func _is_word(name: String) -> bool:
	return name.is_valid_ascii_identifier() and name.length() <= 40
