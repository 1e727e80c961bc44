"""Pictures of the package against files that `vitrine render` and `vitrine relight` wrote."""
import json
import sys
from pathlib import Path

import numpy as np

import png
import vitrine

project = Path(sys.argv[1])
scene = vitrine.open(str(project))

for name in ("view_0", "view_3"):
    picture = scene.render(scene.camera(name).resized(48, 32))
    assert np.array_equal(picture.rgb8, png.read(project / "render" / f"{name}.png")), name
    assert picture.srgb.shape == (32, 48, 3) and picture.depth.shape == picture.alpha.shape == (32, 48)
    seen = picture.depth > 0
    assert seen.any() and not seen.all() and np.array_equal(seen, picture.alpha >= 0.5)
    assert np.allclose(np.linalg.norm(picture.normals[seen], axis=1), 1, atol=1e-5)

# The same camera from matrices: OpenGL axes in the file.
cameras = json.loads((project / "relit/captured/transforms.json").read_text())
relit = scene.relight()
for i, frame in enumerate(cameras["frames"]):
    pose = np.array(frame["transform_matrix"]) @ np.diag([1.0, -1, -1, 1])
    k = {**cameras, **frame}
    camera = vitrine.Camera(int(k["w"]), int(k["h"]), k["fl_x"], k["fl_y"], k["cx"], k["cy"], np.linalg.inv(pose))
    picture = relit.render(camera, samples=4, frame=i)
    bytes_here, bytes_there = vitrine.develop(picture.linear), png.read(project / f"relit/captured/frame_{i:04}.png")
    # The matrix in the file is rounded: a sample may fall on the other side of an edge.
    assert (np.abs(bytes_here.astype(int) - bytes_there) <= 1).mean() > 0.99, i

# An environment of another colour colours the picture.
red = np.zeros((8, 16, 3), np.float32)
red[..., 0] = 1
picture = scene.relight(red, rotate=90).render(scene.cameras[0].resized(24, 16), samples=4)
assert picture.linear[..., 0].mean() > 0.3 and picture.linear[..., 1:].max() == 0
