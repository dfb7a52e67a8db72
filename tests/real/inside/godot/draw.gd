# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## Draws each job of jobs.json: a shader over a whole picture, whose bytes go into a file. godot.py writes the jobs.


func _initialize() -> void:
	for job: Dictionary in JSON.parse_string(FileAccess.get_file_as_string("res://jobs.json")):
		FileAccess.open(job.output, FileAccess.WRITE).store_buffer(await drawn(job))
	quit()


func drawn(job: Dictionary) -> PackedByteArray:
	var material := ShaderMaterial.new()
	material.shader = load(job.shader)
	for name: String in job.textures:
		material.set_shader_parameter(name, texture(job.textures[name]))
	for name: String in job.values:
		material.set_shader_parameter(name, vectors(job.values[name]))
	var viewport := SubViewport.new()
	viewport.size = Vector2i(job.size[0], job.size[1])
	viewport.transparent_bg = true
	viewport.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var rectangle := ColorRect.new()
	rectangle.size = viewport.size
	rectangle.material = material
	viewport.add_child(rectangle)
	root.add_child(viewport)
	for frame in 2:
		await RenderingServer.frame_post_draw
	var image := viewport.get_texture().get_image()
	assert(image.get_format() == Image.FORMAT_RGBA8)
	viewport.queue_free()
	return image.get_data()


func vectors(numbers: Array) -> Variant:
	if numbers[0] is not Array:
		return Vector4(numbers[0], numbers[1], numbers[2], numbers[3])
	var found := PackedVector4Array()
	for row: Array in numbers:
		found.append(vectors(row))
	return found


func texture(facts: Dictionary) -> Texture:
	if facts.file.ends_with(".ktx2") or facts.file.ends_with(".dds"):
		return load(facts.file)
	var bytes := FileAccess.get_file_as_bytes(facts.file)
	var format := Image.FORMAT_RGBAH if facts.half else Image.FORMAT_RGBAF
	var images: Array[Image] = []
	var length := bytes.size() / int(facts.layers)
	for layer in int(facts.layers):
		var layer_bytes := bytes.slice(layer * length, (layer + 1) * length)
		images.append(Image.create_from_data(facts.size[0], facts.size[1], facts.mipmaps, format, layer_bytes))
	if not facts.layered:
		return ImageTexture.create_from_image(images[0])
	var layered := Texture2DArray.new()
	layered.create_from_images(images)
	return layered
