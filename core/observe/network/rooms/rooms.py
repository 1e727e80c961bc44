"""Random rooms with boxes, balls, cylinders and cones: pictures with exact normals, by analytic ray casting in numpy.

Every solid is a unit primitive under an affine map, so that one ray in world coordinates is one ray in local coordinates with the
same parameter t. Normals are in the OpenCV camera frame (x right, y down, z forward; a wall facing the camera is 0 0 -1).
"""
import numpy as np

FAR = 1e9


def rotation(axis, angle):
    x, y, z = axis / np.linalg.norm(axis)
    c, s = np.cos(angle), np.sin(angle)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + s * k + (1 - c) * (k @ k)


# --- primitives: rays (o, d) in local coordinates -> t of the first hit with t > 0, normal there ---------------------------------
def hit_box(o, d):
    safe = np.where(np.abs(d) < 1e-9, 1e-9, d)
    a, b = (-1 - o) / safe, (1 - o) / safe
    near, far = np.minimum(a, b), np.maximum(a, b)
    t0, t1 = near.max(1), far.min(1)
    inside = t0 <= 1e-4  # from within: the far side, seen from inside
    t = np.where(inside, t1, t0)
    axis = np.where(inside, far.argmin(1), near.argmax(1))
    normal = np.zeros_like(d)
    rows = np.arange(len(d))
    normal[rows, axis] = -np.sign(d[rows, axis])
    return np.where((t0 <= t1) & (t > 1e-4), t, FAR), normal


def hit_ball(o, d):
    a, b, c = (d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - 1
    root = b * b - a * c
    t = (-b - np.sqrt(np.maximum(root, 0))) / a
    return np.where((root > 0) & (t > 1e-4), t, FAR), o + t[:, None] * d


def hit_round(o, d, slope):
    """x^2 + y^2 = r(z)^2 for -1 < z < 1 with r = 1 (slope 0: cylinder) or (1 - z) / 2 (cone), and its flat ends."""
    r0, r1 = (1.0, 0.0) if slope == 0 else (0.5, -0.5)
    ro, rd = r0 + r1 * o[:, 2], r1 * d[:, 2]
    a = d[:, 0] ** 2 + d[:, 1] ** 2 - rd**2
    b = o[:, 0] * d[:, 0] + o[:, 1] * d[:, 1] - ro * rd
    c = o[:, 0] ** 2 + o[:, 1] ** 2 - ro**2
    a = np.where(np.abs(a) < 1e-9, 1e-9, a)
    root = b * b - a * c
    best, normal = np.full(len(d), FAR), np.zeros_like(d)
    for sign in (-1, 1):
        t = (-b + sign * np.sqrt(np.maximum(root, 0))) / a
        p = o + t[:, None] * d
        good = (root > 0) & (t > 1e-4) & (np.abs(p[:, 2]) < 1) & (r0 + r1 * p[:, 2] >= 0) & (t < best)
        best = np.where(good, t, best)
        side = np.stack([p[:, 0], p[:, 1], -r1 * (r0 + r1 * p[:, 2])], 1)
        normal = np.where(good[:, None], side, normal)
    safe = np.where(np.abs(d[:, 2]) < 1e-9, 1e-9, d[:, 2])
    for end in (-1, 1):
        t = (end - o[:, 2]) / safe
        p = o + t[:, None] * d
        good = (t > 1e-4) & (p[:, 0] ** 2 + p[:, 1] ** 2 < (r0 + r1 * end) ** 2) & (t < best)
        best = np.where(good, t, best)
        normal = np.where(good[:, None], np.array([0.0, 0, end]), normal)
    return best, normal


HITS = {"box": hit_box, "ball": hit_ball, "cylinder": lambda o, d: hit_round(o, d, 0), "cone": lambda o, d: hit_round(o, d, 1)}


# --- paint: colour of a local point ------------------------------------------------------------------------------------------
def hashed(cells, seed):
    h = (cells[..., 0] * 73856093) ^ (cells[..., 1] * 19349663) ^ (cells[..., 2] * 83492791) ^ (seed * 2654435761)
    h = (h ^ (h >> 13)) * 1274126177 & 0x7FFFFFFF
    return ((h ^ (h >> 16)) & 0xFFFF) / 65535.0


def noise(p, seed):
    cell = np.floor(p).astype(np.int64)
    f = p - cell
    f = f * f * (3 - 2 * f)
    out = 0
    for corner in range(8):
        offset = np.array([corner & 1, corner >> 1 & 1, corner >> 2 & 1])
        weight = np.prod(np.where(offset == 1, f, 1 - f), axis=1)
        out = out + weight * hashed(cell + offset, seed)
    return out


class Paint:
    def __init__(self, rng):
        self.kind = rng.choice(["flat", "flat", "noise", "checker", "tiles", "stripes"])
        base = rng.uniform(0.1, 0.9)  # most things are not very colourful
        self.colours = np.clip(base + rng.uniform(-0.35, 0.35) + rng.uniform(-1, 1, (4, 3)) * rng.choice([0.06, 0.2, 0.45]), 0.02, 0.98)
        self.scale, self.seed = np.exp(rng.uniform(np.log(1.5), np.log(14))), int(rng.integers(1 << 20))
        self.turn = rotation(rng.normal(size=3), rng.uniform(0, 3))
        self.gloss, self.power = rng.choice([0, 0, 0.1, 0.5]), rng.choice([8, 30, 120])

    def __call__(self, p):
        q = p * self.scale + 100
        c = self.colours
        if self.kind == "flat":
            return np.broadcast_to(c[0], p.shape)
        if self.kind == "noise":
            v = 0.6 * noise(q, self.seed) + 0.4 * noise(q * 3.1, self.seed + 1)
            return c[0] + (c[1] - c[0]) * np.clip(2 * v - 0.5, 0, 1)[:, None]
        if self.kind == "stripes":
            v = (np.sin((q @ self.turn)[:, 0] * 2) > 0)[:, None]
            return np.where(v, c[0], c[1])
        cell = np.floor(q + 0.003).astype(np.int64)
        if self.kind == "checker":
            return np.where((cell.sum(1) % 2 == 0)[:, None], c[0], c[1])
        return c[(hashed(cell, self.seed) * 3.999).astype(int)]


class Solid:
    def __init__(self, kind, centre, size, turn, paint):
        self.hit, self.centre, self.paint = HITS[kind], np.asarray(centre, float), paint
        self.world_from_local = turn @ np.diag(size)
        self.local_from_world = np.diag(1 / np.asarray(size, float)) @ turn.T
        self.normal_map = self.local_from_world.T


def first_hit(solids, o, d):
    best, normal, which = np.full(len(d), FAR), np.zeros_like(d), np.full(len(d), -1)
    for i, s in enumerate(solids):
        t, n = s.hit((o - s.centre) @ s.local_from_world.T, d @ s.local_from_world.T)
        closer = t < best
        best = np.where(closer, t, best)
        normal[closer] = n[closer] @ s.normal_map.T
        which[closer] = i
    return best, normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9), which


def random_solids(rng):
    """A room (a box seen from inside), perhaps a table, and things on the floor or the table."""
    solids = []
    half = np.array([rng.uniform(1.5, 4), rng.uniform(1.5, 4), rng.uniform(1.1, 2)])
    room = Solid("box", [0, 0, half[2]], half, np.eye(3), None)
    solids.append(room)
    tops = [(np.zeros(2), half[:2] * 0.6, 0.0)]
    if rng.random() < 0.6:
        top, height = np.array([rng.uniform(0.4, 1.0), rng.uniform(0.4, 1.0)]), rng.uniform(0.3, 0.8)
        turn = rotation(np.array([0, 0, 1.0]), rng.uniform(0, 3))
        solids.append(Solid("box", [0, 0, height - 0.03], [top[0], top[1], 0.03], turn, Paint(rng)))
        tops.append((np.zeros(2), top * 0.6, height))
    for _ in range(rng.integers(2, 8)):
        at, reach, z = tops[-1] if rng.random() < 0.75 else tops[0]
        kind = rng.choice(["box", "box", "ball", "cylinder", "cone"])
        size = np.exp(rng.uniform(np.log(0.08), np.log(0.4), 3))
        if kind != "box":
            size[1] = size[0] if rng.random() < 0.8 else size[1]
        turn = rotation(np.array([0, 0, 1.0]), rng.uniform(0, 6.3))
        up = size[2]
        if rng.random() < 0.25:
            turn = turn @ rotation(rng.normal(size=3), rng.uniform(0, 3))
            up = size.max() * 0.8
        xy = at + rng.uniform(-1, 1, 2) * reach
        solids.append(Solid(kind, [xy[0], xy[1], z + up], size, turn, Paint(rng)))
    for _ in range(rng.integers(0, 5)):  # pictures on the walls
        wall, side = rng.integers(2), rng.choice([-1, 1])
        size, centre = np.array([0.02, 0.02, rng.uniform(0.15, 0.5)]), np.zeros(3)
        size[1 - wall] = rng.uniform(0.15, 0.6)
        centre[wall], centre[1 - wall], centre[2] = side * half[wall], rng.uniform(-0.7, 0.7) * half[1 - wall], rng.uniform(0.8, 1.6)
        solids.append(Solid("box", centre, size, np.eye(3), Paint(rng)))
    return solids, half


def camera_rays(rng, half, width, height, about=None, span=0):
    """A camera that looks at the middle of the room, or at `about` from where `span` to each side is in the picture. -> eye [3], directions [h*w,3] with z = 1 in the camera, camera-from-world axes."""
    target = np.array([rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), rng.uniform(0.2, 0.9)])
    if about is not None:
        target = about + 0.3 * (target - [0, 0, 0.55])
    azimuth, elevation, distance = rng.uniform(0, 6.3), rng.uniform(-0.05, 0.9), rng.uniform(0.9, 2.2)
    distance = max(distance, 3.5 * span)
    eye = target + distance * np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    eye = np.clip(eye, [-half[0] + 0.1, -half[1] + 0.1, 0.1], [half[0] - 0.1, half[1] - 0.1, 2 * half[2] - 0.1])
    forward = target - eye
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    roll = rotation(forward, rng.normal() * 0.06)
    right = roll @ right
    axes = np.stack([right, np.cross(forward, right), forward])
    focal = rng.uniform(0.75, 1.3) * width
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    return eye, np.stack([x.ravel() / focal, y.ravel() / focal, np.ones(width * height)], 1) @ axes, axes


def surface(solids, walls, o, d):
    """First hits of rays: t, point, normal against the ray, which solid, (albedo, gloss, power). `walls`: paints of floor, walls, ceiling."""
    t, normal, which = first_hit(solids, o, d)
    p = o + np.minimum(t, 1e3)[:, None] * d
    normal = np.where((normal * d).sum(1, keepdims=True) > 0, -normal, normal)
    albedo, gloss, power = np.zeros_like(d), np.zeros(len(d)), np.ones(len(d))
    for i, s in enumerate(solids):
        for part, paint in enumerate(walls if i == 0 else [s.paint]):
            mine = which == i
            if i == 0:
                mine = mine & ((normal[:, 2] > 0.5) if part == 0 else (normal[:, 2] < -0.5) if part == 2 else (np.abs(normal[:, 2]) < 0.5))
            if mine.any():
                albedo[mine] = paint(p[mine] - s.centre)
                gloss[mine], power[mine] = paint.gloss, paint.power
    return t, p, normal, which, (albedo, gloss, power)


class Light:
    """Light from all around, a little more from one side, and one to three lamps; the first two cast shadows."""

    def __init__(self, rng, half):
        sky = rng.normal(size=3)
        self.sky, self.ambient = sky / np.linalg.norm(sky), rng.uniform(0.15, 0.6)
        self.lamps = []
        for _ in range(rng.integers(1, 4)):
            at = np.array([rng.uniform(-0.9, 0.9) * half[0], rng.uniform(-0.9, 0.9) * half[1], rng.uniform(0.9, 1.95) * half[2]])
            self.lamps.append((at, rng.uniform(0.4, 2.0) * (1 + rng.normal(size=3) * 0.08) * 3))

    def radiance(self, blockers, p, normal, d, paint):
        albedo, gloss, power = paint
        view = -d / np.linalg.norm(d, axis=1, keepdims=True)
        light = (self.ambient * (1 + 0.4 * (normal @ self.sky)))[:, None] * np.ones(3)
        shine = np.zeros_like(d)
        for k, (lamp, strength) in enumerate(self.lamps):
            to = lamp - p
            far = np.linalg.norm(to, axis=1, keepdims=True)
            to = to / far
            strength = strength / (1 + far**2)
            facing = np.maximum((normal * to).sum(1), 0)
            if k < 2 and blockers:
                start = p + 1e-3 * normal
                s, _, _ = first_hit(blockers, start, lamp - start)
                facing = np.where(s < 0.999, 0.0, facing)
            light = light + facing[:, None] * strength
            between = to + view
            between /= np.linalg.norm(between, axis=1, keepdims=True)
            shine += (np.maximum((normal * between).sum(1), 0) ** power * gloss * (facing > 0))[:, None] * strength
        return albedo * light + shine


def developed(rng, radiance):
    """Exposure, white balance, sRGB, noise."""
    radiance = radiance * (rng.uniform(0.35, 0.75) / max(np.percentile(radiance, 90), 1e-3))
    radiance *= 1 + rng.normal(size=3) * 0.05
    return np.clip(np.clip(radiance, 0, 1) ** (1 / 2.2) + rng.normal(size=radiance.shape) * rng.uniform(0, 0.015), 0, 1)


def render(seed, width, height):
    """-> rgb [h,w,3] in [0,1] (sRGB), normal [h,w,3]."""
    rng = np.random.default_rng(seed)
    solids, half = random_solids(rng)
    walls = [Paint(rng) for _ in range(3)]
    eye, d, axes = camera_rays(rng, half, width, height)
    _, p, normal, _, paint = surface(solids, walls, np.broadcast_to(eye, d.shape), d)
    radiance = Light(rng, half).radiance(solids[1:], p, normal, d, paint)
    shape = (height, width, 3)
    return developed(rng, radiance).reshape(shape).astype(np.float32), (normal @ axes.T).reshape(shape).astype(np.float32)
