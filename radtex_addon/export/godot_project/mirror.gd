# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
extends MeshInstance3D
## A mirror ball that moves around what is baked. Drag it to move it; B has it go on, or stand.

const HULL := 1.003  ## Times the radius: the drawn mesh encloses the ball, whose edge the shader finds.
const LAP := 12.0  ## Seconds once around.

@export var middle := Vector3.ZERO  ## Of its way, an ellipse, in the parent's space.
@export var across := Vector2.ONE  ## The ellipse's half axes along x and z.
@export var radius := 1.0
@export var moving := true

var angle := 0.8
var _held := false
var _depth := 0.0  # along the camera's axis, of the ball that is dragged


func _ready() -> void:
	mesh.radius = HULL
	mesh.height = 2.0 * HULL
	if moving:
		_follow()


func _process(seconds: float) -> void:
	if moving and not _held:
		angle += seconds * TAU / LAP
		_follow()
	scale = Vector3.ONE * radius
	var parent: Node3D = get_parent()
	var to_blender := Transform3D(Vector3(1, 0, 0), Vector3(0, 0, 1), Vector3(0, -1, 0), Vector3.ZERO)
	var material: ShaderMaterial = material_override
	material.set_shader_parameter("to_bake", Projection(to_blender * parent.global_transform.affine_inverse()))
	material.set_shader_parameter("radius", radius)


func _input(event: InputEvent) -> void:
	var camera := get_viewport().get_camera_3d()
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


func _follow() -> void:
	position = middle + Vector3(across.x * cos(angle), 0.0, -across.y * sin(angle))


func _is_under(camera: Camera3D, point: Vector2) -> bool:
	var from := camera.project_ray_origin(point)
	var ray := camera.project_ray_normal(point)
	var away := global_position - from
	return (away - ray * away.dot(ray)).length() < radius * get_parent().global_transform.basis.get_scale().x
