"""Trains the small normal network of this folder on the rooms of core/observe/network/rooms and writes it as ONNX. Needs numpy, python3-torch, python3-onnx.

    python3 train.py --out rooms.onnx [--scenes 1000] [--minutes 4] [--cache DIR]

A U-Net without anything that OpenCV's dnn 4.6 lacks: convolutions (batch normalisation is folded into them), ReLU, nearest
resizing, concatenation. Output: normal (x y z, not normalised, OpenCV camera frame) and kappa, at half the input's size. The loss
is the angular von Mises-Fisher likelihood of Bae, Budvytis, Cipolla, "Estimating and Exploiting the Aleatoric Uncertainty in
Surface Normal Estimation", 2021: -log(kappa^2 + 1) + kappa angle + log(1 + exp(-kappa pi)).
"""
import argparse
import os
import sys
import time

import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../core/network/rooms"))
import rooms

WIDTH, HEIGHT = 128, 96
VALIDATION = 96  # scenes; their seeds lie far from those of training
FIRST_VALIDATION_SEED = 1_000_000


def block(inputs, outputs, stride=1, reach=1, size=3):
    convolution = nn.Conv2d(inputs, outputs, size, stride, reach * (size // 2), dilation=reach, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class RoomNet(nn.Module):
    def __init__(self, widths=(24, 48, 80, 112)):
        super().__init__()
        a, b, c, d = widths
        self.stem = block(3, a, stride=2, size=5)  # 1/2
        self.down = nn.ModuleList([nn.Sequential(block(i, o, 2), block(o, o)) for i, o in ((a, b), (b, c), (c, d))])
        self.middle = nn.Sequential(block(d, d, reach=2), block(d, d, reach=4), block(d, d, reach=2))  # 1/16
        self.up = nn.ModuleList([block(i + o, o) for i, o in ((d, c), (c, b), (b, a))])
        self.head = nn.Conv2d(a, 4, 3, 1, 1)

    def forward(self, x):
        x = self.stem(x)
        skips = []
        for down in self.down:
            skips.append(x)
            x = down(x)
        x = self.middle(x)
        for up in self.up:
            x = up(torch.cat([F.interpolate(x, scale_factor=2.0, mode="nearest"), skips.pop()], 1))
        x = self.head(x)
        return torch.cat([x[:, :3], F.elu(x[:, 3:]) + 1.01], 1)


def angle(output, normal):
    cosine = (F.normalize(output[:, :3], dim=1) * normal).sum(1)
    return torch.acos(cosine.clamp(-1 + 1e-6, 1 - 1e-6))


def loss_of(output, normal):
    a, kappa = angle(output, normal), output[:, 3]
    likelihood = -torch.log(kappa**2 + 1) + kappa * a + torch.log1p(torch.exp(-kappa * np.pi))
    return likelihood.mean() + 0.5 * a.mean()


def as_input(rgb):
    return (rgb - 0.5) / 0.25


def data(first_seed, count, cache):
    path = os.path.join(cache, f"scenes_{first_seed}_{count}.npz") if cache else ""
    if path and os.path.exists(path):
        stored = np.load(path)
        return stored["rgb"], stored["normal"]
    rgb = np.empty((count, 3, HEIGHT, WIDTH), np.uint8)
    normal = np.empty((count, 3, HEIGHT // 2, WIDTH // 2), np.int8)
    for i in range(count):
        picture, n = rooms.render(first_seed + i, WIDTH, HEIGHT)
        n = n.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 3).mean((1, 3))
        n /= np.maximum(np.linalg.norm(n, axis=2, keepdims=True), 1e-6)
        rgb[i] = np.round(picture.transpose(2, 0, 1) * 255)
        normal[i] = np.round(n.transpose(2, 0, 1) * 127)
    if path:
        np.savez(path, rgb=rgb, normal=normal)
    return rgb, normal


def tensors(rgb, normal):
    return torch.from_numpy(rgb).float() / 255, F.normalize(torch.from_numpy(normal).float(), dim=1)


def augmented(rgb, normal, generator):
    if torch.rand((), generator=generator) < 0.5:
        rgb, normal = rgb.flip(3), normal.flip(3) * torch.tensor([-1.0, 1, 1]).view(1, 3, 1, 1)
    n = len(rgb)
    gamma = torch.exp(torch.empty(n, 1, 1, 1).uniform_(-0.4, 0.4, generator=generator))
    gain = torch.empty(n, 3, 1, 1).uniform_(0.85, 1.1, generator=generator)
    grey = torch.empty(n, 1, 1, 1).uniform_(0, 0.6, generator=generator)
    rgb = rgb.clamp(1e-4, 1) ** gamma * gain
    return (rgb + grey * (rgb.mean(1, keepdim=True) - rgb)).clamp(0, 1), normal


def evaluate(net, rgb, normal):
    net.eval()
    angles = []
    with torch.no_grad():
        for i in range(0, len(rgb), 16):
            x, n = tensors(rgb[i : i + 16], normal[i : i + 16])
            angles.append(torch.rad2deg(angle(net(as_input(x)), n)).flatten())
    net.train()
    a = torch.cat(angles)
    return a.mean().item(), a.median().item(), (a < 11.25).float().mean().item(), (a < 30).float().mean().item()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", required=True)
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--minutes", type=float, default=4, help="processor time of the training itself")
    parser.add_argument("--cache", default="")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(1)
    generator = torch.Generator().manual_seed(2)
    rgb, normal = data(0, arguments.scenes, arguments.cache)
    held_rgb, held_normal = data(FIRST_VALIDATION_SEED, VALIDATION, arguments.cache)
    print(f"{len(rgb)} scenes, {time.process_time():.0f} s of processor time", flush=True)
    net = RoomNet()
    print(sum(p.numel() for p in net.parameters()), "weights")
    optimiser = torch.optim.AdamW(net.parameters(), lr=3e-3, weight_decay=1e-4)
    begin, step, batch, total = time.process_time(), 0, 12, 0.0
    order = torch.randperm(len(rgb), generator=generator)
    budget = arguments.minutes * 60
    while (used := time.process_time() - begin) < budget:
        progress = used / budget
        for group in optimiser.param_groups:
            group["lr"] = 3e-3 * min(1, (step + 1) / 50) * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * progress)))
        at = step * batch % (len(order) - batch)
        if at < batch:
            order = torch.randperm(len(rgb), generator=generator)
        index = order[at : at + batch].numpy()
        x, n = augmented(*tensors(rgb[index], normal[index]), generator)
        loss = loss_of(net(as_input(x)), n)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        total, step = total + loss.item(), step + 1
        if step % 100 == 0:
            print(f"step {step}  {used:.0f} s  loss {total / 100:.3f}", flush=True)
            total = 0.0
    mean, median, within_11, within_30 = evaluate(net, held_rgb, held_normal)
    print(f"unseen scenes: mean {mean:.1f} deg, median {median:.1f}, within 11.25 {within_11:.2f}, within 30 {within_30:.2f}")
    net.eval()
    torch.onnx.export(net, torch.zeros(1, 3, HEIGHT, WIDTH), arguments.out, opset_version=12, input_names=["photo"],
                      output_names=["normal_kappa"], do_constant_folding=True)


if __name__ == "__main__":
    main()
