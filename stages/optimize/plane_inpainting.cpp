#include "stages/optimize/plane_inpainting.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

#include "core/foundation/math/vec.h"
#include "core/learn/optim/adam.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/surface_pass.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/light/environment.h"
#include "core/scene/surfels/activation.h"
#include "stages/optimize/initialise.h"
#include "stages/optimize/layer_init.h"

namespace vitrine {

namespace {

constexpr float kSolid = 0.5f;        // alpha of a pixel that shows a surface
constexpr double kFinestCell = 0.03;  // of the cameras' radius, which is 1; radians for the sky
constexpr double kCoarser = 1.4;      // cell growth factor until there are few enough surfels
constexpr double kReach = 0.48;       // largest distance of inpainting from seen cells
constexpr size_t kMostCells = 1u << 20;
constexpr double kOnPlane = 0.02;  // relative depth tolerance within which a photo sees the plane
constexpr double kThrough = 0.04;  // relative depth beyond which it sees through the plane
constexpr double kBehind = 0.02;   // offset behind the plane, so that no seen surface is occluded
constexpr double kSky = 0.5;       // of the sky's distance: farther content is sky
constexpr double kBehindSky = 1.2;
constexpr double kCover = 0.75;  // scale of a surfel, relative to its cell
constexpr float kOpacity = 0.95f;
constexpr float kShows = 0.25f;    // largest visible share of an inpainted surfel's pixels in a photo
constexpr float kFewPixels = 4.f;  // in a photo: fewer pixels are only the surfel's edge
constexpr float kWhole = 1.f;      // of its pixels in the photo that shows most of it: small inpainted surfels do no harm
constexpr float kRim = 0.25f;      // the same for moved trained surfels, of which many may be small

std::vector<SeenPhoto> seen_photos(const SplatLayer& layer, const Capture& capture, const MediumCoefficients<double>* medium) {
  ImageModel model({.diffuse = {.sh_degree = 0, .near_z = capture.near_z}});
  model.emplace<DiffusePass>();
  const SplatScene diffuse{.diffuse = layer};
  Frame frame;
  std::vector<SeenPhoto> photos;
  for (uint32_t photo : capture.train) {
    const PhotoLevel& level = capture.photos[photo].levels[kUnseenLevel];
    model.forward(diffuse, level.view, frame);
    const auto z = frame.diffuse.plane(Aov::ZDepth), alpha = frame.diffuse.plane(Aov::Alpha),
               median = frame.diffuse.plane(Aov::MedianZ);
    photos.push_back({&level, std::vector<float>(frame.pixel_count()), medium});
    for (size_t i = 0; i < z.size(); ++i)
      photos.back().zdepth[i] = alpha[i] > kSolid ? surface_depth(z[i], alpha[i], median[i]) : 0;
  }
  return photos;
}

// The seen part of a plane and its neighbourhood.
struct PlanePart {
  Vec3d normal, origin, u, v;  // the normal faces the centre of the cameras, which is the origin
  CellSurface cells;           // empty if no photo sees the plane

  PlanePart(const ScenePlane& plane, double cell, double background, std::span<const SeenPhoto> photos)
      : normal((plane.offset >= 0 ? -1.0 : 1.0) * plane.normal), origin(plane.offset * plane.normal) {
    const auto across = orthonormal_basis(normal);
    u = across.u, v = across.v;
    double low_u = 1e300, low_v = 1e300, high_u = -1e300, high_v = -1e300;
    for (const SeenPhoto& seen : photos)
      for_pixels_on_plane(seen, background > 0 ? kSky * background : 1e300, [&](const Vec3d& p) {
        const Vec3d q = p - origin;
        low_u = std::min(low_u, dot(q, u)), high_u = std::max(high_u, dot(q, u));
        low_v = std::min(low_v, dot(q, v)), high_v = std::max(high_v, dot(q, v));
      });
    if (!(low_u < high_u) || !(low_v < high_v)) return;
    const double columns = std::ceil((high_u - low_u + 2 * kReach) / cell),
                 rows = std::ceil((high_v - low_v + 2 * kReach) / cell);
    if (columns * rows > double(kMostCells)) return;  // planes that far away are skipped
    origin += (low_u - kReach) * u + (low_v - kReach) * v;
    cells.columns = int(columns), cells.rows = int(rows);
    cells.place = [this, cell](double column, double row) { return origin + column * cell * u + row * cell * v; };
    cells.sight = [](double place_z, double zdepth) {
      if (zdepth == 0 || place_z < (1 - kThrough) * zdepth) return Sight::Through;
      return place_z < (1 + kOnPlane) * zdepth ? Sight::Seen : Sight::Unseen;
    };
  }
  PlanePart(const PlanePart&) = delete;

  template <class Visit>
  void for_pixels_on_plane(const SeenPhoto& seen, double farthest, const Visit& visit) const {
    const Intrinsics& k = seen.photo->view.intrinsics;
    const Rigid world_from_cam = inverse(seen.photo->view.cam_from_world);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const double z = double(seen.zdepth[k.index(x, y)]);
        if (!(z > 0) || z > farthest) continue;
        const Vec3d p = world_from_cam * (z * k.ray(x + 0.5, y + 0.5));
        if (std::abs(dot(p - origin, normal)) < kOnPlane * z) visit(p);
      }
  }
};

// True if some photo has enough sky pixels for reliable colours.
bool shows_sky(std::span<const SeenPhoto> photos, double background) {
  constexpr double kEnough = 0.01;  // of its pixels
  return std::ranges::any_of(photos, [&](const SeenPhoto& seen) {
    const auto far = std::ranges::count_if(seen.zdepth, [&](float z) { return double(z) > kSky * background; });
    return double(far) > kEnough * double(seen.zdepth.size());
  });
}

// The sky as a sphere around the cameras, in cells of latitude and longitude. Cells behind seen surfaces are not filled: a bright
// guess there would shine through every gap.
CellSurface sky(double cell, double background) {
  const int rows = std::max(4, int(std::numbers::pi / cell));
  return {.columns = 2 * rows,
          .rows = rows,
          .round = true,
          .place =
              [=](double column, double row) {
                return background * cast<double>(lat_long_direction(float(column / (2 * rows)), float(row / rows)));
              },
          .sight = [=](double, double zdepth) { return zdepth > kSky * background ? Sight::Seen : Sight::Through; }};
}

// Sets the initial materials of a surfel that sends no rays.
void make_dull(SplatLayer& layer, size_t i) {
  for (Attribute a : {Attribute::F0, Attribute::Roughness})
    std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, row(a).initial));
  for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission}) *layer.at(a, i) = raw_value(row(a).activation, kDull);
}

void add_guess(const Vec3d& position, const Vec3d& normal, double scale, const Vec3d& linear, SplatLayer& layer) {
  const Quatf q = rotation_facing(cast<float>(normal));
  const size_t i = layer.size();
  layer.resize(i + 1);
  float* rotation = layer.at(Attribute::Rotation, i);
  rotation[0] = q.w, rotation[1] = q.x, rotation[2] = q.y, rotation[3] = q.z;
  for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(scale));
  for (size_t c = 0; c < 3; ++c) {
    layer.at(Attribute::Mean, i)[c] = float(position[c]);
    layer.at(Attribute::ShDc, i)[c] = float((std::clamp(linear[c], 0.0, 1e4) - 0.5) / double(kShDc));
  }
  *layer.at(Attribute::Opacity, i) = logit(kOpacity);
  make_dull(layer, i);
}

SplatLayer guessed_layer(std::span<const ScenePlane> planes, double background, double cell, std::span<const SeenPhoto> photos) {
  SplatLayer layer(LayerKind::Diffuse, 0, 0);
  for (const ScenePlane& plane : planes) {
    const PlanePart part(plane, cell, background, photos);
    UnobservedCells(part.cells, photos, kReach / cell).for_guessed([&](const Vec3d& centre, int side, const Vec3d& linear) {
      add_guess(centre - kBehind * part.normal, part.normal, kCover * cell * side, linear, layer);
    });
  }
  if (background > 0 && shows_sky(photos, background))
    UnobservedCells(sky(cell, background), photos, kReach / cell)
        .for_guessed([&](const Vec3d& centre, int side, const Vec3d& linear) {
          add_guess(kBehindSky * centre, -normalized(centre), kBehindSky * background * kCover * cell * side, linear, layer);
        });
  return layer;
}

// Sum of the blending weights per surfel in one photo, in pixels.
class PhotoWeights {
 public:
  PhotoWeights(const SplatLayer& layer, const Capture& capture)
      : scene_{.diffuse = layer},
        ignored_{.diffuse = layer.zeros_like()},
        model_({.diffuse = {.sh_degree = 0, .near_z = capture.near_z}}) {
    model_.emplace<DiffusePass>();
  }

  const std::vector<float>& in(const View& view) {
    model_.forward(scene_, view, frame_);
    frame_.grad_linear.assign(3 * frame_.pixel_count(), 0.f);
    model_.backward(scene_, frame_, ignored_);
    return frame_.statistics.weight;
  }

 private:
  SplatScene scene_, ignored_;
  ImageModel model_;
  Frame frame_;
};

// Ascending indices of `added` surfels that the diffuse layer hides from all training photos. A visible inpainted surfel
// contradicts the photo. Photos that show only the edge of a surfel are ignored: fewer pixels than `rim` times those in the photo
// that shows most of it, at most kFewPixels.
std::vector<uint32_t> hidden_from_all(const SplatLayer& diffuse, const SplatLayer& added, const Capture& capture, float rim) {
  PhotoWeights alone(added, capture), together(joined(diffuse, added), capture);
  std::vector<float> most(added.size()), shown(added.size());  // pixels: maximum over all photos; over photos that see the surfel
  for (uint32_t photo : capture.train) {
    const View& view = capture.photos[photo].levels[kUnseenLevel].view;
    const std::vector<float>& all = alone.in(view);
    const std::vector<float>& left = together.in(view);
    for (size_t i = 0; i < added.size(); ++i) {
      most[i] = std::max(most[i], all[i]);
      if (left[diffuse.size() + i] > kShows * all[i]) shown[i] = std::max(shown[i], all[i]);
    }
  }
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < added.size(); ++i)
    if (!(shown[i] > std::min(kFewPixels, rim * most[i]))) kept.push_back(uint32_t(i));
  return kept;
}

// Surfels with centres on one of the planes or its extension, as seen from the centre of the cameras.
std::vector<uint32_t> on_planes(const SplatLayer& layer, std::span<const ScenePlane> planes) {
  std::vector<uint32_t> found;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* mean = layer.at(Attribute::Mean, i);
    const Vec3d p{mean[0], mean[1], mean[2]};
    const double tolerance = kOnPlane * std::max(1.0, length(p));
    if (std::ranges::any_of(planes,
                            [&](const ScenePlane& plane) { return std::abs(dot(plane.normal, p) - plane.offset) < tolerance; }))
      found.push_back(uint32_t(i));
  }
  return found;
}

}  // namespace

SplatLayer joined(const SplatLayer& first, const SplatLayer& second) {
  SplatLayer both = first;
  both.resize(first.size() + second.size());
  for (size_t i = 0; i < second.size(); ++i)
    for (const AttributeRow& r : kAttributes)
      std::copy_n(second.at(r.id, i), std::min(second.width(r.id), both.width(r.id)), both.at(r.id, first.size() + i));
  return both;
}

SplatLayer seen_through_glass(const SplatScene& scene) {
  SplatLayer opaque = scene.diffuse;
  keep_surfels(opaque, opaque_surfels(scene.diffuse));
  return joined(opaque, scene.transmittance);
}

std::vector<uint32_t> bring_out_from_behind_glass(const Capture& capture, std::span<const ScenePlane> planes, SplatScene& scene) {
  const std::vector<uint32_t> candidates = on_planes(scene.transmittance, planes);
  std::vector<uint32_t> all(scene.transmittance.size()), gone, stay;
  std::iota(all.begin(), all.end(), 0u);
  if (candidates.empty()) return all;
  SplatLayer moved = scene.transmittance;
  keep_surfels(moved, candidates);
  for (uint32_t i : hidden_from_all(scene.diffuse, moved, capture, kRim)) gone.push_back(candidates[i]);
  if (gone.size() == all.size()) gone.pop_back();
  if (gone.empty()) return all;
  std::ranges::set_difference(all, gone, std::back_inserter(stay));

  moved = scene.transmittance;
  keep_surfels(moved, gone);
  const size_t first = scene.diffuse.size();
  scene.diffuse = joined(scene.diffuse, moved);
  for (size_t i = first; i < scene.diffuse.size(); ++i) make_dull(scene.diffuse, i);
  keep_surfels(scene.transmittance, stay);
  return stay;
}

SplatLayer inpainted_planes(const SplatLayer& shown, const Capture& capture, std::span<const ScenePlane> planes,
                            double background, size_t most, const MediumCoefficients<double>* medium) {
  const std::vector<SeenPhoto> photos = seen_photos(shown, capture, medium);
  for (double cell = kFinestCell; cell < kReach; cell *= kCoarser)
    if (SplatLayer layer = guessed_layer(planes, background, cell, photos); layer.size() <= most) {
      if (layer.size() > 0) keep_surfels(layer, hidden_from_all(shown, layer, capture, kWhole));
      return layer;
    }
  return SplatLayer(LayerKind::Diffuse, 0, 0);
}

}  // namespace vitrine
