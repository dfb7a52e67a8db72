# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
class_name RadTexMirror
extends MeshInstance3D
## A mirror ball that moves around a bake which was exported with --mirror. Drag it to move it; B has it go on, or stand.

const Materials := preload("materials.gd")
const HULL := 1.003  ## Times the radius: the drawn mesh encloses the ball, whose edge the shader finds.
const LAP := 12.0  ## Seconds once around.

@export var baked: Node3D  ## What is mirrored. Without one, the first bake beside this node.
@export var radius := 0.0  ## In the world of the bake. 0: as the export has it.
@export var moving := true

var angle := 0.8

var _shown: MeshInstance3D
var _way := {}  # the metadata of its material
var _held := false
var _depth := 0.0  # along the camera's axis, of the ball that is dragged


func _ready() -> void:
	if not _find(baked if baked else get_parent()):
		push_error("RadTexMirror: nothing under %s can be mirrored: export the bake with --mirror." % (baked if baked else get_parent()))
		set_process(false)
		return
	var ball := SphereMesh.new()
	ball.radius = HULL
	ball.height = 2.0 * HULL
	ball.radial_segments = 128
	ball.rings = 64
	mesh = ball
	material_override = _way.material.duplicate()
	radius = radius if radius > 0.0 else _way.radius
	if moving:
		_follow()
	_process(0.0)


func _process(seconds: float) -> void:
	if moving and not _held:
		angle += seconds * TAU / LAP
		_follow()
	var from_bake := _from_bake()
	global_basis = Basis.from_scale(Vector3.ONE * radius * from_bake.basis.get_scale().x)
	var material: ShaderMaterial = material_override
	material.set_shader_parameter("to_bake", Projection(from_bake.affine_inverse()))
	material.set_shader_parameter("radius", radius)


func _input(event: InputEvent) -> void:
	var camera := get_viewport().get_camera_3d()
	if not camera or not mesh:
		return
	if event is InputEventKey and event.pressed and event.keycode == KEY_B:
		moving = not moving
	elif event is InputEventMouseButton and event.button_index == MOUSE_BUTTON_LEFT:
		_held = event.pressed and _is_under(camera, event.position)
		if _held:
			moving = false
			_depth = -(camera.global_transform.affine_inverse() * global_position).z
			get_viewport().set_input_as_handled()
	elif event is InputEventMouseMotion and _held:
		global_position = camera.project_position(event.position, _depth)
		get_viewport().set_input_as_handled()


## Look for what can be mirrored under a node; whether there is any.
func _find(node: Node) -> bool:
	for each: MeshInstance3D in node.find_children("*", "MeshInstance3D", true, false):
		for surface in each.mesh.get_surface_count() if each.mesh else 0:
			var material := each.get_active_material(surface)
			if material and material.has_meta(Materials.MIRROR):
				_shown = each
				_way = material.get_meta(Materials.MIRROR)
				return true
	return false


## From the world of the bake, z up, to the scene as it is now.
func _from_bake() -> Transform3D:
	return _shown.global_transform * (_way.baked as Transform3D).affine_inverse()


func _follow() -> void:
	var across := Vector3(_way.across.x * cos(angle), _way.across.y * sin(angle), 0.0)
	global_position = _from_bake() * (_way.middle + across)


func _is_under(camera: Camera3D, point: Vector2) -> bool:
	var from := camera.project_ray_origin(point)
	var ray := camera.project_ray_normal(point)
	var away := global_position - from
	return (away - ray * away.dot(ray)).length() < global_basis.get_scale().x
