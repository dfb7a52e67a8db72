# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends RefCounted
## Loads the textures of an export, each once. Its entries were checked before, by checks.gd.
##
## What Godot loads by itself stays a file of the project that scenes refer to. Files that it refuses (KTX2 of arrays, sRGB,
## whole numbers, mip levels that end early) are read here, and become part of the imported scene. So are those beside which
## a file tells Godot to load another one: that other may be anything, a script too.

const Packed := preload("packed.gd")
const TextureArray := preload("texture_array.gd")
const REMEDY := "copy all files of the export's folder, side by side, and import the .glb again."
const AGAIN := "export it again, with --format ktx2-rgba16f if this file cannot be read."
const LEADING := [".import", ".remap"]  ## Files by whose names Godot loads something else.

var _folder: String
var _loaded := {}


func _init(folder: String) -> void:
	_folder = folder


## The texture of an entry of the export's JSON; null, after an error that says what to do, if it cannot be loaded.
func loaded(entry: Dictionary) -> Texture:
	var path := _folder.path_join(entry.file)
	if not _loaded.has(path):
		_loaded[path] = _load(path, entry)
	return _loaded[path]


static func _load(path: String, entry: Dictionary) -> Texture:
	if not FileAccess.file_exists(path):
		push_error("RadTex: %s is missing: %s" % [path, REMEDY])
		return null
	if entry.container == "exr":
		return _exr(path, entry)
	var file: Packed = Packed.dds(path) if entry.container == "dds" else Packed.ktx2(path)
	if not file.problem and not file.holds(entry):
		file.problem = "holds another texture than the .glb says"
	if file.problem:
		push_error("RadTex: %s %s: %s" % [path, file.problem, REMEDY])
		return null
	if _loads_by_itself(file, entry) and not _leads_elsewhere(path):
		return _by_godot(path, entry)
	var images := file.images()
	if images.is_empty():
		push_error("RadTex: %s %s: %s" % [path, file.problem, REMEDY])
		return null
	return _array(images) if _is_array(entry) else ImageTexture.create_from_image(images[0])


## Whether Godot's own loader reads it as the shader wants it.
static func _loads_by_itself(file: Packed, entry: Dictionary) -> bool:
	return file.is_dds or (file.is_loaded_by_godot and file.is_whole and not _is_array(entry))


## Whether beside a file lies one by which Godot loads another in its place.
static func _leads_elsewhere(path: String) -> bool:
	return LEADING.any(func(ending: String) -> bool: return FileAccess.file_exists(path + ending))


static func _by_godot(path: String, entry: Dictionary) -> Texture:
	var found := load(path) as Texture
	if not found:
		push_error("RadTex: Godot cannot load %s, which is %s: %s" % [path, entry.format, AGAIN])
	elif _is_array(entry) and found is Texture2D:  # of one layer
		return _array([(found as Texture2D).get_image()])
	return found


## A bucket matrix as OpenEXR, whose first row is the top one.
static func _exr(path: String, entry: Dictionary) -> Texture:
	var image := Image.new()
	if Packed.exr_size(path) != Vector2i(entry.size[0], entry.size[1]):
		push_error("RadTex: %s is no EXR of %d x %d pixels: %s" % [path, entry.size[0], entry.size[1], REMEDY])
		return null
	if not image.has_method("load_exr_from_buffer") \
			or image.call("load_exr_from_buffer", FileAccess.get_file_as_bytes(path)) != OK:
		push_error("RadTex: this Godot cannot read %s: export it with --format ktx2-rgba16f." % path)
		return null
	image.flip_y()
	return ImageTexture.create_from_image(image)


static func _array(images: Array[Image]) -> Texture2DArray:
	var made := TextureArray.new()
	made.images = images
	return made


## Whether the shader takes an array, as it does of slices, of pages and of more words than two.
static func _is_array(entry: Dictionary) -> bool:
	return entry.layers > 1 or entry.arrangement == "slices"
