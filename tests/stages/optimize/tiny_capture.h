// A known scene of surfels (a chequered floor and a coloured ball) that our own renderer photographs, written as an sfm
// artifact: truth to train against, small enough for a test.
#pragma once

#include <cmath>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/render/model/layered_model.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/surfels/activation.h"

namespace vitrine::testing {

inline void add_surfel(SplatLayer& layer, Vec3d position, Vec3d normal, double scale, Vec3f color) {
  const size_t i = layer.size();
  layer.resize(i + 1);
  const Vec3d n = normalized(normal), helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
  const Vec3d u = normalized(cross(helper, n));
  const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
  const double rotation[] = {q.w, q.x, q.y, q.z};
  for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
  for (size_t c = 0; c < 3; ++c) {
    layer.at(Attribute::Mean, i)[c] = float(position[c]);
    layer.at(Attribute::ShDc, i)[c] = (color[c] - 0.5f) / kShDc;
  }
  for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(scale));
  *layer.at(Attribute::Opacity, i) = logit(0.95f);
}

inline constexpr int kTinyBall = 150;  // the surfels of the ball; they are the last ones

inline SplatLayer tiny_scene(int ball = kTinyBall) {
  SplatLayer layer(LayerKind::Diffuse, 0, 0);
  for (int y = -8; y <= 8; ++y)
    for (int x = -8; x <= 8; ++x) {
      const bool dark = (x / 2 + y / 2) % 2 == 0;
      add_surfel(layer, {0.1 * x, 0.1 * y, -0.3}, {0, 0, 1}, 0.06, dark ? Vec3f{0.05f, 0.1f, 0.3f} : Vec3f{0.7f, 0.6f, 0.4f});
    }
  for (int i = 0; i < ball; ++i) {  // Fibonacci points
    const double z = 1 - 2 * (i + 0.5) / ball, angle = i * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    const Vec3d n{r * std::cos(angle), r * std::sin(angle), z};
    add_surfel(layer, 0.25 * n, n, 0.03 * std::sqrt(double(kTinyBall) / ball),
               {float(0.5 + 0.4 * n.x), float(0.5 + 0.4 * n.y), float(0.4 + 0.3 * n.z)});
  }
  return layer;
}

inline std::vector<View> ring_of_views(int count, int width, int height) {
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count, height_above = 0.35 + 0.25 * (i % 3);
    const Vec3d eye{std::cos(angle), std::sin(angle), height_above}, forward = normalized(-eye);
    const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
    View view;
    view.name = fmt::format("view_{:02}.png", i);
    view.intrinsics = {width, height, 0.9 * width, 0.9 * width, 0.5 * width, 0.5 * height};
    view.cam_from_world = inverse(Rigid{Mat3d{right, down, forward}, eye});
    view.gain = i % 2 ? Vec3d{1.1, 1.0, 0.9} : Vec3d{1 / 1.1, 1.0, 1 / 0.9};
    views.push_back(view);
  }
  return views;
}

// The tiny scene with a polished ball and what it shows: the floor, and a dome of bright patches that no camera sees directly.
// A curved mirror, because a flat one is a window: a diffuse layer alone explains it by surfels behind it.
inline SplatScene tiny_mirror_scene() {
  constexpr int kSmoothBall = 600;
  SplatScene scene{.diffuse = tiny_scene(kSmoothBall)};
  const size_t first = scene.diffuse.size() - kSmoothBall;
  for (size_t i = 0; i < scene.diffuse.size(); ++i) {
    const bool mirror = i >= first;
    if (mirror) std::fill_n(scene.diffuse.at(Attribute::ShDc, i), 3, -0.48f / kShDc);
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission}) {
      const bool high = mirror && (a == Attribute::F0 || a == Attribute::SpecularWeight);
      std::fill_n(scene.diffuse.at(a, i), scene.diffuse.width(a), logit(high ? 0.95f : 0.002f));
    }
  }
  SplatLayer shown = tiny_scene();
  shown.resize(first);
  constexpr int kAround = 32, kUp = 8;
  for (int e = 0; e < kUp; ++e)
    for (int a = 0; a < kAround; ++a) {
      const double azimuth = 2 * std::numbers::pi * a / kAround, elevation = 0.5 * std::numbers::pi * (e + 0.5) / kUp;
      const Vec3d out{std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
      const Vec3f colors[] = {{0.9f, 0.2f, 0.1f}, {0.9f, 0.9f, 0.5f}, {0.1f, 0.5f, 0.9f}, {0.05f, 0.05f, 0.05f}};
      add_surfel(shown, 2.0 * out, -out, 0.16, colors[(a / 8 + 2 * (e / 4)) % 4]);
    }
  scene.reflection = SplatLayer(LayerKind::Reflection, 0, shown.size());
  for (size_t i = 0; i < shown.size(); ++i)
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
      std::copy_n(shown.at(a, i), shown.width(a), scene.reflection.at(a, i));
  return scene;
}

// sparse/0, scene.json, sfm/gains.json and linear/*.exr of a scene, and masks/specular/*.png when it has a mirror. Sparse points:
// every third surfel, with noise.
inline void write_sfm_of(const fs::path& folder, const std::vector<View>& views, const SplatScene& photographed,
                         const ImageOptions& image = {}) {
  const SplatLayer& scene = photographed.diffuse;
  const int width = views.front().intrinsics.width, height = views.front().intrinsics.height;
  const LayeredModel image_model{image};
  Frame frame;
  ColmapModel model;
  Gains gains;
  for (size_t v = 0; v < views.size(); ++v) {
    View fine = views[v];  // a pixel of a photo is a mean, not a point
    const int n = photographed.reflection.size() > 0 ? 4 : 1;
    const Intrinsics& k0 = views[v].intrinsics;
    fine.intrinsics = {n * width, n * height, n * k0.fx, n * k0.fy, n * k0.cx, n * k0.cy};
    image_model.forward(photographed, fine, frame);
    ImageF photo(width, height, 3);
    const size_t pixels = photo.pixel_count(), fine_pixels = pixels * size_t(n * n);
    std::vector<float> gloss(pixels, 0.f);
    for (int y = 0; y < n * height; ++y)
      for (int x = 0; x < n * width; ++x) {
        const size_t from = size_t(y * n * width + x), to = size_t(y / n * width + x / n);
        for (size_t c = 0; c < 3; ++c)
          photo.data()[3 * to + c] += float(views[v].gain[c]) * frame.linear[c * fine_pixels + from] / float(n * n);
        if (n > 1) gloss[to] += frame.diffuse.plane(Aov::SpecularWeight)[from] / float(n * n);
      }
    write_exr_rgb(linear_image_path(folder, views[v]), photo);
    if (photographed.reflection.size() > 0) {
      Image8 mask(width, height, 1);
      for (size_t i = 0; i < pixels; ++i) mask.data()[i] = gloss[i] > 0.4f ? 255 : 0;
      write_ldr(folder / "masks/specular" / (views[v].stem() + ".png"), mask);
    }
    const Intrinsics& k = views[v].intrinsics;
    const auto id = static_cast<uint32_t>(v + 1);
    model.cameras.push_back({id, 1, uint64_t(width), uint64_t(height), {k.fx, k.fy, k.cx, k.cy}});
    model.images.push_back(
        {id, quaternion(views[v].cam_from_world.rotation), views[v].cam_from_world.translation, id, views[v].name, {}});
    gains[views[v].name] = views[v].gain;
  }
  Rng rng(5);
  for (size_t i = 0; i < scene.size(); i += 3) {
    const float* mean = scene.at(Attribute::Mean, i);
    ColmapPoint3D point;
    point.id = i + 1;
    for (size_t c = 0; c < 3; ++c) {
      point.position[c] = mean[c] + 0.01 * rng.normal();
      point.srgb[c] = static_cast<uint8_t>(100 + rng.below(60));
    }
    for (ColmapImage& image : model.images) {
      const Vec3d p = image.cam_from_world() * point.position;
      const Intrinsics& k = views[image.id - 1].intrinsics;
      const double x = k.fx * p.x / p.z + k.cx, y = k.fy * p.y / p.z + k.cy;
      if (p.z <= 0 || x < 0 || y < 0 || x >= k.width || y >= k.height) continue;
      point.track.push_back({image.id, static_cast<uint32_t>(image.points.size())});
      image.points.push_back({x, y, point.id});
    }
    model.points.push_back(point);
  }
  write_colmap_model(folder / "sparse/0", model, ColmapFormat::Binary);
  write_gains(folder / "sfm/gains.json", gains);
  write_scene_info(folder / "scene.json", {});
}

inline void write_tiny_sfm(const fs::path& folder, int view_count = 9, int width = 48, int height = 36,
                           const SplatScene& photographed = {.diffuse = tiny_scene()}, const ImageOptions& image = {}) {
  write_sfm_of(folder, ring_of_views(view_count, width, height), photographed, image);
}

// A floor and a wall, 4.8 long and 1.2 wide, and views of it on a walk along y = x (the hall lies at 45 degrees to the axes).
inline SplatLayer tiny_hall() {
  SplatLayer layer(LayerKind::Diffuse, 0, 0);
  const double h = std::sqrt(0.5);
  const auto at = [&](double along, double across, double up) { return Vec3d{h * (along - across), h * (along + across), up}; };
  for (int i = -24; i <= 24; ++i)
    for (int j = -6; j < 6; ++j) {
      const bool dark = ((i + 24) / 3 + (j + 6) / 3) % 2 == 0;
      const Vec3f colour{float(0.15 + 0.015 * (i + 24)), dark ? 0.15f : 0.7f, dark ? 0.3f : 0.5f};
      add_surfel(layer, at(0.1 * i, 0.1 * j, -0.3), {0, 0, 1}, 0.06, colour);
      add_surfel(layer, at(0.1 * i, 0.6, -0.25 + 0.1 * (j + 6)), {h, -h, 0}, 0.06, {colour.z, colour.x, colour.y});
    }
  return layer;
}

inline std::vector<View> walk_along_hall(int count, int width, int height) {
  const double h = std::sqrt(0.5);
  std::vector<View> views;
  for (int i = 0; i < count; ++i) {
    const double along = -1.8 + 3.6 * i / (count - 1), turned = 0.3 * (i % 3 - 1);
    const Vec3d eye{h * (along + 0.6), h * (along - 0.6), 0.3 + 0.1 * (i % 2)};
    const Vec3d forward = normalized(Vec3d{h * (turned - 1), h * (turned + 1), -0.4});
    const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
    View view;
    view.name = fmt::format("view_{:02}.png", i);
    view.intrinsics = {width, height, 0.7 * width, 0.7 * width, 0.5 * width, 0.5 * height};
    view.cam_from_world = inverse(Rigid{Mat3d{right, down, forward}, eye});
    views.push_back(view);
  }
  return views;
}

}  // namespace vitrine::testing
