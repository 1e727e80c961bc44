// A red ball of radius 0.3 on a grey chequered ground, seen from around, on disk as the sfm stage leaves it.
#pragma once

#include "tests/stages/masks/tiny_masks.h"
#include "tests/support/recording_context.h"

namespace vitrine::test {

struct BallCapture {
  static constexpr int kViews = 10, kWidth = 96, kHeight = 72;
  static constexpr double kFocal = 90, kBall = 0.3;

  explicit BallCapture(int count = kViews) {
    ColmapModel model;
    const Intrinsics k{kWidth, kHeight, kFocal, kFocal, kWidth / 2.0, kHeight / 2.0};
    model.cameras.push_back(colmap_pinhole(1, k));
    Gains gains;
    for (int i = 0; i < count; ++i) {
      View view;
      view.name = fmt::format("v{}.jpg", i);
      view.intrinsics = k;
      const double angle = 2 * std::numbers::pi * i / count;
      const Vec3d eye{std::cos(angle), std::sin(angle), 0.4}, forward = normalized(-eye);
      const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
      view.cam_from_world = inverse(Rigid{Mat3d{right, down, forward}, eye});
      views.push_back(view);
      truth.emplace_back(kWidth, kHeight, 1);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
          truth.back().at(x, y) = length(eye - dot(eye, d) * d) < kBall ? 255 : 0;
        }
      write_photo(size_t(i), truth.back());
      model.images.push_back(
          {uint32_t(i + 1), quaternion(view.cam_from_world.rotation), view.cam_from_world.translation, 1, view.name, {}});
      gains[view.name] = {1, 1, 1};
    }
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm() / "sfm/gains.json", gains);
    write_scene_info(sfm() / "scene.json", {});
  }
  fs::path sfm() const { return folder.path() / "sfm"; }
  // Red where `ball` is white.
  void write_photo(size_t view, const Image8& ball) const {
    ImageF photo(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c)
          photo.at(x, y, c) = ball.at(x, y) ? (c == 0 ? 0.6f : 0.05f) : (x / 4 + y / 4) % 2 ? 0.2f : 0.3f;
    write_exr_rgb(linear_image_path(sfm(), views[view]), photo);
  }
  double overlap_of(const RecordingContext& context, const std::string& kind, size_t view) const {
    return overlap(read_grey8(context.output() / "masks" / kind / (views[view].stem() + ".png")), truth[view]);
  }
  double worst_overlap(const RecordingContext& context, const std::string& kind) const {
    double worst = 1;
    for (size_t v = 0; v < views.size(); ++v) worst = std::min(worst, overlap_of(context, kind, v));
    return worst;
  }

  TemporaryFolder folder;
  std::vector<View> views;
  std::vector<Image8> truth;
};

}  // namespace vitrine::test
