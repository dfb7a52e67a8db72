# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
extends Camera3D
## Orbits around what the scene shows: drag to turn, wheel or pinch to come closer.

const SPEED := 0.008  ## Radians a pixel.
const STEP := 1.1  ## How much farther one notch of the wheel is.

var angles := Vector2(0.4, -0.3)  ## Around the vertical, then above it.
var middle := Vector3.ZERO
var distance := 3.0


func _ready() -> void:
	var box := AABB()
	for shown: GeometryInstance3D in get_parent().find_children("*", "GeometryInstance3D", true, false):
		var its_box := shown.global_transform * shown.get_aabb()
		box = box.merge(its_box) if box.has_surface() else its_box
	middle = box.get_center()
	distance = 0.6 * box.size.length() / sin(deg_to_rad(fov) / 2.0)
	near = distance / 1000.0
	far = distance * 100.0
	_place()


func _unhandled_input(event: InputEvent) -> void:
	if event is InputEventMouseMotion and event.button_mask & MOUSE_BUTTON_MASK_LEFT:
		angles -= event.relative * SPEED
		angles.y = clampf(angles.y, -1.5, 1.5)
	elif event is InputEventMouseButton and event.pressed:
		if event.button_index == MOUSE_BUTTON_WHEEL_UP:
			distance /= STEP
		elif event.button_index == MOUSE_BUTTON_WHEEL_DOWN:
			distance *= STEP
	elif event is InputEventMagnifyGesture:
		distance /= event.factor
	_place()


func _place() -> void:
	basis = Basis.from_euler(Vector3(angles.y, angles.x, 0.0))
	position = middle + basis.z * distance
