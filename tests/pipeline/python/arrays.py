"""What a scene holds, what may be changed, and errors."""
import gc
import sys

import numpy as np

import vitrine

scene = vitrine.open(sys.argv[1])
assert [c.name for c in scene.cameras] == [f"view_{i}.png" for i in range(8)] and scene.heldout == ["view_0.png"]
camera = scene.cameras[1]
assert camera.K.shape == (3, 3) and np.allclose(camera.cam_from_world @ camera.world_from_cam, np.eye(4))
assert np.allclose(camera.world_from_cam[:3, 3], camera.position)
point = camera.cam_from_world @ [0, 0, 0, 1]
assert np.allclose((camera.K @ (point[:3] / point[2]))[:2], [32, 24])  # the photos look at the origin

surfels = scene.surfels["diffuse"]
assert set(scene.surfels) == {"diffuse", "transmittance"}
assert surfels.positions.shape == (len(surfels), 3) == surfels.normals.shape and surfels.scales.shape == (len(surfels), 2)
assert np.allclose(np.exp(surfels.raw["log_scale"]), surfels.scales)
assert len(surfels.object_ids) == len(surfels) and surfels.object_ids.max() > 0

# Assignments and raw values show in the next picture.
before = scene.render(camera).srgb
assert before.max() > 0.1
surfels.colors = np.zeros_like(surfels.colors)
assert np.allclose(surfels.colors, 0, atol=1e-6)
dark = scene.render(camera).srgb
assert dark.mean() < 0.5 * before.mean()
surfels.opacities = np.full(len(surfels), 1e-4, np.float32)
assert scene.render(camera).alpha.max() < 0.5

# Arrays keep their memory alive.
raw, mesh, picture = scene.surfels["diffuse"].raw["mean"], scene.mesh, scene.render(camera).srgb
vertices, faces, total = mesh.vertices, mesh.faces, float(mesh.vertices.sum())
assert faces.max() < len(vertices) and faces.dtype == np.uint32
objects = scene.objects
assert [(o["id"], o["name"], o["role"], o["shapes"]) for o in objects] == [(1, "reflecting", "coat", [])]
mean = raw.copy()
del scene, surfels, mesh
gc.collect()
assert np.array_equal(raw, mean) and float(vertices.sum()) == total
raw += 1


def error_of(call):
    try:
        call()
    except vitrine.Error as e:
        assert e.message in str(e) and e.hint
        return e
    raise AssertionError("no error")


e = error_of(lambda: vitrine.open("nowhere"))
assert (e.code, e.kind, e.exit_code) == ("NO_PROJECT", "INPUT", 3) and "vitrine.yaml" in str(e)
scene = vitrine.open(sys.argv[1])
assert error_of(lambda: scene.camera("holiday")).code == "NO_CAMERA"
assert error_of(lambda: vitrine.open(sys.argv[1], edited=True)).code == "NO_EDITS"
assert error_of(lambda: scene.relight(np.ones((8, 8, 3)))).code == "ENV_SHAPE"
wrong = [
    lambda: scene.gradient(camera, np.zeros((2, 2, 3))),
    lambda: vitrine.Camera(64, 48, 70, 70, 32, 24, 2 * np.eye(4)),
    lambda: vitrine.Camera(0, 48, 70, 70, 32, 24, np.eye(4)),
    lambda: setattr(scene.surfels["diffuse"], "opacities", np.full(3, 0.5)),
    lambda: setattr(scene.surfels["diffuse"], "scales", -scene.surfels["diffuse"].scales),
    lambda: scene.surfels["transmittance"].roughness,
]
for call in wrong:
    assert error_of(call).kind == "USAGE"
assert "d_picture" in vitrine.Scene.gradient.__doc__ and "scene units" in vitrine.__doc__
