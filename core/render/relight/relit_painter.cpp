#include "core/render/relight/relit_painter.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/gbuffer.h"
#include "core/render/relight/pixel_shader.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr double kMiddleGrey = 0.18;
constexpr float kLeastCoverage = 1 / 255.f;
constexpr int kBandRows = 8;
constexpr float kNearMesh = 2;            // in grains: how far a pixel's surface may be from the mesh that knows its light
constexpr uint64_t kBehindStream = 0xb3;  // sample points of surfaces behind glass

ImageOptions options_of(const RelitScene& scene) {
  ImageOptions o = scene.trained.image;
  o.medium.reset();  // its light is not that of the new one
  o.diffuse.materials = true;
  o.diffuse.sh_degree = 0;
  return o;
}

// Pixels that show glass.
std::vector<uint32_t> see_through(const GBuffer& g) {
  std::vector<uint32_t> out;
  for (uint32_t pixel = 0; pixel < g.pixels; ++pixel)
    if (g.alpha[pixel] >= kLeastCoverage && g.transmission[pixel] > kLeastCoverage * g.alpha[pixel]) out.push_back(pixel);
  return out;
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
  lit_ = std::make_shared<const LitScene>(surface_, lighting_, desc);
  glass_.relight(*lit_, desc);
}

void RelitPainter::share_lighting(const RelitPainter& other, const LitSceneDesc& desc) {
  lighting_ = other.lighting_;
  lit_ = other.lit_;
  glass_.relight(*lit_, desc);
}

// Where the mesh knows more of a pixel's surface than its surfels do; nullopt: nothing more is known.
std::optional<SurfacePlace> RelitPainter::place_on_mesh(const LitPlace& at, const SceneSurface& surface) const {
  if (surface_.subsurface().empty() && surface_.marks().empty()) return std::nullopt;
  const float reach = kNearMesh * surface_.grain();
  return surface.front_near(at.on_mesh + reach * at.normal, -at.normal, 2 * reach);
}

// Radiance of the light that leaves a place after it scattered below the surface. The share of the albedo that sends it is taken
// from the material.
Vec3f RelitPainter::from_below(ShownSurface& shown, const LitPlace& at, const SurfacePlace& place, const Vec3f& eye) const {
  const SubsurfaceFilter& filter = surface_.subsurface();
  if (filter.empty()) return {};
  const SceneSurface& lit = lit_->surface();  // another one, with other vertices, if the lighting is shared
  const auto lit_place = &lit == &surface_ ? std::optional(place) : place_on_mesh(at, lit);
  if (!lit_place) return {};
  const Vec3f share = surface_.at(filter.share(), place);
  const Vec3f leaving = hadamard(share, lit.at(lit_->irradiance(), *lit_place)) / Microfacet::kPi;
  const Vec3f diffuse = relit_weights(scene_.blend(), shown.material, eye.z).diffuse, albedo = shown.material.albedo;
  shown.material.albedo = hadamard(Vec3f{1, 1, 1} - share, albedo);
  return hadamard(diffuse, hadamard(albedo, leaving));
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
  const Environment& sky = lighting_.environment;
  RelitPicture out{ImageF(width, height, 3), ImageF(width, height, 3), ImageF(width, height, 1)};

  struct ShadedSurface {
    LitPlace at;
    Vec3f radiance, transmission;
  };
  const auto shaded = [&](ShownSurface shown, const SamplePoints& points) {
    const LitPlace at = lit_place(surface_, scene_.trained.image.shape.set.get(), scene_.blend(), shown);
    shown.material.agreement = at.agreement;
    const auto place = place_on_mesh(at, surface_);
    const Vec3f marks = place && !surface_.marks().empty() ? surface_.at(surface_.marks(), *place) : Vec3f{};
    const ShadingFrame frame(at.normal, marks);
    shown.material.anisotropy = std::min(length(marks), 1.f);
    const Vec3f eye = frame.local(shown.ray.view);
    const Vec3f below = place ? from_below(shown, at, *place, eye) : Vec3f{};
    const Microfacet scatter(scene_.blend(), shown.material, eye);
    return ShadedSurface{at, below + PixelShader(*lit_, scatter, frame, at.place, at.origin).shade(points, desc.samples),
                         scatter.transmission_weight()};
  };
  const auto shade = [&](uint32_t pixel) {
    const PixelRay<float> ray = g.ray(pixel);
    const float alpha = g.alpha[pixel];
    const Vec3f behind = alpha < 1 - kLeastCoverage ? (1 - alpha) * sky.radiance(-ray.view) : Vec3f{};
    if (alpha < kLeastCoverage) return sky.radiance(-ray.view);
    ShownSurface shown = shown_surface(g, median_z, pixel, ray);
    if (!glass) shown.material.transmission = 0;
    const ShadedSurface front = shaded(shown, SamplePoints(desc.seed, pixel));
    Vec3f radiance = front.radiance;
    if (shown.material.transmission > kLeastCoverage) {
      const GlassContent::Seen seen = glass_.seen(pixel, front.at.on_mesh - mirror_lift(surface_) * front.at.normal, -ray.view);
      Vec3f through = seen.radiance;
      if (const auto specular = glass_.specular_surface(pixel, ray))
        through += specular->alpha * shaded(*specular, SamplePoints(mix64(desc.seed, kBehindStream), pixel)).radiance;
      if (seen.rest > kLeastCoverage) {
        const LitScene::Arrival a = lit_->arriving(seen.origin, seen.direction);
        through += seen.rest * (a.from_scene + a.from_outside * sky.radiance(seen.direction));
      }
      radiance += hadamard(front.transmission, through);
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

double exposure_of_scene(const LitScene& lit) {
  double sum = 0;
  for (const Vec3f& b : lit.radiance()) sum += 0.2126 * b.x + 0.7152 * b.y + 0.0722 * b.z;
  return sum > 0 ? std::round(10 * std::log2(kMiddleGrey * double(lit.radiance().size()) / sum)) / 10 : 0;
}

Image8 developed(const ImageF& radiance, double stops) {
  ImageF scaled = radiance;
  const auto gain = static_cast<float>(std::exp2(stops));
  for (float& v : scaled.data()) v *= gain;
  return srgb8_from_linear(scaled);
}

}  // namespace vitrine
