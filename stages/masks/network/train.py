"""Trains a small network on cases.py that tells objects, glass and mirrors from one photo. Needs numpy, python3-torch, python3-onnx.

    python3 train.py --out cases.onnx [--scenes 900] [--minutes 6] [--cache DIR]

A U-Net of what OpenCV's dnn 4.6 computes rightly: convolutions (batch normalisation is folded into them), ReLU, nearest resizing,
concatenation. Input: a photo of 192x144. Output: logits of object, transparent, specular at half that size.
"""
import argparse
import os
import time

import numpy as np
import torch
import torch.nn as nn
import torch.nn.functional as F

import cases

WIDTH, HEIGHT = 192, 144
VALIDATION = 80  # scenes; their seeds lie far from those of training
FIRST_VALIDATION_SEED = 1_000_000
CLASSES = ("object", "transparent", "specular")


def block(inputs, outputs, stride=1, reach=1, size=3):
    convolution = nn.Conv2d(inputs, outputs, size, stride, reach * (size // 2), dilation=reach, bias=False)
    return nn.Sequential(convolution, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


class CaseNet(nn.Module):
    def __init__(self, widths=(16, 28, 40, 56)):
        super().__init__()
        a, b, c, d = widths
        self.stem = nn.Sequential(block(3, a, stride=2, size=5), block(a, a))  # 1/2
        self.down = nn.ModuleList([nn.Sequential(block(i, o, 2), block(o, o)) for i, o in ((a, b), (b, c), (c, d))])
        self.middle = nn.Sequential(block(d, d, reach=2), block(d, d, reach=4), block(d, d, reach=2))  # 1/16
        self.up = nn.ModuleList([block(i + o, o) for i, o in ((d, c), (c, b), (b, a))])
        self.head = nn.Conv2d(a, len(CLASSES), 3, 1, 1)

    def forward(self, x):
        x = self.stem(x)
        skips = []
        for down in self.down:
            skips.append(x)
            x = down(x)
        x = self.middle(x)
        for up in self.up:
            x = up(torch.cat([F.interpolate(x, scale_factor=2.0, mode="nearest"), skips.pop()], 1))
        return self.head(x)


def loss_of(logits, masks):
    p = torch.sigmoid(logits)
    both, all_ = (p * masks).sum((2, 3)), (p + masks).sum((2, 3))
    return F.binary_cross_entropy_with_logits(logits, masks) + 0.3 * (1 - (2 * both + 20) / (all_ + 20)).mean()


def as_input(rgb):
    return (rgb - 0.5) / 0.25


def data(first_seed, count, cache):
    path = os.path.join(cache, f"cases_{first_seed}_{count}.npz") if cache else ""
    if path and os.path.exists(path):
        stored = np.load(path)
        return stored["rgb"], stored["masks"]
    rgb = np.empty((count, 3, HEIGHT, WIDTH), np.uint8)
    masks = np.empty((count, 3, HEIGHT // 2, WIDTH // 2), np.uint8)
    for i in range(count):
        picture, m = cases.render(first_seed + i, WIDTH, HEIGHT)
        rgb[i] = np.round(picture.transpose(2, 0, 1) * 255)
        masks[i] = np.round(m.reshape(HEIGHT // 2, 2, WIDTH // 2, 2, 3).mean((1, 3)).transpose(2, 0, 1) * 4)
    if path:
        np.savez(path, rgb=rgb, masks=masks)
    return rgb, masks


def tensors(rgb, masks):
    return torch.from_numpy(rgb).float() / 255, torch.from_numpy(masks).float() / 4


def augmented(rgb, masks, generator):
    if torch.rand((), generator=generator) < 0.5:
        rgb, masks = rgb.flip(3), masks.flip(3)
    n = len(rgb)
    gamma = torch.exp(torch.empty(n, 1, 1, 1).uniform_(-0.4, 0.4, generator=generator))
    gain = torch.empty(n, 3, 1, 1).uniform_(0.8, 1.15, generator=generator)
    grey = torch.empty(n, 1, 1, 1).uniform_(0, 0.6, generator=generator)
    rgb = rgb.clamp(1e-4, 1) ** gamma * gain
    return (rgb + grey * (rgb.mean(1, keepdim=True) - rgb)).clamp(0, 1), masks


def overlaps(net, rgb, masks):
    """Intersection over union at one half, of all pixels of all pictures, per class."""
    net.eval()
    both, either = torch.zeros(3), torch.zeros(3)
    with torch.no_grad():
        for i in range(0, len(rgb), 16):
            x, m = tensors(rgb[i : i + 16], masks[i : i + 16])
            found, true = net(as_input(x)) > 0, m > 0.5
            both += (found & true).float().sum((0, 2, 3))
            either += (found | true).float().sum((0, 2, 3))
    net.train()
    return (both / either.clamp(min=1)).tolist()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", required=True)
    parser.add_argument("--scenes", type=int, default=900)
    parser.add_argument("--minutes", type=float, default=6, help="processor time of the training itself")
    parser.add_argument("--cache", default="")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(1)
    generator = torch.Generator().manual_seed(2)
    rgb, masks = data(0, arguments.scenes, arguments.cache)
    held = data(FIRST_VALIDATION_SEED, VALIDATION, arguments.cache)
    print(f"{len(rgb)} scenes, {time.process_time():.0f} s of processor time", flush=True)
    net = CaseNet()
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
        x, m = augmented(*tensors(rgb[index], masks[index]), generator)
        loss = loss_of(net(as_input(x)), m)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        total, step = total + loss.item(), step + 1
        if step % 50 == 0:
            print(f"step {step}  {used:.0f} s  loss {total / 50:.3f}", flush=True)
            total = 0.0
    for name, overlap in zip(CLASSES, overlaps(net, *held)):
        print(f"unseen scenes: {name} IoU {overlap:.3f}")
    net.eval()
    torch.onnx.export(net, torch.zeros(1, 3, HEIGHT, WIDTH), arguments.out, opset_version=12, input_names=["photo"],
                      output_names=["logits"], do_constant_folding=True)


if __name__ == "__main__":
    main()
