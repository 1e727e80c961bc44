#include "stages/optimize/initialise.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/color.h"
#include "core/observe/stereo/patch_match.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/scene/image/exr.h"

namespace vitrine {

namespace {

constexpr size_t kNeighbours = 7;
constexpr double kBeyond = 2;  // background distance, relative to the farthest searched depth

size_t level_near(const Capture& capture, int max_side) {
  size_t best = 0;
  double best_error = 1e300;
  for (size_t l = 0; l < kLevels; ++l) {
    const Intrinsics& k = capture.photos[capture.train.front()].levels[l].view.intrinsics;
    const double error = std::abs(std::log(double(k.longest_side()) / max_side));
    if (error < best_error) best_error = error, best = l;
  }
  return best;
}

// Divides by the photo's gain, so that a textureless wall has the same brightness in all photos.
ImageF luma(const PhotoLevel& photo) {
  ImageF srgb(photo.view.intrinsics.width, photo.view.intrinsics.height, 3);
  for (size_t i = 0; i < srgb.pixel_count(); ++i) {
    const Vec3f linear = linear_at(photo, i);
    for (size_t c = 0; c < 3; ++c) srgb.data()[3 * i + c] = srgb_from_linear(linear[c]);
  }
  return luma_of_srgb(srgb);
}

}  // namespace

double DenseDepth::reliable_share() const {
  size_t reliable = 0, pixels = 0;
  for (const DepthMap& map : maps) {
    pixels += map.trusted.size();
    for (uint8_t t : map.trusted) reliable += t;
  }
  return pixels > 0 ? double(reliable) / double(pixels) : 0;
}

KnownDepthOf known_depth_of(const Capture& capture, const Targets& targets, const std::optional<std::filesystem::path>& normals) {
  std::error_code ec;
  if (!normals || !std::filesystem::is_directory(*normals / "depth", ec)) return {};
  return [&capture, &targets, artifact = *normals](uint32_t photo, size_t level) {
    const std::filesystem::path file = known_depth_path(artifact, capture.view_set.views[photo]);
    const TargetLevel& target = targets.photos[photo][level];
    std::error_code missing;
    if (target.normals.empty() || !std::filesystem::exists(file, missing)) return KnownDepth{};
    const Intrinsics& k = capture.photos[photo].levels[level].view.intrinsics;
    KnownDepth known{.zdepth = resized_depth(read_exr(file).pixels, k.width, k.height),
                     .normal = std::vector<Vec3f>(k.pixel_count())};
    for (size_t i = 0; i < k.pixel_count(); ++i) {
      const Vec3f n{float(target.normals[i]), float(target.normals[k.pixel_count() + i]),
                    float(target.normals[2 * k.pixel_count() + i])};
      if (squared_length(n) > 0) known.normal[i] = normalized(n);
      for (const MaskClass kind : {MaskClass::Transparent, MaskClass::Specular})
        if (const auto& mask = target.masks[static_cast<size_t>(kind)]; !mask.empty() && mask[i] > 127)
          known.zdepth.data()[i] = 0;
    }
    return known;
  };
}

DenseDepth dense_depth(const Capture& capture, int max_side, double far_factor, uint64_t seed, const KnownDepthOf& known) {
  DenseDepth dense;
  dense.photos.resize(capture.photos.size());
  const size_t level = dense.level = level_near(capture, max_side);
  const auto neighbours = stereo_neighbours(capture.view_set, capture.train, kNeighbours);
  parallel_for(capture.train.size(), 1, [&](size_t t) {
    const uint32_t v = capture.train[t];
    StereoPhoto& photo = dense.photos[v];
    photo.view = capture.photos[v].levels[level].view;
    photo.luma = luma(capture.photos[v].levels[level]);
    photo.neighbours = neighbours[v];
  });
  find_depth_ranges(capture.view_set, far_factor, dense.photos);
  dense.background = kWithoutParallax;
  for (const StereoPhoto& photo : dense.photos) dense.background = std::max(dense.background, kBeyond * photo.far_z);
  for (StereoPhoto& photo : dense.photos) photo.background_z = dense.background;
  dense.maps = patch_match(dense.photos, {.seed = seed});
  count_agreement(dense.photos, dense.maps);
  if (known) {
    std::vector<KnownDepth> given(dense.photos.size());
    parallel_for(capture.train.size(), 1, [&](size_t t) { given[capture.train[t]] = known(capture.train[t], level); });
    join_known_depth(dense.photos, given, dense.maps);
  }
  dense.planes = scene_planes(dense.photos, dense.maps);
  const std::vector<ScenePlane> walls = bare_walls(dense.photos, dense.maps, dense.planes);
  dense.planes.insert(dense.planes.end(), walls.begin(), walls.end());
  std::vector<DepthMap> whole(dense.maps.size());
  parallel_for(dense.maps.size(), 1, [&](size_t v) {
    // Without a pixel that other photos confirm, the map is noise and has no plane to extend.
    const std::vector<uint8_t>& trusted = dense.maps[v].trusted;
    if (std::find(trusted.begin(), trusted.end(), 1) != trusted.end())
      whole[v] = extended(dense.photos, dense.maps, dense.planes, v);
  });
  dense.maps = std::move(whole);
  return dense;
}

}  // namespace vitrine
