#include "stages/normals/geometric.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/observe/stereo/known_depth.h"
#include "core/observe/stereo/patch_match.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr size_t kNeighbours = 6;          // matching partners per photo
constexpr double kFarFactor = 3;           // search range beyond the farthest sparse points
constexpr float kObjectConfidence = 0.5f;  // of the normals of glass, mirrors and coats
constexpr float kFullAgreement = 3;        // consistent neighbours for full confidence
constexpr float kConvincingAlone = 0.9f;   // NCC required of a depth without a consistency check
constexpr float kOnMirror = 0.3f;          // stereo on an object whose surface it probably does not measure

std::vector<StereoPhoto> stereo_photos(const GeometricDesc& desc) {
  const ViewSet& set = desc.capture.set;
  std::vector<bool> wanted(set.views.size(), false), loaded(set.views.size(), false);
  for (uint32_t v : desc.views) wanted[v] = loaded[v] = true;
  std::vector<StereoPhoto> photos(set.views.size());
  const auto partners = stereo_neighbours(set, desc.capture.helpers, kNeighbours);
  for (uint32_t v = 0; v < photos.size(); ++v) {
    if (!wanted[v]) continue;
    photos[v].neighbours = partners[v];
    if (photos[v].neighbours.empty()) {  // held out: not a partner for others, but may use others
      std::vector<uint32_t> with_it = desc.capture.helpers;
      with_it.insert(std::upper_bound(with_it.begin(), with_it.end(), v), v);
      photos[v].neighbours = stereo_neighbours(set, with_it, kNeighbours)[v];
    }
    for (uint32_t n : photos[v].neighbours) loaded[n] = true;
  }
  parallel_for(photos.size(), 1, [&](size_t v) {
    if (!loaded[v] || interrupt_signal() != 0) return;
    photos[v].view = set.views[v];
    photos[v].view.intrinsics = set.views[v].intrinsics.limited_to(desc.max_side);
    const Intrinsics& k = photos[v].view.intrinsics;
    photos[v].luma = luma_of_srgb(desc.capture.photo(v, k.width, k.height));
  });
  throw_if_interrupted();
  find_depth_ranges(set, kFarFactor, photos);
  return photos;
}

// In batches, for progress and interrupts.
std::vector<DepthMap> matched_depths(std::vector<StereoPhoto>& photos, const std::function<void(double)>& progress) {
  const size_t batch = 4 * size_t(thread_limit());  // the results do not depend on it
  std::vector<std::vector<uint32_t>> partners(photos.size());
  for (size_t v = 0; v < photos.size(); ++v) partners[v].swap(photos[v].neighbours);
  std::vector<DepthMap> depths(photos.size());
  for (size_t begin = 0; begin < photos.size(); begin += batch) {
    const size_t end = std::min(begin + batch, photos.size());
    for (size_t v = begin; v < end; ++v) photos[v].neighbours = partners[v];
    std::vector<DepthMap> some = patch_match(photos, {});
    for (size_t v = begin; v < end; ++v) {
      depths[v] = std::move(some[v]);
      photos[v].neighbours.clear();
    }
    throw_if_interrupted();
    progress(double(end) / double(photos.size()));
  }
  for (size_t v = 0; v < photos.size(); ++v) photos[v].neighbours = std::move(partners[v]);
  return depths;
}

// Weight of a depth: the number of consistent photos; if consistency was not computed (`confirmed` false), its NCC.
DepthSamples depth_samples(const DepthMap& map, bool confirmed) {
  DepthSamples samples{map.width, map.height, std::vector<float>(map.zdepth.size()), std::vector<float>(map.zdepth.size())};
  for (size_t i = 0; i < map.zdepth.size(); ++i) {
    samples.inverse_z[i] = 1 / map.zdepth[i];
    if (confirmed)
      samples.weight[i] = std::min(float(map.agreeing[i]), kFullAgreement) / kFullAgreement * std::max(0.f, map.score[i]);
    else
      samples.weight[i] = map.score[i] >= kConvincingAlone ? 1.f : 0.f;
  }
  return samples;
}

// The user's depth maps at the size of the matched photos, with normals fitted to them alone.
std::vector<KnownDepth> known_depths(const NormalCapture& capture, std::span<const StereoPhoto> photos) {
  std::vector<KnownDepth> known(photos.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    if (capture.depth[v].empty() || photos[v].luma.empty() || interrupt_signal() != 0) return;
    const Intrinsics& k = photos[v].view.intrinsics;
    KnownDepth& of = known[v];
    of.zdepth = resized_depth(capture.depth[v], k.width, k.height);
    DepthSamples samples{k.width, k.height, std::vector<float>(k.pixel_count()), std::vector<float>(k.pixel_count())};
    for (size_t i = 0; i < k.pixel_count(); ++i)
      if (const float z = of.zdepth.data()[i]; z > 0) samples.inverse_z[i] = 1 / z, samples.weight[i] = 1;
    NormalMap normals = fitted_normals(samples, photos[v].luma, k);
    forget_hidden_sides(normals, k);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) of.normal.push_back(normals.at(x, y));
  });
  throw_if_interrupted();
  return known;
}

// Writes the normals of the objects' shapes to their pixels. Stereo measures the wrong surface behind glass and perhaps on a
// mirror; on paint under a coat it works, and the normals of a visual hull are no better.
void put_objects(const GeometricDesc& desc, const View& view, const View& photo, NormalMap& map) {
  const Intrinsics& k = view.intrinsics;
  const ObjectSet& set = desc.capture.objects.objects();
  const Image16 labels = desc.capture.objects.labels(photo, k);
  if (labels.empty()) return;
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Object* object = set.find(labels.at(x, y));
      if (object == nullptr) continue;
      const Ray ray{eye, view.ray(x + 0.5, y + 0.5)};
      const auto hit = set.shapes.first_hit(ray, shape_role(object->role), [&](const ShapeSet::Hit& h) {
        return set.shapes.entries[h.entry].object == object->id;
      });
      if (hit && object->role == ObjectRole::Coat && !set.shapes.entries[hit->entry].exact) continue;
      if (hit)
        map.set(x, y, cast<float>(view.cam_from_world.rotation * hit->normal), kObjectConfidence);
      else if (is_glass(object->role))
        map.forget(x, y);
      else
        map.confidence.at(x, y) *= kOnMirror;
    }
}

}  // namespace

ImageF NormalCapture::photo(size_t view, int width, int height) const {
  const View& v = set.views[view];
  const fs::path path = linear_image_path(sfm, v);
  const ImageF linear = read_exr_rgb(path);
  if (linear.width() != v.intrinsics.width || linear.height() != v.intrinsics.height)
    throw Error(ErrorKind::Input, "a photo and its camera have different sizes",
                {.where = path.string(),
                 .why = fmt::format("the file has {} x {} pixels, the camera model {} x {}", linear.width(), linear.height(),
                                    v.intrinsics.width, v.intrinsics.height),
                 .hint = "run the sfm stage again",
                 .code = "SIZE_MISMATCH"});
  return srgb_from_linear_image(resized(linear, width, height));
}

NormalCapture load_normal_capture(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& objects,
                                  int holdout_every) {
  NormalCapture capture{.sfm = sfm, .objects = LabelledObjects::trusted(objects), .set = load_view_set(sfm), .helpers = {}};
  const std::vector<uint8_t> heldout = heldout_views(sfm, capture.set.views, holdout_every);
  for (uint32_t v = 0; v < capture.set.views.size(); ++v)
    if (!heldout[v]) capture.helpers.push_back(v);
  return capture;
}

std::vector<NormalMap> geometric_normals(const GeometricDesc& desc, const std::function<void(double)>& progress, size_t* alone) {
  std::vector<StereoPhoto> photos = stereo_photos(desc);
  progress(0.1);
  std::vector<DepthMap> depths = matched_depths(photos, [&](double f) { progress(0.1 + 0.65 * f); });
  // Consistency needs the depth maps of all partners.
  const bool confirmed = std::all_of(desc.capture.helpers.begin(), desc.capture.helpers.end(),
                                     [&](uint32_t v) { return !depths[v].zdepth.empty(); });
  if (confirmed) count_agreement(photos, depths);
  if (confirmed && !desc.capture.depth.empty()) join_known_depth(photos, known_depths(desc.capture, photos), depths);
  const bool objects = desc.with_objects && !desc.capture.objects.objects().empty();
  progress(0.85);
  std::vector<NormalMap> normals(desc.views.size());
  parallel_for(desc.views.size(), 1, [&](size_t i) {
    if (interrupt_signal() != 0) return;
    const uint32_t v = desc.views[i];
    const Intrinsics& k = photos[v].view.intrinsics;
    if (depths[v].zdepth.empty()) {
      if (objects) normals[i] = NormalMap(k.width, k.height);
    } else {
      normals[i] = fitted_normals(depth_samples(depths[v], confirmed), photos[v].luma, k);
    }
    if (normals[i].empty()) return;
    forget_hidden_sides(normals[i], k);
    if (objects) put_objects(desc, photos[v].view, desc.capture.set.views[v], normals[i]);
  });
  throw_if_interrupted();
  if (alone != nullptr) *alone = size_t(std::ranges::count_if(desc.views, [&](uint32_t v) { return depths[v].zdepth.empty(); }));
  progress(1);
  return normals;
}

}  // namespace vitrine
