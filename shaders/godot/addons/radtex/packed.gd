# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends RefCounted
## A KTX2 or DDS file as RadTex writes it: what its header says, held against the file's size, and its pixels.

const Checks := preload("checks.gd")
const BLOCK := 4  ## Pixels along the side of a compressed block.
# By format: the image's, bytes of a pixel or a block, pixels along a block's side, VkFormat, DXGI_FORMAT, whether Godot
# loads it from KTX2. Four bytes of a pixel hold a word of 32 bits.
const FORMATS := {
	"RGBA16F": [Image.FORMAT_RGBAH, 8, 1, 97, 10, true],
	"RGBA32F": [Image.FORMAT_RGBAF, 16, 1, 109, 0, true],
	"RGB9E5": [Image.FORMAT_RGBE9995, 4, 1, 123, 0, true],
	"RGBA8": [Image.FORMAT_RGBA8, 4, 1, 37, 28, false],
	"BC3": [Image.FORMAT_DXT5, 16, BLOCK, 137, 77, true],
	"BC3_SRGB": [Image.FORMAT_DXT5, 16, BLOCK, 138, 78, false],
	"BC4": [Image.FORMAT_RGTC_R, 8, BLOCK, 139, 80, true],
	"BC5": [Image.FORMAT_RGTC_RG, 16, BLOCK, 141, 83, true],
	"BC6H": [Image.FORMAT_BPTC_RGBFU, 16, BLOCK, 143, 95, true],
	"BC7": [Image.FORMAT_BPTC_RGBA, 16, BLOCK, 145, 98, true],
	"BC7_SRGB": [Image.FORMAT_BPTC_RGBA, 16, BLOCK, 146, 99, false],
	"R32UI": [Image.FORMAT_RGBA8, 4, 1, 98, 0, false],
	"RG32UI": [Image.FORMAT_RGBA8, 8, 1, 101, 0, false],
}
const KTX2 := [0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A]
const KTX2_HEADER := 80  ## Bytes before the index of levels.
const DDS_HEADER := 148
const EXR := 20000630
const ZSTD := 2
const MOST_IN_A_BYTE := 1 << 15  ## What four bytes of Zstandard hold at most is 128 KiB.

var problem := ""  ## What is wrong with the file, as the end of a sentence.
var is_dds := false
var format := ""
var size: Vector2i
var layers := 1
var levels := 1

var _path: String
var _zstd := false
var _unpacked_level := -1
var _unpacked: PackedByteArray
var _parts := []  # of each level, in a DDS of each layer's: place, bytes, and bytes when unpacked

var is_loaded_by_godot: bool:
	get:
		return FORMATS[format][5]

var is_whole: bool:  ## Whether it has one level, or all down to a pixel.
	get:
		return levels == 1 or levels == _most_levels()


## A KTX2 file's header.
static func ktx2(path: String) -> RefCounted:
	var made := new()
	made._path = path
	var file := FileAccess.open(path, FileAccess.READ)
	var head := file.get_buffer(KTX2_HEADER) if file else PackedByteArray()
	if head.size() < KTX2_HEADER or Array(head.slice(0, 12)) != KTX2:
		made.problem = "is no KTX2 file"
		return made
	made._read_shape(head.decode_u32(12), 3, head.decode_u32(20), head.decode_u32(24), head.decode_u32(32), head.decode_u32(40))
	made._zstd = head.decode_u32(44) == ZSTD
	if not made.problem and (head.decode_u32(28) or head.decode_u32(36) != 1 or head.decode_u32(44) not in [0, ZSTD]):
		made.problem = "is no KTX2 file that RadTex writes"
	if made.problem:
		return made
	var index := file.get_buffer(24 * made.levels)
	for level: int in made.levels:
		var bytes: int = made.layers * made._bytes_of(level)
		made._add(index.slice(24 * level), bytes, file.get_length())
	return made


## A DDS file's header.
static func dds(path: String) -> RefCounted:
	var made := new()
	made._path = path
	made.is_dds = true
	var file := FileAccess.open(path, FileAccess.READ)
	var head := file.get_buffer(DDS_HEADER) if file else PackedByteArray()
	if head.size() < DDS_HEADER or head.decode_u32(0) != 0x20534444 or head.decode_u32(84) != 0x30315844:
		made.problem = "is no DDS file that RadTex writes"
		return made
	made._read_shape(head.decode_u32(128), 4, head.decode_u32(16), head.decode_u32(12), head.decode_u32(140), head.decode_u32(28))
	var place := DDS_HEADER
	for part: int in made.layers * made.levels if not made.problem else 0:
		var bytes: int = made._bytes_of(part % made.levels)
		made._parts.append([place, bytes, bytes])
		place += bytes
	if not made.problem and place != file.get_length():
		made.problem = "is damaged, it has another size"
	return made


## The pixels across and up of an EXR, by the data window in its header; none if it is no EXR.
static func exr_size(path: String) -> Vector2i:
	var file := FileAccess.open(path, FileAccess.READ)
	var head := file.get_buffer(1 << 16) if file else PackedByteArray()
	if head.size() < 8 or head.decode_u32(0) != EXR:
		return Vector2i.ZERO
	var place := 8
	while place < head.size() and head[place]:
		var words: Array[String] = []
		for word in 2:  # an attribute's name, and its type
			var end := head.find(0, place)
			if end < 0 or end - place > Checks.MOST_CHARACTERS:
				return Vector2i.ZERO
			words.append(head.slice(place, end).get_string_from_ascii())
			place = end + 1
		if place + 4 > head.size():
			return Vector2i.ZERO
		var length := head.decode_u32(place)
		if words[0] == "dataWindow" and length == 16 and place + 20 <= head.size():
			return Vector2i(head.decode_s32(place + 12) - head.decode_s32(place + 4), head.decode_s32(place + 16) - head.decode_s32(place + 8)) \
				+ Vector2i.ONE
		place += 4 + length
	return Vector2i.ZERO


## Whether it is what an entry of the export's JSON says; it may have further levels.
func holds(entry: Dictionary) -> bool:
	return format == entry.format and size == Vector2i(entry.size[0], entry.size[1]) and layers == int(entry.layers) \
		and levels >= int(entry.levels)


## Its layers, each with its mip levels; none, after a problem, for a file that is damaged.
func images() -> Array[Image]:
	var bytes := FileAccess.get_file_as_bytes(_path)
	var chain := levels if levels == 1 else _most_levels()
	var packed: Array[PackedByteArray] = []
	packed.resize(layers)
	for level in chain:
		var length := _bytes_of(level)
		for layer in layers:
			var part := _level(bytes, layer, mini(level, levels - 1))
			if part.size() < length:
				problem = "is damaged, its level %d does not unpack" % level
				return []
			packed[layer].append_array(part.slice(0, length))  # of levels that it lacks, and no lookup reads, those of its last one
	var found: Array[Image] = []
	var wide: int = size.x * FORMATS[format][1] / 4 if format.ends_with("UI") else size.x
	for layer in layers:
		found.append(Image.create_from_data(wide, size.y, chain > 1, FORMATS[format][0], packed[layer]))
	return found


func _read_shape(number: int, column: int, wide: int, tall: int, count: int, chain: int) -> void:
	for name: String in FORMATS:
		if FORMATS[name][column] == number and number:
			format = name
	size = Vector2i(wide, tall)
	layers = maxi(count, 1)
	levels = maxi(chain, 1)
	if not format:
		problem = "has the unknown format %d" % number
	elif wide not in range(1, Checks.MOST_PIXELS + 1) or tall not in range(1, Checks.MOST_PIXELS + 1) \
			or layers > Checks.MOST_LAYERS or levels > _most_levels():
		problem = "has impossible sizes"


## Add a level of a KTX2, as its index has it, that holds so many `bytes` when it is unpacked.
func _add(index: PackedByteArray, bytes: int, end: int) -> void:
	if index.size() < 24:
		problem = "is damaged, it is cut short"
		return
	var place := index.decode_u64(0)
	var packed := index.decode_u64(8)
	var fits := place >= KTX2_HEADER and packed > 0 and place <= end and packed <= end - place
	if not fits or index.decode_u64(16) != bytes or (packed * MOST_IN_A_BYTE < bytes if _zstd else packed != bytes):
		problem = "is damaged, its level %d has another size" % _parts.size()
	_parts.append([place, packed, bytes])


## One layer of a level: `_bytes_of` it, or fewer where it does not unpack.
func _level(bytes: PackedByteArray, layer: int, level: int) -> PackedByteArray:
	var part: Array = _parts[layer * levels + level] if is_dds else _parts[level]
	if level != _unpacked_level or is_dds:
		_unpacked_level = level
		_unpacked = bytes.slice(part[0], part[0] + part[1])
		if _zstd:
			_unpacked = _unpacked.decompress(part[2], FileAccess.COMPRESSION_ZSTD)
	var length := _bytes_of(level)
	return _unpacked if is_dds else _unpacked.slice(layer * length, (layer + 1) * length)


func _bytes_of(level: int) -> int:
	var side: int = FORMATS[format][2]
	var columns := (maxi(size.x >> level, 1) + side - 1) / side
	var rows := (maxi(size.y >> level, 1) + side - 1) / side
	return columns * rows * FORMATS[format][1]


func _most_levels() -> int:
	return Checks.most_levels([size.x, size.y])
