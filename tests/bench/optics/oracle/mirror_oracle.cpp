#include "tests/bench/optics/oracle/mirror_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/math/color.h"
#include "core/learn/optim/adam.h"
#include "core/render/picture/view_picture.h"
#include "core/render/trace/tracer.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/metrics.h"
#include "core/scene/image/resample.h"
#include "core/scene/light/environment.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

namespace {

constexpr float kFarthest = 5;     // scene radii: surfels beyond are far field
constexpr float kClipped = 0.98f;  // of a photo
constexpr float kDarkest = 0.02f;  // of the weight of a pixel
constexpr float kStep = 1.3f;      // over-relaxation
constexpr int kStraightEvery = 4;  // pixels that show no object: one of so many a side
constexpr float kNear = 0.01f;     // scene units before the mirror
constexpr uint16_t kStraight = 0;  // object of rays that meet no mirror

struct Pixel {
  uint32_t photo = 0;  // index into the views
  int x = 0, y = 0;
  uint16_t object = kStraight;
  Vec3f seen{};  // of the photo, linear, without its gain
  std::array<bool, 3> clipped{};
};

struct RaySeen {
  Vec3f color{};
  float open = 1;
  uint32_t texel = 0;
};

struct Samples {
  std::vector<Pixel> pixels;
  std::vector<RaySeen> rays;  // rays_of(pixel) of each, in order
  std::vector<uint32_t> first;
  std::span<const RaySeen> of(size_t pixel) const {
    return std::span(rays).subspan(first[pixel], first[pixel + 1] - first[pixel]);
  }
};

class MirrorOracle {
 public:
  explicit MirrorOracle(const MirrorOracleDesc& desc)
      : d_(desc),
        capture_(load_view_set(desc.sfm)),
        split_(read_view_split(desc.opaque / "optimize/views.json", views_)),
        labels_(LabelledObjects::trusted(desc.objects)),
        scene_(read_trained_scene(desc.opaque)) {
    shapes_ =
        d_.trained_shapes && d_.trained ? *read_trained_scene(*d_.trained).image.shape.set : labels_.objects().drawn_shapes();
    shapes_ = shapes_.no_glass().without(ShapeRole::Coat);
    for (const ShapeSet::Entry& e : shapes_.entries) build_tracer(e.object);
    build_tracer(kStraight);
    far_.assign(size_t(d_.texels) * size_t(d_.texels), {});
  }

  nlohmann::ordered_json run() {
    if (d_.truth) {
      TriMesh mesh = read_mesh_ply(*d_.truth / "mesh.ply");
      for (Vec3f& p : mesh.positions) p = cast<float>(capture_.scene_from_colmap * cast<double>(p));
      truth_.emplace(std::move(mesh));
    }
    if (shapes_.entries.empty())
      throw Error(ErrorKind::Input, "there is no mirror of known shape", {.where = d_.objects.string(), .code = "NO_MIRROR"});
    const Samples train = samples(split_.train, true), heldout = samples(split_.heldout, false);
    for (const Pixel& p : train.pixels) tint_[p.object] = {1, 1, 1};
    for (int round = 0; round < d_.rounds; ++round) {
      solve_tints(train);
      solve_far_field(train);
    }
    solve_tints(train);
    nlohmann::ordered_json out;
    out["heldout"] = figures(heldout);
    out["train_oracle"] = psnr_of_oracle(train);
    for (const auto& [object, tint] : tint_)
      if (object != kStraight) out["tint"][labels_.objects().find(object)->name] = {tint.x, tint.y, tint.z};
    return out;
  }

 private:
  // The surfels that mirrored rays of an object see: not its own, none that are guessed or far away.
  void build_tracer(uint16_t object) {
    if (tracers_.contains(object)) return;
    const SplatLayer& all = scene_.surfels.diffuse;
    const std::span<const uint16_t> ids = all.object_ids();
    SplatLayer& kept = layers_[object] = all;
    std::vector<uint32_t> stay;
    for (uint32_t i = 0; i < std::min(all.size(), scene_.image.panes.mirrored); ++i) {
      const float* m = all.at(Attribute::Mean, i);
      if (object != kStraight && !ids.empty() && ids[i] == object) continue;
      if (length(Vec3f{m[0], m[1], m[2]}) <= kFarthest) stay.push_back(i);
    }
    keep_surfels(kept, stay);
    tracers_[object] = make_tracer();
    tracers_[object]->build(kept);
  }

  struct Pending {
    std::vector<Vec3f> origins, directions;
    std::vector<uint32_t> to;  // index into Samples::rays
  };

  Samples samples(const std::vector<size_t>& photos, bool straight) {
    Samples out;
    std::map<uint16_t, Pending> pending;
    for (const size_t photo : photos) {
      View view = views_[photo];
      view.intrinsics = view.intrinsics.limited_to(split_.max_side);
      const Intrinsics& k = view.intrinsics;
      const ImageF picture = resized(read_exr_rgb(linear_image_path(d_.sfm, view)), k.width, k.height);
      const Image16 labels = labels_.labels(views_[photo], k);
      const Rigid world_from_cam = inverse(view.cam_from_world);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const uint16_t object = labels.empty() ? kStraight : labels.at(x, y);
          const bool mirror = object != kStraight && tracers_.contains(object);
          if (!mirror && (object != kStraight || !straight || x % kStraightEvery != 0 || y % kStraightEvery != 0)) continue;
          Pixel pixel{.photo = uint32_t(photo), .x = x, .y = y, .object = object};
          for (size_t c = 0; c < 3; ++c) {
            const float v = picture.pixel(x, y)[c];
            pixel.seen[c] = std::max(v, 0.f) / float(view.gain[c]);
            pixel.clipped[c] = v >= kClipped;
          }
          const size_t first = out.rays.size();
          const int n = mirror ? d_.rays : 1;
          for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i) {
              const Vec3d d = normalized(world_from_cam.rotation * k.ray(x + (i + 0.5) / n, y + (j + 0.5) / n));
              add_ray(world_from_cam.translation, d, object, out, pending);
            }
          if (out.rays.size() == first) continue;  // the shape is not there
          out.pixels.push_back(pixel);
          out.first.push_back(uint32_t(first));
        }
    }
    out.first.push_back(uint32_t(out.rays.size()));
    for (const auto& [object, rays] : pending) {
      RayValues seen;
      const std::vector<float> near(rays.to.size(), kNear);
      tracers_.at(object)->forward({.origins = rays.origins, .directions = rays.directions, .near = near},
                                   {.sh_degree = object == kStraight ? scene_.surfels.diffuse.sh_degree() : d_.sh_degree}, seen,
                                   nullptr);
      for (size_t i = 0; i < rays.to.size(); ++i) {
        out.rays[rays.to[i]].color = seen.color[i];
        out.rays[rays.to[i]].open = seen.transmittance[i];
      }
    }
    return out;
  }

  void add_ray(Vec3d origin, Vec3d direction, uint16_t object, Samples& out, std::map<uint16_t, Pending>& pending) const {
    if (object != kStraight) {
      const auto hit = truth_ ? truth_->intersect({origin, direction}) : own_hit({origin, direction}, object);
      if (!hit) return;
      origin = origin + hit->t * direction;
      direction = normalized(direction - 2 * dot(direction, hit->normal) * hit->normal);
    }
    Pending& to = pending[object];
    to.origins.push_back(cast<float>(origin));
    to.directions.push_back(cast<float>(direction));
    to.to.push_back(uint32_t(out.rays.size()));
    const Vec2f place = octahedral_place(cast<float>(direction));
    const auto cell = [&](float v) { return std::min(int(0.5f * (v + 1) * float(d_.texels)), d_.texels - 1); };
    out.rays.push_back({.texel = uint32_t(cell(place.y) * d_.texels + cell(place.x))});
  }

  std::optional<ShapeHit> own_hit(const Ray& ray, uint16_t object) const {
    return shapes_.first_hit(ray, ShapeRole::Mirror,
                             [&](const ShapeSet::Hit& h) { return shapes_.entries[h.entry].object == object; });
  }

  Vec3f light(std::span<const RaySeen> rays) const {  // without the tint
    Vec3f sum{};
    for (const RaySeen& r : rays) sum += r.color + r.open * far_[r.texel];
    return sum / float(rays.size());
  }

  void solve_tints(const Samples& s) {
    std::map<uint16_t, std::array<Vec3d, 2>> sums;
    for (size_t i = 0; i < s.pixels.size(); ++i) {
      const Pixel& p = s.pixels[i];
      if (p.object == kStraight) continue;
      const Vec3f l = light(s.of(i));
      for (size_t c = 0; c < 3; ++c) {
        if (p.clipped[c]) continue;
        const double w = 1 / std::max(p.seen[c], kDarkest);
        sums[p.object][0][c] += w * double(p.seen[c]) * double(l[c]);
        sums[p.object][1][c] += w * double(l[c]) * double(l[c]);
      }
    }
    for (const auto& [object, sum] : sums)
      for (size_t c = 0; c < 3; ++c)
        if (sum[1][c] > 0) tint_[object][c] = float(std::clamp(sum[0][c] / sum[1][c], 0.02, 1.0));
  }

  void solve_far_field(const Samples& s) {
    std::vector<Vec3d> up(far_.size()), down(far_.size());
    for (size_t i = 0; i < s.pixels.size(); ++i) {
      const Pixel& p = s.pixels[i];
      const std::span<const RaySeen> rays = s.of(i);
      const Vec3f tint = tint_.at(p.object), l = hadamard(tint, light(rays));
      float open = 0;
      for (const RaySeen& r : rays) open += r.open / float(rays.size());
      for (size_t c = 0; c < 3; ++c) {
        const double e = p.clipped[c] && l[c] > p.seen[c] ? 0 : double(p.seen[c] - l[c]);
        const double w = 1 / std::max(p.seen[c], kDarkest);
        for (const RaySeen& r : rays) {
          const double f = double(tint[c] * r.open) / double(rays.size());
          up[r.texel][c] += f * w * e;
          down[r.texel][c] += f * w * double(tint[c] * open);
        }
      }
    }
    for (size_t t = 0; t < far_.size(); ++t)
      for (size_t c = 0; c < 3; ++c)
        if (down[t][c] > 1e-9) far_[t][c] = std::max(0.f, far_[t][c] + kStep * float(up[t][c] / down[t][c]));
  }

  static void add(const Vec3f& ours, const Vec3f& theirs, SquaredError& error) {
    error.sum += double(dot(ours - theirs, ours - theirs));
    error.weight += 3;
  }

  static Vec3f shown(const Vec3f& linear, const Vec3d& gain) {
    Vec3f out;
    for (size_t c = 0; c < 3; ++c) out[c] = srgb_from_linear(std::clamp(float(gain[c]) * linear[c], 0.f, 1.f));
    return out;
  }

  double psnr_of_oracle(const Samples& s) const {
    SquaredError e;
    for (size_t i = 0; i < s.pixels.size(); ++i) {
      const Pixel& p = s.pixels[i];
      if (p.object == kStraight) continue;
      const Vec3d& gain = views_[p.photo].gain;
      add(shown(hadamard(tint_.at(p.object), light(s.of(i))), gain), shown(p.seen, gain), e);
    }
    return e.psnr();
  }

  nlohmann::ordered_json figures(const Samples& s) {
    ScenePainter opaque(scene_, {});
    std::optional<ScenePainter> trained;
    if (d_.trained) {
      TrainedScene layers = read_trained_scene(*d_.trained);
      layers.surfels.opaque = {};
      trained.emplace(std::move(layers), PictureDesc{});
    }
    std::map<std::string, std::map<std::string, SquaredError>> errors;
    ImageF of_opaque, of_trained;
    uint32_t current = uint32_t(-1);
    for (size_t i = 0; i < s.pixels.size(); ++i) {
      const Pixel& p = s.pixels[i];
      if (p.photo != current) {
        current = p.photo;
        View view = views_[current];
        view.intrinsics = view.intrinsics.limited_to(split_.max_side);
        of_opaque = opaque.picture(view).srgb;
        if (trained) of_trained = trained->picture(view).srgb;
      }
      const Vec3d& gain = views_[p.photo].gain;
      const auto at = [&](const ImageF& image) {
        const float* v = image.pixel(p.x, p.y);
        return Vec3f{v[0], v[1], v[2]};
      };
      const Vec3f photo = shown(p.seen, gain), ours = shown(hadamard(tint_.at(p.object), light(s.of(i))), gain),
                  base = at(of_opaque);
      for (const std::string& name : {std::string("all"), labels_.objects().find(p.object)->name}) {
        auto& row = errors[name];
        add(base, photo, row["opaque"]);
        add(ours, photo, row["oracle"]);
        add(0.5f * (base + ours), photo, row["opaque+oracle"]);
        if (!trained) continue;
        const Vec3f full = at(of_trained);
        add(full, photo, row["trained"]);
        add(0.5f * (base + full), photo, row["opaque+trained"]);
        add((base + full + ours) / 3.f, photo, row["all"]);
      }
    }
    nlohmann::ordered_json out;
    for (const auto& [name, row] : errors)
      for (const auto& [kind, e] : row) {
        out[name][kind] = std::round(100 * e.psnr()) / 100;
        out[name]["pixels"] = size_t(e.weight) / 3;
      }
    return out;
  }

  const MirrorOracleDesc& d_;
  const ViewSet capture_;
  const std::vector<View>& views_ = capture_.views;
  const ViewSplit split_;
  const LabelledObjects labels_;
  const TrainedScene scene_;
  ShapeSet shapes_;
  std::optional<TriangleShape> truth_;
  std::map<uint16_t, SplatLayer> layers_;
  std::map<uint16_t, std::unique_ptr<Tracer>> tracers_;
  std::map<uint16_t, Vec3f> tint_;
  std::vector<Vec3f> far_;
};

}  // namespace

nlohmann::ordered_json mirror_oracle(const MirrorOracleDesc& desc) { return MirrorOracle(desc).run(); }

}  // namespace vitrine
