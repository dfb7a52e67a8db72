# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
# Loads the textures that are named after "--" and writes their pixels, four floats each, beside them:
# of each layer all mip levels.
extends SceneTree

func _init() -> void:
	quit()
	for file in OS.get_cmdline_user_args():
		var output := FileAccess.open(file + ".floats", FileAccess.WRITE)
		for image in images_of(file):
			if image.is_compressed():
				image.decompress()
			image.convert(Image.FORMAT_RGBAF)
			output.store_buffer(image.get_data())

func images_of(file: String) -> Array[Image]:
	var image := Image.new()
	var bytes := FileAccess.get_file_as_bytes(file)
	if file.ends_with(".ktx2"):
		image.load_ktx_from_buffer(bytes)
		return [image]
	var layers: Array[Image] = []
	var texture: Texture = ResourceLoader.load(file)
	if texture is Texture2DArray:
		for layer in texture.get_layers():
			layers.append(texture.get_layer_data(layer))
		return layers
	image.load_dds_from_buffer(bytes)
	return [image]
