#include "core/relight/relit_painter.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/process.h"
#include "core/model/gbuffer.h"
#include "core/relight/sample_points.h"
#include "core/render/surface_depth.h"

namespace vitrine {

namespace {

constexpr float kLeastCoverage = 1 / 255.f;
constexpr float kSnap = 3;              // in grains: a surfel's place and the mesh this near are the same surface
constexpr float kMirrorLift = 1;        // in grains: where rays start above it
constexpr float kMattLift = 2.5f;       // the same where light is scattered: terraces of the mesh throw no shadow
constexpr float kNearWall_rel = 0.75f;  // a back of the walls that hides surfels by less is where they are
constexpr float kLeastCosine = 0.02f;   // n.v: normals of blended surfels may look away at an outline
constexpr int kBandRows = 8;
constexpr uint32_t kLightPlane = 0, kLobePlane = 1, kChoicePlane = 2, kLampPlane = 3;  // of the sample points

ImageOptions options_of(const RelitScene& scene) {
  ImageOptions o = scene.trained.image;
  o.diffuse.materials = true;
  o.diffuse.sh_degree = 0;
  return o;
}

// The frame of a normal: z is the normal.
struct ShadingFrame {
  Vec3f t0, t1, n;
  explicit ShadingFrame(const Vec3f& normal) : n(normal) { tangents(normal, t0, t1); }
  Vec3f local(const Vec3f& v) const { return {dot(v, t0), dot(v, t1), dot(v, n)}; }
  Vec3f world(const Vec3f& v) const { return v.x * t0 + v.y * t1 + v.z * n; }
};

// One pixel under the lighting, without what shines through.
class PixelShader {
 public:
  PixelShader(const LitScene& lit, const Microfacet& scatter, const ShadingFrame& frame, const Vec3f& place, const Vec3f& origin)
      : lit_(lit), light_(lit.lighting()), scatter_(scatter), frame_(frame), place_(place), origin_(origin) {}

  Vec3f shade(const SamplePoints& points, int samples) const {
    if (!scatter_.scatters()) return {};
    Vec3f sum{};
    for (uint32_t i = 0; i < static_cast<uint32_t>(samples); ++i) {
      if (!light_.environment.black()) sum += towards_environment(points.point(kLightPlane, i));
      for (size_t lamp = light_.sharp_lamps(); lamp < light_.lamps(); ++lamp)
        sum += towards_lamp(lamp, points.point(kLampPlane + static_cast<uint32_t>(lamp), i));
      sum += along_lobe(points.point(kLobePlane, i), points.point(kChoicePlane, i).x);
    }
    sum = sum / float(samples);
    for (size_t lamp = 0; lamp < light_.sharp_lamps(); ++lamp) sum += towards_lamp(lamp, {});
    return sum;
  }

 private:
  float visibility(const Vec3f& direction, float far = Lighting::kFar) const {
    return lit_.surface().visibility(origin_, direction, far);
  }
  // Up to the lamp and not beyond, where its ceiling may be.
  float visibility(const LampSample& s) const {
    if (!(s.distance < Lighting::kFar)) return visibility(s.direction);
    const Vec3f way = place_ + s.distance * s.direction - origin_;
    const float distance = length(way);
    return distance > 0 ? visibility(way / distance, distance) : 1.f;
  }
  // Balance heuristic (Veach and Guibas 1995): radiance f cos / pdf with weight pdf / (pdf + other).
  Vec3f towards_environment(const Vec2f& u) const {
    const Environment::Sample s = light_.environment.sample(u);
    const Vec3f l = frame_.local(s.direction);
    if (!(l.z > 0)) return {};
    const Vec3f f = scatter_.value(l);
    return (visibility(s.direction) / (s.pdf + scatter_.pdf(l))) * hadamard(f, s.radiance);
  }
  Vec3f towards_lamp(size_t lamp, const Vec2f& u) const {
    const LampSample s = light_.sample_lamp(lamp, place_, u);
    if (!(s.pdf > 0)) return {};
    const Vec3f l = frame_.local(s.direction);
    if (!(l.z > 0)) return {};
    const float other = lamp < light_.sharp_lamps() ? 0.f : scatter_.pdf(l);
    return (visibility(s) / (s.pdf + other)) * hadamard(scatter_.value(l), s.radiance);
  }
  Vec3f along_lobe(const Vec2f& u, float choice) const {
    const Vec3f l = scatter_.sample(choice, u);
    const float pdf = scatter_.pdf(l);
    if (!(l.z > 0 && pdf > 0)) return {};
    const Vec3f d = frame_.world(l);
    const LitScene::Arrival a = lit_.arriving(origin_, d);
    Vec3f radiance = a.from_scene / pdf;
    if (a.from_outside > 0 && !light_.environment.black())
      radiance += (a.from_outside / (pdf + light_.environment.pdf(d))) * light_.environment.radiance(d);
    for (size_t lamp = light_.sharp_lamps(); lamp < light_.lamps(); ++lamp) {
      const AreaLight& area = light_.areas[lamp - light_.sharp_lamps()];
      const auto t = area.hit(origin_, d);
      if (!t) continue;
      const float area_pdf = *t * *t / (-dot(d, area.normal) * area.area());
      radiance += (visibility(d, *t) / (pdf + area_pdf)) * area.radiance;
    }
    return hadamard(scatter_.value(l), radiance);
  }

  const LitScene& lit_;
  const Lighting& light_;
  const Microfacet& scatter_;
  const ShadingFrame& frame_;
  Vec3f place_, origin_;  // rays start a little above the place
};

// Pixels with something of glass in them.
std::vector<uint32_t> see_through(const GBuffer& g) {
  std::vector<uint32_t> out;
  for (uint32_t pixel = 0; pixel < g.pixels; ++pixel)
    if (g.alpha[pixel] >= kLeastCoverage && g.transmission[pixel] > kLeastCoverage * g.alpha[pixel]) out.push_back(pixel);
  return out;
}

// More than it scatters or lets through.
bool mirrors(LayerBlend blend, const RelitMaterial& m) {
  const LayerWeights<float> w = relit_weights(blend, m, 1);
  const Vec3f rest = hadamard(w.diffuse, m.albedo) + w.transmission;
  return w.reflection.x + w.reflection.y + w.reflection.z > rest.x + rest.y + rest.z;
}

Vec3f turned_to(const Vec3f& normal, const Vec3f& view) {
  const float cosine = dot(normal, view);
  return cosine >= kLeastCosine ? normal : normalized(normal + (kLeastCosine - cosine) * view);
}

}  // namespace

RelitPainter::RelitPainter(RelitScene scene)
    : scene_(std::move(scene)),
      surface_(scene_),
      glass_(scene_, surface_),
      shown_{.diffuse = material_layer(scene_)},
      model_(options_of(scene_)) {}

void RelitPainter::set_lighting(Lighting lighting, const LitSceneDesc& desc) {
  lighting_ = std::move(lighting);
  lit_ = std::make_unique<LitScene>(surface_, lighting_, desc);
  glass_.relight(*lit_, desc);
}

RelitPicture RelitPainter::picture(const View& view, const RelitPictureDesc& desc) {
  VITRINE_CHECK(lit_ != nullptr, "a relit picture needs a lighting");
  frame_.differentiable = false;
  model_.forward(shown_, view, frame_);
  const GBuffer g(frame_);
  const auto median_z = frame_.diffuse.plane(Aov::MedianZ);
  const int width = g.width, height = g.height;
  const bool glass = !glass_.empty();
  if (glass) glass_.look(frame_, see_through(g));
  const float snap = kSnap * surface_.grain(), lift = kMirrorLift * surface_.grain(), matt_lift = kMattLift * surface_.grain();
  const Environment& sky = lighting_.environment;
  RelitPicture out{ImageF(width, height, 3), ImageF(width, height, 3), ImageF(width, height, 1)};

  const auto shade = [&](uint32_t pixel) {
    const PixelRay<float> ray = g.ray(pixel);
    const float alpha = g.alpha[pixel];
    const Vec3f behind = alpha < 1 - kLeastCoverage ? (1 - alpha) * sky.radiance(-ray.view) : Vec3f{};
    if (alpha < kLeastCoverage) return sky.radiance(-ray.view);
    const Vec3f blended = g.rgb(g.normal, pixel);
    Vec3f normal = turned_to(squared_length(blended) > 0 ? normalized(blended) : ray.view, ray.view);
    RelitMaterial material{.albedo = g.rgb(g.color, pixel) / alpha,
                           .f0 = g.rgb(g.f0, pixel) / alpha,
                           .roughness = std::min(g.roughness[pixel] / alpha, 1.f),
                           .specular = g.specular[pixel] / alpha,
                           .transmission = glass ? g.transmission[pixel] / alpha : 0.f};
    const float z = surface_depth(g.zdepth[pixel], alpha, median_z[pixel]);
    Vec3f place = ray.eye + z * ray.direction_per_z;
    // Shadows come from the mesh: a ray starts on it where it means the same surface, and where it hides what the surfels show
    // (thin coverage at an outline); where the pixel misses the mesh, it starts towards the eye: never from inside.
    // Mirrors have its normals, too: training leaves theirs as the pictures in them want them. And their rays start right there,
    // for a picture in a mirror shifts with where its ray starts; those of matt things start before pits of the mesh that surfels
    // fill.
    const bool mirror = mirrors(scene_.blend(), material);
    // At a rim the blended normal looks at nothing in particular; that of the mesh is one surface's.
    material.agreement = normal_agreement(blended, alpha);
    Vec3f outwards = ray.view, on_mesh = place;
    const float t = z * length(ray.direction_per_z);
    // Walls around the scene are coarse, and in front of surfels here and there, by much in a corner: what the eye sees through
    // their front has the light that falls on it, not the dark behind it.
    if (const auto hit = surface_.first_hit(ray.eye, -ray.view);
        hit && hit->t < t + snap && (!surface_.surrounding(hit->face) || !hit->from_inside || hit->t > kNearWall_rel * t)) {
      on_mesh = ray.eye - hit->t * ray.view;
      if (mirror || hit->t < t) place = on_mesh;
      if (!hit->from_inside && mirror) {
        normal = turned_to(surface_.smooth_normal(*hit), ray.view);
        material.agreement = 1;
      }
      outwards = normalized(normal + (dot(hit->normal, ray.view) > 0 ? hit->normal : -hit->normal));
    }
    // Beside a lump of the mesh, `outwards` leads into it; towards the eye there is nothing.
    const Vec3f free = place + lift * ray.view, above = place + (mirror ? lift : matt_lift) * outwards;
    const Vec3f origin = surface_.free_between(free, above) ? above : free;
    const ShadingFrame frame(normal);
    const Microfacet scatter(scene_.blend(), material, frame.local(ray.view));
    Vec3f radiance = PixelShader(*lit_, scatter, frame, place, origin).shade(SamplePoints(desc.seed, pixel), desc.samples);
    if (material.transmission > kLeastCoverage) {
      const GlassContent::Seen seen = glass_.seen(pixel, on_mesh - lift * normal, -ray.view);
      Vec3f through = seen.radiance;
      if (seen.rest > kLeastCoverage) {
        const LitScene::Arrival a = lit_->arriving(seen.origin, seen.direction);
        through += seen.rest * (a.from_scene + a.from_outside * sky.radiance(seen.direction));
      }
      radiance += hadamard(scatter.transmission_weight(), through);
    }
    return alpha * radiance + behind;
  };

  for (int top = 0; top < height; top += kBandRows) {
    throw_if_interrupted();
    const int rows = std::min(kBandRows, height - top);
    constexpr int kRun = 32;  // pixels of one task
    const int runs = (width + kRun - 1) / kRun;
    parallel_for(static_cast<size_t>(rows) * static_cast<size_t>(runs), 1, [&](size_t task) {
      const int y = top + static_cast<int>(task) / runs, left = static_cast<int>(task) % runs * kRun;
      for (int x = left; x < std::min(left + kRun, width); ++x) {
        const uint32_t pixel = static_cast<uint32_t>(y) * static_cast<uint32_t>(width) + static_cast<uint32_t>(x);
        const Vec3f radiance = shade(pixel), albedo = g.rgb(g.color, pixel);
        for (size_t c = 0; c < 3; ++c) {
          out.radiance.at(x, y, int(c)) = radiance[c];
          out.albedo.at(x, y, int(c)) = albedo[c];
        }
        out.coverage.at(x, y) = g.alpha[pixel];
      }
    });
    if (desc.progress) desc.progress(double(top + rows) / height);
  }
  return out;
}

}  // namespace vitrine
