#include "stages/objects/roles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/metrics.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/render/model/thick_glass.h"
#include "core/observe/stereo/small_stereo.h"

namespace vitrine {

namespace {

constexpr int kTrialSide = 240;  // pixels, longest side
constexpr size_t kMostPhotos = 60;
constexpr size_t kMostTried = 12;                                // photos
constexpr size_t kFewestInside = 150;                            // minimum pixels per photo
constexpr size_t kFewestPredicted = 600;                         // minimum over all photos
constexpr std::array<double, 3> kJitter{1 / 6.0, 0.5, 5 / 6.0};  // subpixel positions of the rays, per axis
constexpr double kFacing = 0.5;                   // minimum cosine: at grazing angles glass reflects and shows the room too small
constexpr float kLamp = 0.8f;                     // sRGB in all channels: a reflected lamp, which no plane predicts
constexpr double kOtherSurface = 0.04;            // relative depth
constexpr size_t kFewestSeen = 2, kMostSeen = 9;  // photos that colour a point
constexpr double kLargePlane = 0.03;              // of all surfaces: a small facet is not extended
constexpr double kLikeBent = 0.15, kClearly = 0.15;

View small_view(const View& view) {
  View out = view;
  out.intrinsics = view.intrinsics.limited_to(kTrialSide);
  out.gain = {1, 1, 1};
  return out;
}

EdgePhoto small_photo(const std::filesystem::path& sfm, const View& view) {
  EdgePhoto out{small_view(view), {}};
  ImageF linear = resized(read_exr_rgb(linear_image_path(sfm, view)), out.view.intrinsics.width, out.view.intrinsics.height);
  for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] /= static_cast<float>(view.gain[i % 3]);
  out.srgb = srgb_from_linear_image(linear);
  for (float& value : out.srgb.data()) value = std::clamp(value, 0.f, 1.f);
  return out;
}

// Loads at most kMostPhotos, evenly spread; the others stay empty.
std::vector<EdgePhoto> read_photos(const std::filesystem::path& sfm, const ViewSet& set, std::span<const uint8_t> heldout) {
  std::vector<EdgePhoto> photos(set.views.size());
  std::vector<size_t> trained;
  for (size_t v = 0; v < photos.size(); ++v)
    if (!heldout[v]) trained.push_back(v);
  const size_t stride = (trained.size() + kMostPhotos - 1) / kMostPhotos;
  parallel_for(photos.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    photos[v].view = small_view(set.views[v]);
    const auto place = std::ranges::lower_bound(trained, v);
    if (place != trained.end() && *place == v && size_t(place - trained.begin()) % stride == 0)
      photos[v] = small_photo(sfm, set.views[v]);
  });
  throw_if_interrupted();
  return photos;
}

// Colours of the scene where rays leaving an object end.
class Room {
 public:
  Room(const Surroundings& scene, std::span<const std::vector<uint8_t>> marked) : scene_(scene), marked_(marked) {}

  std::optional<Vec3f> colour(const Ray& ray) const {
    const std::optional<Vec3d> place = end_of(ray);
    if (!place) return std::nullopt;
    std::array<std::vector<float>, 3> seen;  // [channel] values by photo
    const size_t stride = std::max<size_t>(1, scene_.photos.size() / kMostSeen);
    for (size_t first = 0; first < stride && seen[0].size() < kFewestSeen; ++first)
      for (size_t v = first; v < scene_.photos.size(); v += stride) {
        if (scene_.photos[v].srgb.empty()) continue;
        const auto p = image_point(*place, scene_.photos[v].view, 0, 0.5);
        if (!p) continue;
        const DepthMap& map = scene_.maps[v];
        const size_t pixel = size_t(p->y) * size_t(scene_.photos[v].view.intrinsics.width) + size_t(p->x);
        if (marked_[v][pixel]) continue;
        if (!map.zdepth.empty() && map.reliable(pixel) && p->z > (1 + kOtherSurface) * double(map.zdepth[pixel])) continue;
        std::array<float, 3> colour{};
        sample_bilinear(scene_.photos[v].srgb, p->x, p->y, colour.data());
        for (size_t c = 0; c < 3; ++c) seen[c].push_back(colour[c]);
      }
    if (seen[0].size() < kFewestSeen) return std::nullopt;
    return Vec3f{upper_median_of(std::span(seen[0])), upper_median_of(std::span(seen[1])), upper_median_of(std::span(seen[2]))};
  }

 private:
  std::optional<Vec3d> end_of(const Ray& ray) const {
    double nearest = INFINITY;
    for (const ScenePlane& plane : scene_.planes) {
      if (plane.share < kLargePlane) continue;
      const double t = (plane.offset - dot(plane.normal, ray.origin)) / dot(plane.normal, ray.direction);
      if (t > 0 && t < nearest && length(ray.origin + t * ray.direction - plane.centre) <= plane.reach()) nearest = t;
    }
    return std::isfinite(nearest) ? std::optional(ray.origin + nearest * ray.direction) : std::nullopt;
  }

  const Surroundings& scene_;
  std::span<const std::vector<uint8_t>> marked_;
};

// Last segment of a pixel's ray path through the shape.
std::optional<Ray> straight_way(const Shape& shape, const Bounds3& box, const Ray& ray) {
  const double beyond = length(box.high - box.low) + length(box.centre() - ray.origin);
  const auto back = intersect(shape, {ray.origin + beyond * ray.direction, -1.0 * ray.direction});
  if (!back) return std::nullopt;
  return Ray{ray.origin + (beyond - back->t) * ray.direction, ray.direction};
}
std::optional<Ray> bent_way(const ThickGlass& glass, const Ray& ray) {
  const BentRay way = glass.path(cast<float>(ray.origin), cast<float>(ray.direction), 0);  // for any distance
  if (way.path != GlassPath::Bent) return std::nullopt;
  const BentRay::Leg& last = way.legs[way.leg_count - 1];
  return Ray{cast<double>(last.origin), cast<double>(last.direction)};
}

// Local correlation of the photos with the images predicted by straight rays and by rays refracted by Snell's law; 1: equal.
struct GlassTrial {
  double straight = 0, bent = 0;
  bool solid() const { return bent > kLikeBent && bent > straight + kClearly; }
};

// [view][h*w] 1 where a photo shows the shape; empty for held-out photos.
std::vector<std::vector<uint8_t>> marked_pixels(const Shape& shape, std::span<const View> views, const SolidTrialDesc& desc) {
  std::vector<std::vector<uint8_t>> marked(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (desc.heldout[v]) return;
    marked[v] = mask_of_rays(views[v], [&](size_t, const Vec3d& eye, const Vec3d& direction) {
      return intersect(shape, {eye, direction}).has_value();
    });
    const auto own = std::ranges::find(desc.glass, views[v].name, [](const Silhouette& s) { return s.view.name; });
    if (own == desc.glass.end()) return;
    const Intrinsics& k = views[v].intrinsics;
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x)
        if (own->value.at(x * own->value.width() / k.width, y * own->value.height() / k.height) < 0.5f)
          marked[v][k.index(x, y)] = 0;
  });
  return marked;
}

// Scores over the photos that show most of the shape.
std::optional<GlassTrial> trial(const SmallStereo& stereo, const Shape& shape, std::span<const std::vector<uint8_t>> marked) {
  const Surroundings scene = stereo.surroundings();
  const auto inside = [&](size_t v) { return scene.photos[v].srgb.empty() ? 0 : size_t(std::ranges::count(marked[v], 1)); };
  std::vector<size_t> tried(marked.size());
  for (size_t v = 0; v < tried.size(); ++v) tried[v] = v;
  std::erase_if(tried, [&](size_t v) { return inside(v) < kFewestInside; });
  std::ranges::stable_sort(tried, std::greater(), inside);
  tried.resize(std::min(tried.size(), kMostTried));

  ShapeSet solid;
  solid.entries.push_back({.shape = shape, .role = ShapeRole::Solid, .tolerance = INFINITY, .clear = {}});
  const auto glass = solid_glass(solid);
  const Bounds3 box = bounds(shape);
  const Room room(scene, marked);
  std::array<LocalCorrelation, 2> alike;
  std::array<size_t, 2> predicted{};
  for (const size_t v : tried) {
    throw_if_interrupted();
    const EdgePhoto& photo = scene.photos[v];
    const Intrinsics& k = photo.view.intrinsics;
    const Vec3d eye = photo.view.centre_in_world();
    std::array<ImageF, 2> picture, known;
    for (size_t way = 0; way < 2; ++way) picture[way] = ImageF(k.width, k.height, 3), known[way] = ImageF(k.width, k.height, 1);
    parallel_for(size_t(k.height), 4, [&](size_t y) {
      for (size_t x = 0; x < size_t(k.width); ++x) {
        const size_t i = y * size_t(k.width) + x;
        const float* shown = photo.srgb.data().data() + 3 * i;
        if (!marked[v][i] || std::min({shown[0], shown[1], shown[2]}) > kLamp) continue;
        const Vec3d middle = normalized(photo.view.ray(double(x) + 0.5, double(y) + 0.5));
        if (const auto front = intersect(shape, {eye, middle}); !front || -dot(front->normal, middle) < kFacing) continue;
        std::array<Vec3f, 2> sum{};
        std::array<int, 2> count{};
        for (const double dy : kJitter)
          for (const double dx : kJitter) {
            const Vec3d d = normalized(photo.view.ray(double(x) + dx, double(y) + dy));
            const std::array ways{straight_way(shape, box, {eye, d}), bent_way(*glass, {eye, d})};
            for (size_t way = 0; way < 2; ++way)
              if (ways[way])
                if (const auto c = room.colour(*ways[way])) sum[way] += *c, ++count[way];
          }
        for (size_t way = 0; way < 2; ++way) {
          if (2 * size_t(count[way]) < kJitter.size() * kJitter.size()) continue;
          known[way].data()[i] = 1;
          for (size_t c = 0; c < 3; ++c) picture[way].data()[3 * i + c] = sum[way][c] / float(count[way]);
        }
      }
    });
    for (size_t way = 0; way < 2; ++way) {
      alike[way] += local_correlation(picture[way], photo.srgb, &known[way]);
      predicted[way] += size_t(std::ranges::count(known[way].data(), 1.f));
    }
  }
  if (std::min(predicted[0], predicted[1]) < kFewestPredicted) return std::nullopt;
  return GlassTrial{alike[0].value().value_or(0), alike[1].value().value_or(0)};
}

// The only shape of an object; nullptr if there are several, or it is flat or inexact.
const Shape* one_curved_shape(const ShapeSet& shapes, uint16_t object) {
  const Shape* found = nullptr;
  for (const ShapeSet::Entry& e : shapes.entries) {
    if (e.object != object) continue;
    if (found != nullptr || !e.exact || !facets(e.shape).empty()) return nullptr;
    found = &e.shape;
  }
  return found;
}

}  // namespace

void find_solids(ObjectSet& set, const SolidTrialDesc& desc) {
  std::optional<SmallStereo> stereo;  // shared by all objects
  for (Object& object : set.objects) {
    const Shape* shape = one_curved_shape(set.shapes, object.id);
    if (!is_glass(object.role) || object.trust == ObjectTrust::Guessed || shape == nullptr) continue;
    throw_if_interrupted();
    if (!stereo) stereo.emplace(read_photos(desc.sfm, desc.views, desc.heldout), desc.views);
    if (stereo->blind()) return;
    const auto result = trial(*stereo, *shape, marked_pixels(*shape, stereo->views(), desc));
    if (!result) continue;
    object.evidence.straight = result->straight, object.evidence.bent = result->bent;
    if (result->solid()) object.role = ObjectRole::SolidGlass;
  }
}

}  // namespace vitrine
