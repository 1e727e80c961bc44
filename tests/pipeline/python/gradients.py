"""Gradients of a loss against central differences, attribute by attribute."""
import sys

import numpy as np

import vitrine

scene = vitrine.open(sys.argv[1])
camera = scene.camera("view_2").resized(40, 30)
surfels = scene.surfels["diffuse"]
raw = surfels.raw
random = np.random.default_rng(1)
y, x = np.mgrid[0:30, 0:40]
weights = np.stack([np.cos(0.1 * x + c) * np.sin(0.15 * y + 2 * c) for c in range(3)], -1).astype(np.float32)


def loss():
    return float((scene.render(camera).srgb.astype(np.float64) * weights).sum())


def check(gradient, name, step, tolerance):
    direction = np.sign(gradient[name])
    before, values = raw[name].copy(), []
    for sign in (1, -1):
        raw[name][:] = before + sign * step * direction
        values.append(loss())
    raw[name][:] = before
    expected, measured = float((gradient[name] * direction).sum()), (values[0] - values[1]) / (2 * step)
    assert expected > 0.05, (name, expected)
    assert abs(measured - expected) < tolerance * expected, (name, measured, expected)


# All surfels together, in what does not move them: their order and their borders are not differentiable.
surfels.opacities = random.uniform(0.3, 0.7, len(surfels)).astype(np.float32)
surfels.colors = random.uniform(0.1, 0.9, surfels.colors.shape).astype(np.float32)
seen = []


def d_loss(picture):
    seen.append(picture.copy())
    return weights


gradient = scene.gradient(camera, d_loss)["diffuse"]
assert np.abs(seen[0] - scene.render(camera).srgb).max() < 1e-5
assert set(gradient) == set(raw) and all(gradient[name].shape == raw[name].shape for name in raw)
check(gradient, "sh_dc", 1e-3, 0.01)
check(gradient, "transmission", 1e-3, 0.01)
check(gradient, "opacity", 2e-4, 0.03)

# One large surfel alone, in everything that moves it, too.
nearest = np.argmin(np.linalg.norm(surfels.positions - camera.position, axis=1))
opacities, scales = np.full(len(surfels), 1e-6, np.float32), surfels.scales
opacities[nearest], scales[nearest] = 0.6, [0.1, 0.06]
surfels.opacities, surfels.scales = opacities, scales
weights *= (scene.render(camera).alpha > 0.2)[..., None]  # not its border, where it ends with a step of 1/255
gradient = scene.gradient(camera, weights)["diffuse"]
for name in ("mean", "rotation", "log_scale", "opacity", "sh_dc"):
    check(gradient, name, 1e-3 if name != "mean" else 1e-4, 0.02)

# A step down the gradient lowers the loss.
before = loss()
raw["sh_dc"] -= 0.1 * gradient["sh_dc"] / np.abs(gradient["sh_dc"]).max()
assert loss() < before
