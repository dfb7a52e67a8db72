# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## Draws what files ask for, whose paths it reads as lines; after each it says ANSWERED. godot.py writes them.


func _initialize() -> void:
	var asked := OS.read_string_from_stdin(4096).strip_edges()
	while asked:
		var facts: Dictionary = JSON.parse_string(FileAccess.get_file_as_string(asked))
		if facts.has("jobs"):
			for job: Dictionary in facts.jobs:
				FileAccess.open(job.output, FileAccess.WRITE).store_buffer(await drawn(job))
		else:
			await shoot(facts.scene, facts.shots)
		print("ANSWERED")
		asked = OS.read_string_from_stdin(4096).strip_edges()
	quit()


## Pictures of a scene, each from a camera of `shots`.
func shoot(scene: String, shots: Array) -> void:
	var main: Node3D = load(scene).instantiate()
	root.add_child(main)
	root.msaa_3d = Viewport.MSAA_DISABLED  # the reference looks through the middles of pixels
	await process_frame
	var camera: Camera3D = main.get_node("Camera")
	camera.current = true
	var layer := CanvasLayer.new()
	var behind := picture_behind(layer)
	for shot: Dictionary in shots:
		camera.fov = shot.fovy
		camera.transform = placed(shot.matrix)
		main.transform = placed(shot.turn)
		var mirror: MeshInstance3D = main.get_node_or_null("Mirror")
		if mirror:
			mirror.moving = false
			mirror.position = Vector3(shot.mirror[0], shot.mirror[1], shot.mirror[2])
			mirror.radius = shot.mirror[3]
		for mesh: MeshInstance3D in main.find_children("*", "MeshInstance3D", true, false):
			for parameter: String in shot.parameters:
				for surface in mesh.get_surface_override_material_count():
					mesh.get_active_material(surface).set_shader_parameter(parameter, value(shot.parameters[parameter]))
		show_copies(main, shot)
		for name: String in shot.hidden:
			main.get_node(name).visible = false
		if shot.sun:
			place_sun(main, shot.sun)
		if shot.sky:
			set_sky(main.get_node("Environment").environment, shot.sky)
		if shot.behind:
			main.get_node("Environment").environment.background_mode = Environment.BG_CANVAS
			behind.texture = loaded(shot.behind)
		for frame in 2:
			await RenderingServer.frame_post_draw
		root.get_texture().get_image().save_png(shot.output)
		for name: String in shot.hidden:
			main.get_node(name).visible = true
	main.free()
	layer.free()


## Show the mesh at these places alone, as instances of one MultiMesh or as nodes; at its own where there are none.
func show_copies(main: Node3D, shot: Dictionary) -> void:
	var places: Array = shot.copies
	for node: Node in main.find_children("Copy*", "GeometryInstance3D", false, false):
		node.free()
	var own: Array[Node] = main.find_children("*", "MeshInstance3D", true, false)
	for mesh: MeshInstance3D in own:
		mesh.visible = places.is_empty()
	if places.is_empty():
		return
	var shown: MeshInstance3D = own[0]
	if shot.as_nodes:
		for number in places.size():
			var copy: MeshInstance3D = shown.duplicate()
			copy.name = "Copy"
			copy.visible = true
			copy.transform = placed(places[number]) * shown.global_transform
			var values: Dictionary = shot["values"][number] if shot["values"] else {}
			for parameter: String in values:
				copy.set_instance_shader_parameter(parameter, value(values[parameter]))
			main.add_child(copy, true)
		return
	var crowd := MultiMeshInstance3D.new()
	crowd.name = "Copy"
	crowd.multimesh = MultiMesh.new()
	crowd.multimesh.transform_format = MultiMesh.TRANSFORM_3D
	crowd.multimesh.use_colors = not shot.colours.is_empty()
	crowd.multimesh.mesh = shown.mesh
	crowd.multimesh.instance_count = places.size()
	for number in places.size():
		crowd.multimesh.set_instance_transform(number, placed(places[number]) * shown.global_transform)
	for number: int in shot.colours.size():
		var parts: Array = shot.colours[number]
		crowd.multimesh.set_instance_color(number, Color(parts[0], parts[1], parts[2], parts[3]))
	main.add_child(crowd)


## What fills the picture where the environment's background is the canvas.
func picture_behind(layer: CanvasLayer) -> TextureRect:
	layer.layer = -1
	root.add_child(layer)
	var found := TextureRect.new()
	found.set_anchors_preset(Control.PRESET_FULL_RECT)
	found.expand_mode = TextureRect.EXPAND_IGNORE_SIZE
	layer.add_child(found)
	return found


## A colour of its name, a vector of three numbers, or a number as it is.
func value(found: Variant) -> Variant:
	if found is String:
		return Color(found)
	return Vector3(found[0], found[1], found[2]) if found is Array else found


## A DirectionalLight3D that shines from a direction of the scene.
func place_sun(main: Node3D, facts: Dictionary) -> void:
	var sun: DirectionalLight3D = main.get_node_or_null("Sun")
	if not sun:
		sun = DirectionalLight3D.new()
		sun.name = "Sun"
		main.add_child(sun)
	var towards: Vector3 = value(facts.towards)
	sun.basis = Basis.looking_at(-towards, Vector3.UP if absf(towards.y) < 0.99 else Vector3.RIGHT)
	sun.light_color = Color(facts.colour)
	sun.light_energy = facts.strength
	sun.shadow_enabled = true


## Ambient light from a sky of two grey levels, above the horizon and below; nobody sees it.
func set_sky(environment: Environment, levels: Array) -> void:
	var image := Image.create(64, 32, false, Image.FORMAT_RGBF)
	for row in 32:
		var level: float = levels[row / 16]
		image.fill_rect(Rect2i(0, row, 64, 1), Color(level, level, level))
	var panorama := PanoramaSkyMaterial.new()
	panorama.panorama = ImageTexture.create_from_image(image)
	environment.sky = Sky.new()
	environment.sky.radiance_size = Sky.RADIANCE_SIZE_64  # a sixteenth of the work of the usual one
	environment.sky.sky_material = panorama
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_SKY


func loaded(path: String) -> Texture2D:
	return ImageTexture.create_from_image(Image.load_from_file(path))


func placed(rows: Array) -> Transform3D:
	var columns: Array[Vector3] = []
	for column in 4:
		columns.append(Vector3(rows[0][column], rows[1][column], rows[2][column]))
	return Transform3D(columns[0], columns[1], columns[2], columns[3])


## The bytes of a picture that a shader covers.
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
