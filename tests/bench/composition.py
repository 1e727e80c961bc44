#!/usr/bin/env python3
"""Two trained gallery scenes, composed and relit, against the path tracer.

    G="build/bin/vitrine-generate gallery --size 192x144"
    $G --seed 1 -o host && $G --seed 5 -o guest
    for step in geometry relit; do $G --seed 1 --guest 5 --guest-place 0.36,-0.28,20,0.6 --only $step -o both; done
    for s in host guest; do build/bin/vitrine run $s/photos -o run_$s --poses $s/truth/transforms.json --preset preview --set optimize.layers=diffuse \\
        --set optimize.iterations=900 --set optimize.max_gaussians=20000; done
    tests/bench/composition.py --place=0.36,-0.28,20,0.6 --box=-0.3,-0.3,0.004,0.3,0.3,0.4 --spp 16

--box: the objects of the guest in the frame of its truth (metres). For each environment of the truth it prints the PSNR (sRGB) of
  guest   the pixels of the guest in the composition, and of the objects in the guest's own scene, relit alone
  shadow  the pixels of the host that the guest changes by 10 % or more in the truth, and the same pixels of the host relit alone
Each picture is multiplied by the median of truth / ours per channel, over the guest or over the host where the guest changes nothing:
one capture does not tell how bright its albedo is. Needs ffmpeg.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
from array import array


def exr(path):
    """Pixels of an EXR file as rows of (r, g, b), linear."""
    probe = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=width,height", "-of", "csv=p=0", path], check=True, capture_output=True, text=True)
    width, height = map(int, probe.stdout.strip().split(",")[:2])
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-pix_fmt", "gbrpf32le", "-f", "rawvideo", "-"], check=True, capture_output=True).stdout
    planes = array("f", raw)
    n = width * height
    return (width, height), list(zip(planes[2 * n:3 * n], planes[:n], planes[n:2 * n]))


def inside(path):
    """Pixels of a mask: True in it."""
    return [v > 127 for v in subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-pix_fmt", "gray", "-f", "rawvideo", "-"], check=True, capture_output=True).stdout]


def srgb(v):
    v = min(max(v, 0.0), 1.0)
    return 12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055


def similarity(folder):
    s = json.loads((folder / "scene.json").read_text())["scene_from_colmap"]
    return s["scale"], s["rotation"], s["translation"]


def apply(s, p):
    return [s[0] * sum(s[1][i][k] * p[k] for k in range(3)) + s[2][i] for i in range(3)]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def place_in_scene(host, guest, place):
    """Similarity from the frame of the guest's run to that of the host's: host o place o guest^-1."""
    x, y, degrees, scale = place
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    guest_back = [list(row) for row in zip(*guest[1])]
    rotation = product(product(host[1], [[c, -s, 0], [s, c, 0], [0, 0, 1]]), guest_back)
    total = host[0] * scale / guest[0]
    origin = [-v / guest[0] for v in (sum(guest_back[i][k] * guest[2][k] for k in range(3)) for i in range(3))]
    moved = [scale * (c * origin[0] - s * origin[1]) + x, scale * (s * origin[0] + c * origin[1]) + y, scale * origin[2]]
    return total, rotation, apply(host, moved)


def axis_angle(r):
    angle = math.acos(min(max((r[0][0] + r[1][1] + r[2][2] - 1) / 2, -1), 1))
    if angle < 1e-6:
        return [0, 0, 1], 0.0
    axis = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    norm = math.hypot(*axis)
    return [v / norm for v in axis], math.degrees(angle)


def gains(pixels):
    return [statistics.median([t[c] / o[c] for t, o in pixels if o[c] > 1e-4 and t[c] > 1e-4] or [1]) for c in range(3)]


def psnr(pixels, gain):
    error = [(srgb(t[c]) - srgb(o[c] * gain[c])) ** 2 for t, o in pixels for c in range(3)]
    return -10 * math.log10(sum(error) / len(error)) if error else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", default=".", type=pathlib.Path, help="folder with host, guest, both, run_host, run_guest")
    parser.add_argument("--programs", default="build/bin", type=pathlib.Path)
    parser.add_argument("--place", required=True)
    parser.add_argument("--box", required=True)
    parser.add_argument("--spp", default="32")
    options = parser.parse_args()
    work = options.work.resolve()
    vitrine = str((options.programs / "vitrine").resolve())
    host, guest = similarity(work / "run_host"), similarity(work / "run_guest")
    scale, rotation, translate = place_in_scene(host, guest, [float(v) for v in options.place.split(",")])
    axis, angle = axis_angle(rotation)
    low_high = [float(v) for v in options.box.split(",")]
    corners = [apply(guest, [low_high[3 * i], low_high[3 * j + 1], low_high[3 * k + 2]]) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    box = [min(p[c] for p in corners) for c in range(3)] + [max(p[c] for p in corners) for c in range(3)]
    (work / "scene.yaml").write_text(f"parts:\n  - project: run_host\n  - project: run_guest\n    select: {{box: {box}}}\n    place: {{translate: {translate}, rotate: {{axis: {axis}, angle: {angle}}}, scale: {scale}}}\n")
    run = lambda *command: subprocess.run([vitrine, *map(str, command)], check=True, stdout=sys.stderr)
    run("compose", work / "scene.yaml", "-o", work / "composed")
    total = {"guest": ([], []), "shadow": ([], [])}
    for sky in sorted(p.name for p in (work / "both/truth/relit").iterdir()):
        for project, truth in (("composed", "both"), ("run_host", "host"), ("run_guest", "guest")):
            run("relight", work / project, "--env", work / truth / f"truth/env/{sky}.exr", "--views", "all", "--spp", options.spp, "--no-progress")
        guest_pixels, own_pixels, steady, alone_steady, shadow, alone_shadow = [], [], [], [], [], []
        picture = lambda project, stem: exr(work / project / "relit" / sky / f"{stem}.exr")[1]
        for path in sorted((work / "both/truth/relit" / sky).glob("*.exr")):
            stem = path.stem
            _, truth = exr(path)
            _, without = exr(work / "host/truth/relit" / sky / path.name)
            mask = inside(work / f"both/truth/mask/object/{stem}.png")
            ours, alone = picture("composed", stem), picture("run_host", stem)
            for t, w, m, o, a in zip(truth, without, mask, ours, alone):
                if m:
                    guest_pixels.append((t, o))
                elif max(abs(t[c] - w[c]) for c in range(3)) > 0.1 * max(*w, 1e-3):
                    shadow.append((t, o)), alone_shadow.append((w, a))
                else:
                    steady.append((t, o)), alone_steady.append((w, a))
        for path in sorted((work / "guest/truth/relit" / sky).glob("*.exr")):
            _, truth = exr(path)
            mask = inside(work / f"guest/truth/mask/object/{path.stem}.png")
            own_pixels += [(t, o) for t, m, o in zip(truth, mask, picture("run_guest", path.stem)) if m]
        rows = {"guest": (psnr(guest_pixels, gains(guest_pixels)), psnr(own_pixels, gains(own_pixels)), len(guest_pixels)),
                "shadow": (psnr(shadow, gains(steady)), psnr(alone_shadow, gains(alone_steady)), len(shadow))}
        for region, (composed, alone, count) in rows.items():
            print(f"{sky:10s} {region:7s} composed {composed:5.2f} dB, alone {alone:5.2f} dB, {count} pixels")
            total[region][0].append(composed), total[region][1].append(alone)
    for region, (composed, alone) in total.items():
        print(f"mean       {region:7s} composed {statistics.mean(composed):5.2f} dB, alone {statistics.mean(alone):5.2f} dB")


if __name__ == "__main__":
    main()
