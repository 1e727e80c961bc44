"""Rooms of core/observe/network/rooms with glass cases, polished metal and glazed things, and masks of what is what.

A case is a box of thin panes: light goes straight on; 2R / (1 + R) of it is mirrored where a ray enters and where it leaves, with R
the Fresnel reflectance at index 1.5. Metal mirrors with one colour, a glaze with R over its paint. What is mirrored is cast once.
"""
import os
import sys

import numpy as np

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../core/network/rooms"))
import rooms

OBJECT, TRANSPARENT, SPECULAR = range(3)  # channels of the masks
SLACK = 1e-3  # a pane that lies on something is not seen
METALS = np.array([[0.95, 0.64, 0.54], [0.75, 0.74, 0.72], [1.0, 0.8, 0.4], [0.91, 0.92, 0.92], [0.56, 0.57, 0.58]])


def fresnel(cosine):
    cosine = np.clip(cosine, 1e-3, 1)
    inside = np.sqrt(1 - (1 - cosine**2) / 2.25)
    s, p = (cosine - 1.5 * inside) / (cosine + 1.5 * inside), (1.5 * cosine - inside) / (1.5 * cosine + inside)
    return 0.5 * (s * s + p * p)


def mirrored(d, normal):
    return d - 2 * (d * normal).sum(1, keepdims=True) * normal


class Case:
    """Panes around a box that stands on z = `floor`."""

    def __init__(self, rng, at, floor, size):
        self.centre, self.size = np.array([at[0], at[1], floor + size[2]]), np.asarray(size)
        self.turn = rooms.rotation(np.array([0, 0, 1.0]), rng.uniform(0, 3))

    def hit(self, o, d):
        """-> where the rays enter and leave (FAR where they miss), normals of both panes, against the ray."""
        lo, ld = (o - self.centre) @ self.turn / self.size, d @ self.turn / self.size
        safe = np.where(np.abs(ld) < 1e-9, 1e-9, ld)
        a, b = (-1 - lo) / safe, (1 - lo) / safe
        near, far = np.minimum(a, b), np.maximum(a, b)
        enter, leave = near.max(1), far.min(1)
        miss = (enter >= leave) | (leave < 1e-4)
        rows, normals = np.arange(len(d)), []
        for axis in (near.argmax(1), far.argmin(1)):
            n = np.zeros_like(d)
            n[rows, axis] = -np.sign(ld[rows, axis])
            normals.append(n @ self.turn.T)
        return np.where(miss | (enter < 1e-4), rooms.FAR, enter), np.where(miss, rooms.FAR, leave), normals


    def edges(self, rng):
        """Bars where panes meet: a polished edge shines, a frame does not."""
        thick, paint = np.exp(rng.uniform(np.log(0.0015), np.log(0.008))), rooms.Paint(rng)
        paint.kind, paint.colours = "flat", np.tile(rng.choice([0.9, 0.8, 0.4, 0.1]) * rng.uniform(0.8, 1, 3), (4, 1))
        for axis in range(3):
            for one in (-1, 1):
                for other in (-1, 1):
                    if axis < 2 and other < 0:  # below, the floor is
                        continue
                    corner = np.zeros(3)
                    corner[[(axis + 1) % 3, (axis + 2) % 3] if axis != 1 else [0, 2]] = [one, other]
                    size = np.full(3, thick)
                    size[axis] = self.size[axis]
                    yield rooms.Solid("box", self.centre + self.turn @ (corner * self.size), size, self.turn, paint)


class Scene:
    """A room's solids (the room first), and of each: metal's colour or None, whether it is glazed, whether it stands on something."""

    def __init__(self, rng):
        self.solids, self.half = rooms.random_solids(rng)
        self.cases, self.about, self.span = [], None, 0
        self.metal, self.glazed, self.stands = ([None] * len(self.solids) for _ in range(3))
        table = next((s for s in self.solids[1:] if abs(s.world_from_local[2, 2] - 0.03) < 1e-9), None)
        things = [i for i, s in enumerate(self.solids) if i and s is not table and np.diag(s.world_from_local).min() != 0.02]
        for i in things:
            kind = rng.random()
            self.stands[i] = True
            self.glazed[i] = 0.25 < kind < 0.4
            self.metal[i] = METALS[rng.integers(len(METALS))] * rng.uniform(0.8, 1) if kind < 0.25 else None
        if things and rng.random() < 0.8:
            self._show(rng, self.solids[things[rng.integers(len(things))]], table)
        elif things:
            self.about = self.solids[things[0]].centre

    def _add(self, solid):
        for held, value in ((self.solids, solid), (self.metal, None), (self.glazed, False), (self.stands, True)):
            held.append(value)

    def _show(self, rng, inside, table):
        """Puts a case around a thing, often on a plinth."""
        extent = np.abs(inside.world_from_local).sum(1)
        floor = table.centre[2] + 0.03 if table is not None and inside.centre[2] - 0.5 * extent[2] > table.centre[2] else 0.0
        reach = extent[:2].max() * rng.uniform(1.05, 1.8)
        size = np.array([reach * rng.uniform(0.8, 1.3), reach * rng.uniform(0.8, 1.3), extent[2] * rng.uniform(1.05, 1.6)])
        rise = rng.uniform(0.01, 0.08) if rng.random() < 0.7 else 0
        case = Case(rng, inside.centre, floor + rise, size)
        if rise:
            self._add(rooms.Solid("box", [*inside.centre[:2], floor + rise / 2], [size[0] * 1.05, size[1] * 1.05, rise / 2], case.turn, rooms.Paint(rng)))
        if rng.random() < 0.6:
            for bar in case.edges(rng):
                self._add(bar)
        self.cases.append(case)
        if rng.random() < 0.8:
            self.about, self.span = case.centre, size.max() * rng.uniform(0.8, 1.6)


def render(seed, width, height):
    """-> rgb [h,w,3] in [0,1] (sRGB), masks [h,w,3] of 0 and 1: object, transparent, specular."""
    rng = np.random.default_rng(seed)
    scene = Scene(rng)
    solids, half = scene.solids, scene.half
    walls = [rooms.Paint(rng) for _ in range(3)]
    eye, d, _ = rooms.camera_rays(rng, half, width, height, scene.about, scene.span)
    light = rooms.Light(rng, half)
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    colours = np.array([m if m is not None else np.zeros(3) for m in scene.metal])
    is_metal, is_glazed = np.array([m is not None for m in scene.metal]), np.array(scene.glazed, bool)
    window = rng.uniform(0, 6) if rng.random() < 0.6 else 0  # ceilings that shine are seen best in glass
    window_at, window_size = rng.uniform(-0.5, 0.5, 2) * half[:2], rng.uniform(0.2, 0.5, 2) * half[:2]

    def seen(o, d, shadows, bounces):
        t, p, normal, which, paint = rooms.surface(solids, walls, o, d)
        radiance = light.radiance(solids[1:] if shadows else [], p, normal, d, paint)
        shines = (which == 0) & (normal[:, 2] < -0.5) & (np.abs(p[:, :2] - window_at) < window_size).all(1)
        radiance[shines] += window
        if not bounces:
            return np.where(is_metal[which][:, None], colours[which] * light.ambient, radiance), t, which
        m = np.flatnonzero(is_metal[which] | is_glazed[which])
        if len(m):
            cosine = np.abs((normal[m] * d[m]).sum(1))[:, None]
            mirror, _, _ = seen(p[m] + 1e-3 * normal[m], mirrored(d[m], normal[m]), False, bounces - 1)
            k = is_metal[which[m]][:, None]
            share = np.where(k, colours[which[m]] + (1 - colours[which[m]]) * (1 - cosine) ** 5, fresnel(cosine))
            radiance[m] = np.where(k, 0, (1 - share) * radiance[m]) + share * mirror
        return radiance, t, which

    o = np.broadcast_to(eye, d.shape)
    radiance, t, which = seen(o, d, True, 1)
    masks = np.zeros((len(d), 3), bool)
    masks[:, OBJECT] = np.array(scene.stands, bool)[which]
    masks[:, SPECULAR] = is_metal[which] | is_glazed[which]
    panes = []
    for case in scene.cases:
        enter, leave, (near, far) = case.hit(o, d)
        panes += [(enter, near), (leave, far)]
        masks[:, TRANSPARENT] |= (enter < t) | ((leave < t - SLACK) & (enter == rooms.FAR))
    for at, normal in sorted(panes, key=lambda pane: -np.median(pane[0])):  # from the back
        g = np.flatnonzero(at < t - SLACK)
        if not len(g):
            continue
        cosine = -(normal[g] * d[g]).sum(1)
        share = fresnel(np.abs(cosine))[:, None]
        share = 2 * share / (1 + share)
        mirror, _, _ = seen(o[g] + at[g][:, None] * d[g] + 1e-3 * normal[g], mirrored(d[g], normal[g]), False, 1)
        radiance[g] = (1 - share) * radiance[g] + share * mirror
    masks[:, OBJECT] |= masks[:, TRANSPARENT]
    masks[:, SPECULAR] |= masks[:, TRANSPARENT]
    shape = (height, width, 3)
    return rooms.developed(rng, radiance).reshape(shape).astype(np.float32), masks.reshape(shape)
