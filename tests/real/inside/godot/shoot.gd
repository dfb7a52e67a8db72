# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
extends SceneTree
## Takes pictures of a project's main scene, each from a camera of shots.json, which godot.py writes.


func _initialize() -> void:
	var main: Node3D = load("res://main.tscn").instantiate()
	root.add_child(main)
	root.msaa_3d = Viewport.MSAA_DISABLED  # the reference looks through the middles of pixels
	await process_frame
	var camera: Camera3D = main.get_node("Camera")
	var behind := picture_behind()
	for shot: Dictionary in JSON.parse_string(FileAccess.get_file_as_string("res://shots.json")):
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
				mesh.get_active_material(0).set_shader_parameter(parameter, value(shot.parameters[parameter]))
		show_copies(main, shot.copies, shot.as_nodes)
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
	quit()


## Show the mesh at these places alone, as instances of one MultiMesh or as nodes; at its own where there are none.
func show_copies(main: Node3D, places: Array, as_nodes: bool) -> void:
	for node: Node in main.find_children("Copy*", "GeometryInstance3D", false, false):
		node.free()
	var own: Array[Node] = main.find_children("*", "MeshInstance3D", true, false)
	for mesh: MeshInstance3D in own:
		mesh.visible = places.is_empty()
	if places.is_empty():
		return
	var shown: MeshInstance3D = own[0]
	if as_nodes:
		for place: Array in places:
			var copy: MeshInstance3D = shown.duplicate()
			copy.name = "Copy"
			copy.visible = true
			copy.transform = placed(place) * shown.global_transform
			main.add_child(copy, true)
		return
	var crowd := MultiMeshInstance3D.new()
	crowd.name = "Copy"
	crowd.multimesh = MultiMesh.new()
	crowd.multimesh.transform_format = MultiMesh.TRANSFORM_3D
	crowd.multimesh.mesh = shown.mesh
	crowd.multimesh.instance_count = places.size()
	for number in places.size():
		crowd.multimesh.set_instance_transform(number, placed(places[number]) * shown.global_transform)
	main.add_child(crowd)


## What fills the picture where the environment's background is the canvas.
func picture_behind() -> TextureRect:
	var layer := CanvasLayer.new()
	layer.layer = -1
	root.add_child(layer)
	var found := TextureRect.new()
	found.set_anchors_preset(Control.PRESET_FULL_RECT)
	found.expand_mode = TextureRect.EXPAND_IGNORE_SIZE
	layer.add_child(found)
	return found


func value(found: Variant) -> Variant:
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
	environment.sky.sky_material = panorama
	environment.ambient_light_source = Environment.AMBIENT_SOURCE_SKY


func loaded(path: String) -> Texture2D:
	return ImageTexture.create_from_image(Image.load_from_file(path))


func placed(rows: Array) -> Transform3D:
	var columns: Array[Vector3] = []
	for column in 4:
		columns.append(Vector3(rows[0][column], rows[1][column], rows[2][column]))
	return Transform3D(columns[0], columns[1], columns[2], columns[3])
