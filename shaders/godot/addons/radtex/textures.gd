# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends RefCounted
## Loads the textures of an export, each once.
##
## What Godot loads by itself stays a file of the project that scenes refer to. KTX2 files that it refuses (arrays, sRGB,
## whole numbers, mip levels that end early) are read here, and become part of the imported scene.

const TextureArray := preload("texture_array.gd")
const REMEDY := "copy all files of the export's folder, side by side, and import the .glb again."
const AGAIN := "export it again, with --format ktx2-rgba16f if this file cannot be read."
const BLOCK := 4  ## Pixels along the side of a compressed block.
# By VkFormat: the image's format, bytes of a pixel or a block, pixels along a block's side, whether Godot loads it.
const FORMATS := {
	97: [Image.FORMAT_RGBAH, 8, 1, true],
	109: [Image.FORMAT_RGBAF, 16, 1, true],
	123: [Image.FORMAT_RGBE9995, 4, 1, true],
	137: [Image.FORMAT_DXT5, 16, BLOCK, true],
	138: [Image.FORMAT_DXT5, 16, BLOCK, false],
	139: [Image.FORMAT_RGTC_R, 8, BLOCK, true],
	141: [Image.FORMAT_RGTC_RG, 16, BLOCK, true],
	143: [Image.FORMAT_BPTC_RGBFU, 16, BLOCK, true],
	145: [Image.FORMAT_BPTC_RGBA, 16, BLOCK, true],
	146: [Image.FORMAT_BPTC_RGBA, 16, BLOCK, false],
}
const WORDS := {98: 1, 101: 2}  ## VkFormats of 32-bit words: how many; four bytes of a pixel hold one.
const HEADER := 80  ## Bytes of a KTX2 before the index of its levels.
const ZSTD := 2

var _folder: String
var _loaded := {}


func _init(folder: String) -> void:
	_folder = folder


## The texture of an entry of the export's JSON; null, after an error that says what to do, if it cannot be loaded.
func loaded(entry: Dictionary) -> Texture:
	var path := _folder.path_join(entry.get("uri", entry.file).uri_decode())
	if not _loaded.has(path):
		_loaded[path] = _load(path, entry)
	return _loaded[path]


static func _load(path: String, entry: Dictionary) -> Texture:
	if not FileAccess.file_exists(path):
		push_error("RadTex: %s is missing: %s" % [path, REMEDY])
		return null
	match entry.container:
		"ktx2":
			return _ktx2(path, entry)
		"dds":
			return _by_godot(path, entry)
		"exr":
			return _exr(path)
	push_error("RadTex: Godot loads no %s files (%s): %s" % [entry.container, path, AGAIN])
	return null


static func _by_godot(path: String, entry: Dictionary) -> Texture:
	var found := load(path) as Texture
	if not found:
		push_error("RadTex: Godot cannot load %s, which is %s: %s" % [path, entry.format, AGAIN])
	elif _is_array(entry) and found is Texture2D:  # of one layer
		return _array([(found as Texture2D).get_image()])
	return found


## A bucket matrix as OpenEXR, whose first row is the top one.
static func _exr(path: String) -> Texture:
	var image := Image.new()
	if not image.has_method("load_exr_from_buffer") \
			or image.call("load_exr_from_buffer", FileAccess.get_file_as_bytes(path)) != OK:
		push_error("RadTex: this Godot cannot read %s: export it with --format ktx2-rgba16f." % path)
		return null
	image.flip_y()
	return ImageTexture.create_from_image(image)


static func _ktx2(path: String, entry: Dictionary) -> Texture:
	var header := FileAccess.open(path, FileAccess.READ).get_buffer(HEADER)
	if header.size() < HEADER or header.slice(1, 7).get_string_from_ascii() != "KTX 20":
		push_error("RadTex: %s is no KTX2 file: %s" % [path, REMEDY])
		return null
	var vk_format := header.decode_u32(12)
	var size := Vector2i(header.decode_u32(20), header.decode_u32(24))
	var levels := header.decode_u32(40)
	var whole := levels == 1 or levels == _most_levels(size)
	if FORMATS.get(vk_format, [0, 0, 0, false])[3] and whole and not _is_array(entry):
		return _by_godot(path, entry)
	var images := _images(path, FileAccess.get_file_as_bytes(path), vk_format, size, levels)
	if images.is_empty():
		return null
	return _array(images) if _is_array(entry) else ImageTexture.create_from_image(images[0])


static func _array(images: Array[Image]) -> Texture2DArray:
	var made := TextureArray.new()
	made.images = images
	return made


## Whether the shader takes an array, as it does of slices, of pages and of more words than two.
static func _is_array(entry: Dictionary) -> bool:
	return entry.layers > 1 or entry.arrangement == "slices"


## The layers of a KTX2, each with its mip levels; none, after an error, for a file that is damaged or of another format.
static func _images(path: String, bytes: PackedByteArray, vk_format: int, size: Vector2i, levels: int) -> Array[Image]:
	var count := maxi(bytes.decode_u32(32), 1)
	var form: Array = FORMATS.get(vk_format, [Image.FORMAT_RGBA8, 4, 1, false])
	if WORDS.has(vk_format):
		size.x *= WORDS[vk_format]
	elif not FORMATS.has(vk_format):
		push_error("RadTex: %s has VkFormat %d, which this addon does not read: %s" % [path, vk_format, AGAIN])
		return []
	var chain := levels if levels == 1 else _most_levels(size)
	var packed: Array[PackedByteArray] = []
	packed.resize(count)
	for layer in count:
		packed[layer] = PackedByteArray()
	for level in chain:
		var length := _bytes_of(size, level, form)
		var unpacked := _level(bytes, mini(level, levels - 1))
		if level < levels and unpacked.size() != count * length:
			push_error("RadTex: %s is damaged, its level %d has another size: %s" % [path, level, REMEDY])
			return []
		var step := unpacked.size() / count  # levels that the file lacks, and no lookup reads, have its last one's colours
		for layer in count:
			packed[layer].append_array(unpacked.slice(layer * step, layer * step + length))
	var images: Array[Image] = []
	for layer in count:
		images.append(Image.create_from_data(size.x, size.y, chain > 1, form[0], packed[layer]))
	return images


static func _level(bytes: PackedByteArray, level: int) -> PackedByteArray:
	var index := HEADER + 24 * level
	var offset := bytes.decode_u64(index)
	var part := bytes.slice(offset, offset + bytes.decode_u64(index + 8))
	if bytes.decode_u32(44) == ZSTD:
		return part.decompress(bytes.decode_u64(index + 16), FileAccess.COMPRESSION_ZSTD)
	return part


static func _bytes_of(size: Vector2i, level: int, form: Array) -> int:
	var side: int = form[2]
	var columns := (maxi(size.x >> level, 1) + side - 1) / side
	var rows := (maxi(size.y >> level, 1) + side - 1) / side
	return columns * rows * form[1]


static func _most_levels(size: Vector2i) -> int:
	var levels := 1
	while maxi(size.x, size.y) >> levels > 0:
		levels += 1
	return levels
