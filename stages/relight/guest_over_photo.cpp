// Differential rendering (Debevec, "Rendering Synthetic Objects into Real Scenes", 1998) with a ratio in place of a difference:
// the photo knows the texture of the host better than its albedo does.
//   picture = a G + (1 - a) P H1 / H0
// a: visible share of the guest in the pixel; G: its radiance; P: photo; H1, H0: radiance of the host's surfaces with and without
// the guest, from the same sample points, so that their noise cancels where the guest changes nothing.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/config/json_file.h"
#include "core/render/raster/renderer.h"
#include "core/render/relight/relit_painter.h"
#include "stages/relight/relight.h"

namespace vitrine {

namespace {

constexpr float kLeastRadiance_rel = 1e-4f;  // of the mean of the picture: darker surfaces have no ratio
constexpr float kBrightestRatio = 4;         // light that the guest reflects or focuses
constexpr float kSurface = 0.5f;             // coverage from which the host has a surface
constexpr float kLeastCoverage = 1 / 255.f;

float luminance(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

// The parts with one of these ids, or all others.
EditScene part_of(EditScene scene, std::span<const uint16_t> ids, bool with) {
  const auto flags = [&](std::span<const uint16_t> of, size_t count) {
    std::vector<uint8_t> out(count, !with);
    for (size_t i = 0; i < of.size(); ++i) out[i] = (std::ranges::find(ids, of[i]) != ids.end()) == with;
    return out;
  };
  SplatScene& surfels = scene.trained.surfels;
  scene.there.diffuse = flags(surfels.diffuse.object_ids(), surfels.diffuse.size());
  scene.there.transmittance = flags(surfels.transmittance.object_ids(), surfels.transmittance.size());
  scene.there.vertices = flags(scene.mesh.object_ids, scene.mesh.positions.size());
  scene.there.walls = flags(scene.surroundings.object_ids, scene.surroundings.positions.size());
  scene.there.content = flags(scene.content.object_ids, scene.content.positions.size());
  for (size_t f = 0; f < scene.mesh.faces.size(); ++f)
    scene.there.faces[f] = std::ranges::all_of(scene.mesh.faces[f], [&](uint32_t v) { return scene.there.vertices[v] != 0; });
  return kept(std::move(scene));
}

RelitScene relit(EditScene scene) {
  RelitScene out;
  out.trained = std::move(scene.trained);
  out.materials = std::move(*scene.materials);
  out.mesh = std::move(scene.mesh), out.behind_glass = std::move(scene.content);
  out.surroundings = std::move(scene.surroundings);
  return out;
}

// [h, w] share of each pixel that shows the guests.
std::vector<float> visible_share(const EditScene& scene, std::span<const uint16_t> guests, const View& view) {
  const SplatLayer& diffuse = scene.trained.surfels.diffuse;
  std::vector<Vec3f> colors(diffuse.size());
  for (size_t i = 0; i < diffuse.object_ids().size(); ++i)
    if (std::ranges::find(guests, diffuse.object_ids()[i]) != guests.end()) colors[i] = {1, 1, 1};
  RasterDesc desc;
  desc.intrinsics = view.intrinsics, desc.cam_from_world = view.cam_from_world;
  desc.sh_degree = 0, desc.near_z = scene.trained.image.diffuse.near_z;
  RasterImages images;
  make_renderer(Backend::Cpu)->forward(painted_layer(diffuse, colors), desc, images);
  const auto red = images.plane(Aov::Color).first(size_t(view.intrinsics.width) * size_t(view.intrinsics.height));
  std::vector<float> out(red.begin(), red.end());
  for (float& a : out) a = std::clamp(a, 0.f, 1.f);
  return out;
}

// Mean luminance of the pixels where the host has a surface, of the image times a colour.
double mean_luminance(const ImageF& image, const Vec3f& gain, const ImageF& coverage) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    if (!(coverage.data()[i] > kSurface)) continue;
    const float* rgb = &image.data()[3 * i];
    const std::array<float, 3> seen{rgb[0] * gain.x, rgb[1] * gain.y, rgb[2] * gain.z};
    sum += double(luminance(seen.data())), ++count;
  }
  return count > 0 ? sum / count : 0;
}

// Radiance of the surface in a pixel of a relit picture, without the environment where it covers a part of the pixel.
Vec3f surface_radiance(const RelitPicture& picture, const Environment& sky, const View& view, int x, int y) {
  const float covered = picture.coverage.at(x, y);
  if (!(covered > kLeastCoverage)) return {};
  const Vec3f behind = (1 - covered) * sky.radiance(normalized(cast<float>(view.ray(x + 0.5, y + 0.5))));
  Vec3f out;
  for (size_t c = 0; c < 3; ++c) out[c] = std::max(picture.radiance.at(x, y, int(c)) - behind[c], 0.f) / covered;
  return out;
}

}  // namespace

std::vector<uint16_t> guest_ids(const fs::path& compose) {
  std::vector<uint16_t> out;
  const fs::path file = compose / "compose" / "report.json";
  read_json_file(file, "report of a composition", [&](const nlohmann::json& json) {
    const JsonAt root(json), parts = root.at("parts");
    for (size_t p = 1, count = parts.list("a list of parts").size(); p < count; ++p) {
      const JsonAt ids = parts[p].at("objects");
      for (size_t i = 0, n = ids.list("a list of ids").size(); i < n; ++i) out.push_back(uint16_t(ids[i].number()));
    }
  });
  if (!out.empty()) return out;
  throw Error(ErrorKind::Input, "the composition has no guest: it has one part",
              {.where = file.string(), .hint = "add a part to the list of vitrine compose", .code = "NO_GUEST"});
}

GuestPicture guest_over_photo(const EditScene& scene, std::span<const uint16_t> guests, const Lighting& lighting,
                              const GuestDesc& desc) {
  const LitSceneDesc light{.seed = desc.seed};
  const RelitPictureDesc pixels{.samples = desc.samples, .seed = desc.seed};
  const std::vector<float> share = visible_share(scene, guests, desc.view);
  RelitPainter all(relit(scene)), host(relit(part_of(scene, guests, false))), guest(relit(part_of(scene, guests, true)));
  all.set_lighting(lighting, light);
  host.set_lighting(lighting, light);
  const RelitPicture without = host.picture(desc.view, pixels);
  host.share_lighting(all, light);
  const RelitPicture with = host.picture(desc.view, pixels);
  guest.share_lighting(all, light);
  // Through glass of the guest the host is visible.
  const bool glass = guest.scene().trained.surfels.transmittance.size() > 0;
  const RelitPicture shown = (glass ? all : guest).picture(desc.view, pixels);

  const ImageF& photo = desc.photo;
  const auto of_photo = cast<float>(desc.view.gain);
  const double level = mean_luminance(without.radiance, of_photo, without.coverage);
  const double match = level > 0 ? mean_luminance(photo, {1, 1, 1}, without.coverage) / level : 1;
  const Vec3f gain = float(desc.stops ? std::exp2(*desc.stops) : match) * of_photo;
  const auto least = float(level) * kLeastRadiance_rel;
  GuestPicture out{ImageF(photo.width(), photo.height(), 4), ImageF(photo.width(), photo.height(), 3, 1.f),
                   ImageF(photo.width(), photo.height(), 3)};
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 0; x < photo.width(); ++x) {
      Vec3f ratio{1, 1, 1};
      if (without.coverage.at(x, y) > kSurface)
        for (int c = 0; c < 3; ++c)
          if (const float h0 = without.radiance.at(x, y, c); h0 > least)
            ratio[size_t(c)] = std::clamp(with.radiance.at(x, y, c) / h0, 0.f, kBrightestRatio);
      const float a = share[size_t(y) * size_t(photo.width()) + size_t(x)];
      const Vec3f seen = a * hadamard(gain, surface_radiance(shown, lighting.environment, desc.view, x, y));
      for (int c = 0; c < 3; ++c) {
        out.shadow.at(x, y, c) = ratio[size_t(c)];
        out.over.at(x, y, c) = seen[size_t(c)];
        out.composite.at(x, y, c) = seen[size_t(c)] + (1 - a) * ratio[size_t(c)] * photo.at(x, y, c);
      }
      out.over.at(x, y, 3) = 1 - (1 - a) * std::min(luminance(&ratio.x), 1.f);
    }
  return out;
}

}  // namespace vitrine
