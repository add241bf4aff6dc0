# Print pictures of a white matte ball under each scene, from each side, as base64.
extends Node3D


func _ready():
	for scene in @SCENES@:
		var ports = []
		for side in @SIDES@:
			ports.append(_port(scene, side))
		for frame in 6:
			await RenderingServer.frame_post_draw
		for k in ports.size():
			var image = ports[k].get_texture().get_image()
			image.convert(Image.FORMAT_RGB8)
			print("IMAGE ", scene, " ", k, " ", Marshalls.raw_to_base64(image.get_data()))
			ports[k].queue_free()
	print("DONE")


func _port(scene, side):
	var port = SubViewport.new()
	port.size = Vector2i(@SIZE@, @SIZE@)
	port.own_world_3d = true
	port.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var rig = load("res://%s.tscn" % scene).instantiate()
	rig.get_node("environment").environment.tonemap_exposure = @EXPOSURE@
	for thing in [rig, _ball(), _camera(side)]:
		port.add_child(thing)
	add_child(port)
	return port


func _ball():
	var ball = MeshInstance3D.new()
	ball.mesh = SphereMesh.new()
	ball.mesh.radius = 1
	ball.mesh.height = 2
	ball.mesh.radial_segments = 256
	ball.mesh.rings = 128
	var matte = StandardMaterial3D.new()
	matte.diffuse_mode = BaseMaterial3D.DIFFUSE_LAMBERT
	matte.specular_mode = BaseMaterial3D.SPECULAR_DISABLED
	matte.metallic_specular = 0
	ball.material_override = matte
	return ball


func _camera(side):
	var camera = Camera3D.new()
	camera.projection = Camera3D.PROJECTION_ORTHOGONAL
	camera.size = @WIDTH@
	var axes = side.map(func(axis): return Vector3(axis[0], axis[1], axis[2]))
	camera.transform = Transform3D(axes[0], axes[1], axes[2], 8 * axes[2])
	camera.current = true
	return camera
