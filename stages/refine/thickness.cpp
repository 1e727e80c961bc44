#include "stages/refine/thickness.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/layered_model.h"
#include "core/scene/camera/projection.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/refine/refine.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr size_t kFewestWitnesses = 64;  // minimum pixels per region
constexpr double kClearly_db = 0.2;      // minimum advantage of refracted rays
constexpr size_t kMostLogged = 4;        // regions; the report contains all
constexpr float kInvisible = -20;        // raw opacity
constexpr size_t kSurfelGrain = 256;

double db(double squared_error) { return squared_error > 0 ? -10 * std::log10(squared_error) : 99; }

double squared_error(const Frame& frame, std::span<const float> photo, size_t pixel) {
  double sum = 0;
  for (size_t c = 0, n = frame.pixel_count(); c < 3; ++c)
    sum += std::pow(double(frame.srgb[c * n + pixel]) - double(photo[c * n + pixel]), 2);
  return sum / 3;
}

// Rendering hypothesis: a scene and its last picture.
struct Hypothesis {
  TrainedScene scene;
  LayeredModel model;
  Frame frame;
  explicit Hypothesis(TrainedScene shown) : scene(std::move(shown)), model(scene.image) { frame.differentiable = false; }
  void show(const View& view) { model.forward(scene.surfels, view, frame); }
};

}  // namespace

bool RegionThickness::tested() const { return pixels >= kFewestWitnesses; }
bool RegionThickness::thick() const {
  return tested() && db(std::min(bent, bent_without)) > db(std::min(straight, straight_without)) + kClearly_db;
}

std::vector<uint8_t> closed_regions(std::span<const GlassView> views, const GlassMesh& mesh) {
  std::vector<size_t> pixels(mesh.regions, 0);
  for (const GlassView& v : views)
    for (size_t i = 0; i < v.segments.kind.size(); ++i)
      if (v.segments.trusted && v.segments.kind[i] == SegmentKind::Closed) ++pixels[v.segments.region[i]];
  std::vector<uint8_t> closed(mesh.regions);
  std::ranges::transform(pixels, closed.begin(), [](size_t n) { return n >= kFewestWitnesses; });
  return closed;
}

std::vector<uint8_t> seen_through(const SplatLayer& layer, std::span<const GlassView> views, std::span<const uint8_t> chosen) {
  std::vector<uint8_t> through(layer.size());
  parallel_chunks(through.size(), kSurfelGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const float* p = layer.at(Attribute::Mean, i);
      const Vec3d place{p[0], p[1], p[2]};
      int behind = 0, elsewhere = 0;
      for (const GlassView& v : views) {
        const auto at = image_point(place, *v.view);
        if (!at) continue;
        const size_t pixel = size_t(at->y) * size_t(v.view->intrinsics.width) + size_t(at->x);
        if (!(v.glass[pixel] > 0.5f)) continue;
        const bool closed = v.split(pixel) && v.segments.kind[pixel] == SegmentKind::Closed;
        const bool is_behind = closed && chosen[v.segments.region[pixel]] &&
                               length(v.view->cam_from_world * place) > double(v.segments.front[pixel]);
        ++(is_behind ? behind : elsewhere);
      }
      through[i] = behind > elsewhere;
    }
  });
  return through;
}

SplatLayer kept_or_blank(const SplatLayer& layer, std::span<const uint8_t> keep) {
  SplatLayer kept = kept_surfels(layer, keep);
  if (kept.size() > 0 || layer.size() == 0) return kept;
  kept = layer;
  kept.resize(1);
  *kept.at(Attribute::Opacity, 0) = kInvisible;
  return kept;
}

std::vector<uint8_t> regions_of_solid_glass(const LabelledObjects& objects, std::span<const GlassView> views,
                                            const GlassMesh& mesh) {
  std::vector<size_t> solid(mesh.regions, 0), all(mesh.regions, 0);
  for (const GlassView& v : views) {
    if (!v.segments.trusted) continue;
    const Image16 labels = objects.labels(*v.view, v.view->intrinsics);
    if (labels.empty()) continue;
    for (size_t i = 0; i < v.segments.kind.size(); ++i) {
      if (v.segments.kind[i] != SegmentKind::Closed) continue;
      const Object* object = objects.objects().find(labels.data()[i]);
      ++all[v.segments.region[i]];
      solid[v.segments.region[i]] += object != nullptr && object->role == ObjectRole::SolidGlass;
    }
  }
  std::vector<uint8_t> out(mesh.regions);
  for (size_t r = 0; r < out.size(); ++r) out[r] = 2 * solid[r] > all[r];
  return out;
}

TrainedScene with_thick_glass(TrainedScene scene, const GlassMesh& mesh, std::span<const uint8_t> chosen, float ior) {
  if (auto thick = thick_glass(mesh, chosen, ior)) {
    scene.image.transmission.glass = Glass::Thin;
    scene.image.transmission.thick = std::move(thick);
    if (const auto& set = scene.image.shape.set)  // solid glass, not a case of panes
      scene.image.shape.set = std::make_shared<const ShapeSet>(set->no_glass());
  }
  return scene;
}

std::vector<RegionThickness> region_thickness(const ThicknessDesc& desc) {
  const std::vector<uint8_t> closed = closed_regions(desc.seen, desc.mesh);
  std::vector<RegionThickness> regions;
  std::vector<size_t> place(closed.size());
  for (uint32_t r = 0; r < closed.size(); ++r) {
    if (!closed[r]) continue;
    place[r] = regions.size();
    const auto faces = std::count(desc.mesh.region.begin(), desc.mesh.region.end(), r);
    regions.push_back({.region = r, .faces = static_cast<size_t>(faces)});
  }
  if (regions.empty()) return regions;

  TrainedScene thin = desc.scene;
  thin.image.transmission.glass = Glass::Thin;
  TrainedScene thin_without = thin;
  std::vector<uint8_t> keep = seen_through(thin.surfels.transmittance, desc.seen, closed);
  for (uint8_t& k : keep) k = !k;
  thin_without.surfels.transmittance = kept_or_blank(thin.surfels.transmittance, keep);
  Hypothesis straight(thin), straight_without(thin_without);
  Hypothesis bent(with_thick_glass(thin, desc.mesh, closed, desc.ior));
  Hypothesis bent_without(with_thick_glass(thin_without, desc.mesh, closed, desc.ior));
  std::vector<float> photo;
  for (const GlassView& v : desc.judges) {
    throw_if_interrupted();
    if (!v.segments.trusted) continue;
    for (Hypothesis* h : {&straight, &straight_without, &bent, &bent_without}) h->show(*v.view);
    if (bent.frame.behind.path.empty()) continue;  // no glass in the picture
    decode(desc.capture.photos[v.photo].levels[desc.level], photo);
    std::vector<size_t> counted(regions.size());
    for (size_t i = 0; i < v.segments.kind.size(); ++i) {
      if (v.segments.kind[i] != SegmentKind::Closed || !closed[v.segments.region[i]]) continue;
      RegionThickness& r = regions[place[v.segments.region[i]]];
      const GlassPath path = bent.frame.behind.path[i];
      r.total_reflection += path == GlassPath::TotalReflection;
      r.no_exit += path == GlassPath::NoExit;
      if (path != GlassPath::Bent) continue;
      ++counted[place[v.segments.region[i]]];
      r.straight += squared_error(straight.frame, photo, i);
      r.straight_without += squared_error(straight_without.frame, photo, i);
      r.bent += squared_error(bent.frame, photo, i);
      r.bent_without += squared_error(bent_without.frame, photo, i);
    }
    for (size_t r = 0; r < regions.size(); ++r) {
      regions[r].pixels += counted[r];
      regions[r].photos += counted[r] > 0;
    }
  }
  for (RegionThickness& r : regions)
    for (double* sum : {&r.straight, &r.straight_without, &r.bent, &r.bent_without})
      if (r.pixels > 0) *sum /= double(r.pixels);
  return regions;
}

Json thickness_json(std::span<const RegionThickness> regions) {
  Json rows = Json::array();
  for (const RegionThickness& r : regions) {
    Json row{{"region", r.region}, {"faces", r.faces}, {"photos", r.photos}, {"pixels", r.pixels}};
    const size_t rays = r.pixels + r.total_reflection + r.no_exit;
    const auto share = [&](size_t n) { return rays > 0 ? rounded(double(n) / double(rays)) : 0; };
    row["total_reflection"] = share(r.total_reflection);
    row["no_exit"] = share(r.no_exit);
    if (r.pixels > 0)
      row["psnr"] = {{"straight", rounded(db(r.straight))},
                     {"straight_without_layer", rounded(db(r.straight_without))},
                     {"bent", rounded(db(r.bent))},
                     {"bent_without_layer", rounded(db(r.bent_without))}};
    row["verdict"] = !r.tested() ? "untested" : r.thick() ? "thick" : "thin";
    rows.push_back(std::move(row));
  }
  return rows;
}

void log_thickness(std::span<const RegionThickness> regions) {
  for (const RegionThickness& r : regions.first(std::min(kMostLogged, regions.size())))
    if (r.tested())
      log_info("glass region {}, {} faces: {}; straight rays {:.2f} dB, bent ones {:.2f} dB ({} pixels in {} photos)", r.region,
               r.faces, r.thick() ? "thick" : "thin", db(std::min(r.straight, r.straight_without)),
               db(std::min(r.bent, r.bent_without)), r.pixels, r.photos);
}

}  // namespace vitrine
