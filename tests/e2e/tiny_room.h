// sample_data/tiny_room as a user would bring it: a copy of its photos, its exact poses, and sparse points made from its truth
// depth (structure from motion finds none in pictures of 96x64).
#pragma once

#include <cmath>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "tests/support/vitrine_process.h"

namespace vitrine {

class TinyRoom : public VitrineProcess {
 protected:
  TinyRoom() {
    unsetenv("VITRINE_STAGE_DIR");
    unsetenv("VITRINE_CONFIG_DIR");
    unsetenv("VITRINE_COLMAP");
    fs::create_directories(photos());
    for (const auto& e : fs::directory_iterator(sample() / "photos")) fs::copy_file(e.path(), photos() / e.path().filename());
  }

  static fs::path sample() { return fs::path(VITRINE_SOURCE_DIR) / "sample_data/tiny_room"; }
  static std::string true_poses() { return (sample() / "truth/transforms.json").string(); }
  fs::path photos() const final { return folder.path() / "my phötos/room"; }

  // A COLMAP model of the true poses, with a point for every sixth pixel that at least three photos see.
  std::string write_true_model() const {
    const std::vector<View> views = read_transforms_json(true_poses());
    std::vector<ImageF> depth, colour;
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, views.front().intrinsics));
    for (const View& view : views) {
      depth.push_back(read_exr(sample() / "truth/depth" / (view.stem() + ".exr")).pixels);
      colour.push_back(read_srgb(photos() / view.name));
      const auto id = static_cast<uint32_t>(model.images.size() + 1);
      model.images.push_back({id, quaternion(view.cam_from_world.rotation), view.cam_from_world.translation, 1, view.name, {}});
    }
    constexpr int kStep = 6;
    constexpr double kSameSurface = 0.02;  // relative depth
    for (size_t v = 0; v < views.size(); ++v)
      for (int y = kStep / 2; y < views[v].intrinsics.height; y += kStep)
        for (int x = kStep / 2; x < views[v].intrinsics.width; x += kStep) {
          const double z = depth[v].at(x, y, 0);
          if (!(z > 0)) continue;
          ColmapPoint3D point;
          point.id = model.points.size() + 1;
          point.position = inverse(views[v].cam_from_world) * (z * views[v].intrinsics.ray(x + 0.5, y + 0.5));
          for (size_t c = 0; c < 3; ++c) point.srgb[c] = static_cast<uint8_t>(std::lround(255 * colour[v].at(x, y, int(c))));
          std::vector<std::pair<size_t, Vec2d>> seen;
          for (size_t o = 0; o < views.size(); ++o) {
            const Intrinsics& k = views[o].intrinsics;
            const Vec3d p = views[o].cam_from_world * point.position;
            if (!(p.z > 0)) continue;
            const Vec2d pixel{k.fx * p.x / p.z + k.cx, k.fy * p.y / p.z + k.cy};
            if (pixel.x < 0 || pixel.y < 0 || pixel.x >= k.width || pixel.y >= k.height) continue;
            if (std::abs(depth[o].at(int(pixel.x), int(pixel.y), 0) - p.z) < kSameSurface * p.z) seen.push_back({o, pixel});
          }
          if (seen.size() < 3) continue;
          for (const auto& [o, pixel] : seen) {
            ColmapImage& image = model.images[o];
            point.track.push_back({image.id, static_cast<uint32_t>(image.points.size())});
            image.points.push_back({pixel.x, pixel.y, point.id});
          }
          model.points.push_back(std::move(point));
        }
    const fs::path where = folder.path() / "given model/sparse/0";
    make_folders(where);
    write_colmap_model(where, model, ColmapFormat::Text);
    return (folder.path() / "given model").string();
  }

  // A run of all stages on little, which takes seconds: what most of these tests are about are order, checkpoints, files and
  // messages. `more` comes last and wins.
  Outcome room(const std::string& poses, const std::vector<std::string>& more = {}) const {
    return call(room_words(poses, more));
  }
  std::vector<std::string> room_words(const std::string& poses, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {
        "run",          photos().string(), "-o", out().string(), "--poses", poses, "--truth", (sample() / "truth").string(),
        "--no-progress"};
    for (const char* set : {"normals.geometric.max_side=32", "optimize.iterations=60", "optimize.checkpoint_every=10",
                            "optimize.max_gaussians=3000", "optimize.initial.stereo_side=32", "mesh.resolution=32",
                            "mesh.faces=4000", "decompose.points=2000", "evaluate.relit_samples=4"})
      words.insert(words.end(), {"--set", set});
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  nlohmann::json json(const fs::path& file) const { return nlohmann::json::parse(read_file(out() / file)); }
};

}  // namespace vitrine
