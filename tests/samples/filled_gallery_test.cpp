// Vessels with a medium: what the seeds hold, and that the medium is where the truth has it.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"
#include "sample_data/generate/capture.h"
#include "sample_data/generate/content.h"
#include "sample_data/generate/guest.h"
#include "sample_data/generate/integrator.h"
#include "sample_data/generate/scenes/gallery_layout.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kFilledSeeds = 12;

Scene bare_vessels(uint64_t seed) {
  Scene scene;
  const GalleryPlan plan = filled_plan(seed);
  add_gallery_views(scene, plan, seed);
  for (const PlacedPiece& placed : plan.pieces)
    for (const Part& part : placed.piece.parts) scene.parts.push_back(part);
  return scene;
}

std::vector<const Part*> filled_parts(const Scene& scene) {
  std::vector<const Part*> filled;
  for (const Part& part : scene.parts)
    if (part.material.content) filled.push_back(&part);
  return filled;
}

std::string piece_of(const Part& part) { return part.name.substr(0, part.name.find('/')); }

// A body of glass one metre thick, from z = 0 to 1.
Scene filled_block(float index, GlassContent content) {
  Scene scene;
  scene.parts.push_back({.name = "block",
                         .shape = box({-2, -2, 0}, {2, 2, 1}, 1),
                         .material = {.kind = MaterialKind::SolidGlass,
                                      .index_of_refraction = index,
                                      .content = std::make_shared<const GlassContent>(std::move(content))}});
  return scene;
}

TEST(FilledGallery, SeedsHoldOneOrTwoVesselsOfBothMediaSomeWithAnObjectInside) {
  size_t inhomogeneous = 0, solid = 0, thin = 0, with_object = 0, vessels = 0;
  for (uint64_t seed = 1; seed <= kFilledSeeds; ++seed) {
    const Scene scene = bare_vessels(seed);
    const std::vector<const Part*> filled = filled_parts(scene);
    EXPECT_TRUE(filled.size() == 1 || filled.size() == 2) << seed;
    for (const Part* part : filled) {
      const GlassContent& content = *part->material.content;
      EXPECT_TRUE(content.clouds().empty() == (seed % 2 == 1)) << seed;
      EXPECT_TRUE(seed % 2 == 0 || content.density() > 0) << seed;
      inhomogeneous += !content.clouds().empty(), ++vessels;
      (part->material.kind == MaterialKind::SolidGlass ? solid : thin) += 1;
      with_object += std::ranges::any_of(
          scene.parts, [&](const Part& other) { return piece_of(other) == piece_of(*part) && other.name.ends_with("/paint"); });
    }
  }
  EXPECT_GT(inhomogeneous, vessels / 4);
  EXPECT_LT(inhomogeneous, 3 * vessels / 4);
  EXPECT_GT(solid, 1u);
  EXPECT_GT(thin, 1u);
  EXPECT_GT(with_object, vessels / 5);
  EXPECT_LT(with_object, vessels);
}

TEST(FilledGallery, TheSameSeedIsTheSameSceneAndOthersDiffer) {
  const auto signature = [](uint64_t seed) {
    std::vector<Vec3f> values;
    const Scene scene = bare_vessels(seed);
    for (const Part& part : scene.parts) {
      values.insert(values.end(), part.shape.mesh.positions.begin(), part.shape.mesh.positions.end());
      if (!part.material.content) continue;
      const GlassContent& content = *part.material.content;
      values.push_back(content.color());
      values.push_back({content.density(), 0, 0});
      for (const auto& cloud : content.clouds()) values.push_back(cloud.gaussian.mean), values.push_back(cloud.color);
    }
    return values;
  };
  for (const uint64_t seed : {1, 2}) EXPECT_EQ(signature(seed), signature(seed));
  EXPECT_NE(signature(1), signature(3));
  EXPECT_NE(signature(2), signature(4));
}

TEST(FilledGallery, RaysBendIntoTheMediumByTheClosedForm) {
  const float density = 1.3f;
  for (const float index : {1.0f, 1.33f})
    for (const float sine : {0.0f, 0.4f, 0.8f}) {
      const Scene scene = filled_block(index, {density, {}, {}});
      const RayScene rays(scene);
      const Vec3f down{sine, 0, -std::sqrt(1 - sine * sine)};
      const double within = std::sqrt(1 - std::pow(double(sine) / double(index), 2));  // cosine, by Snell
      EXPECT_NEAR(double(rays.content_transmittance(Vec3f{0, 0, 1} - down, down)), std::exp(-double(density) / within), 1e-4)
          << index << " " << sine;
    }
}

// The density of content.json, integrated by 4000 steps between the two sides of a thin vessel, up to what stands in it.
TEST(FilledGallery, TheMediumIsWhereTheTruthHasIt) {
  const TemporaryFolder folder;
  size_t rays_within = 0;
  for (const uint64_t seed : {2, 4, 6, 8}) {
    const Scene scene = bare_vessels(seed);
    write_content(folder.path() / "content.json", scene);
    const auto truth = nlohmann::json::parse(read_file(folder.path() / "content.json"));
    const std::vector<const Part*> filled = filled_parts(scene);
    ASSERT_EQ(truth.size(), filled.size());
    for (size_t v = 0; v < filled.size(); ++v) {
      const auto& body = truth[v];
      EXPECT_EQ(body.at("part"), filled[v]->name);
      EXPECT_EQ(body.at("index_of_refraction"), 1);
      const auto vec = [](const nlohmann::json& row) { return Vec3f{row[0], row[1], row[2]}; };
      const Vec3f low = vec(body.at("bounds")[0]), high = vec(body.at("bounds")[1]), middle = 0.5f * (low + high);
      Scene alone;  // the wall and what stands in it
      for (const Part& part : scene.parts)
        if (piece_of(part) == piece_of(*filled[v])) alone.parts.push_back(part);
      const RayScene rays(alone);
      for (int i = 0; i < 8; ++i) {
        const Vec3f origin = middle + Vec3f{std::cos(float(i)), std::sin(float(i)), 0.2f};
        const Vec3f target = middle + 0.06f * (high.z - low.z) * Vec3f{std::sin(3.f * float(i)), 0, std::cos(5.f * float(i))};
        const Vec3f direction = normalized(target - origin);
        const std::optional<Hit> entry = rays.first_hit(origin, direction);
        if (!entry || !entry->glass()) continue;
        const std::optional<Hit> exit = rays.first_hit(offset_origin(*entry, direction), direction);
        ASSERT_TRUE(exit);
        constexpr int kSteps = 4000;
        double depth = 0;
        for (int k = 0; k < kSteps; ++k) {
          const Vec3f p = entry->position + exit->distance * (float(k) + 0.5f) / kSteps * direction;
          double density = body.at("density_per_m");
          for (const auto& cloud : body.at("clouds")) {
            const auto& q = cloud.at("rotation");
            const Vec3f local = transposed(rotation_matrix(Quatf{q[0], q[1], q[2], q[3]})) * (p - vec(cloud.at("mean")));
            const Vec3f deviations = vec(cloud.at("deviations"));
            double squared = 0;
            for (size_t c = 0; c < 3; ++c) squared += std::pow(double(local[c] / deviations[c]), 2);
            density += cloud.at("density_per_m").get<double>() * std::exp(-squared / 2);
          }
          depth += density * double(exit->distance) / kSteps;
        }
        EXPECT_NEAR(double(rays.content_transmittance(origin, direction)), std::exp(-depth), 1e-3) << seed << " " << i;
        EXPECT_EQ(rays.content_at(0.5f * (entry->position + exit->position)),
                  alone.parts[entry->part_index].material.content.get());
        ++rays_within;
      }
      EXPECT_EQ(rays.content_at(high + Vec3f{0.01f, 0, 0}), nullptr);
      EXPECT_EQ(rays.content_at(low - Vec3f{0.01f, 0, 0}), nullptr);
    }
  }
  EXPECT_GT(rays_within, 20u);
}

TEST(FilledGallery, TheMaskOfTheContentIsGlassThatTakesLight) {
  Scene scene = bare_vessels(2);
  scene.views.resize(1);
  View& view = scene.views.front();
  view.intrinsics = view.intrinsics.scaled_to(80, 60);
  const SurfacePictures filled = first_surface(RayScene(scene), view);
  size_t seen = 0;
  for (size_t i = 0; i < filled.content.data().size(); ++i) {
    seen += filled.content.data()[i] > 0;
    ASSERT_TRUE(filled.content.data()[i] == 0 || filled.transparent.data()[i] > 0) << i;
  }
  EXPECT_GT(seen, 100u);
  for (Part& part : scene.parts) part.material.content = nullptr;
  const Image8 clear = first_surface(RayScene(scene), view).content;
  EXPECT_TRUE(std::ranges::all_of(clear.data(), [](uint8_t v) { return v == 0; }));
}

TEST(GlassContent, MovesWithItsBody) {
  const Scene scene = bare_vessels(2);
  const GlassContent& content = *filled_parts(scene)[0]->material.content;
  const GuestPlace place{.x = 0.3f, .y = -0.2f, .turn_rad = 0.7f, .scale = 1.6f};
  Scene host, guest;
  guest.parts.push_back(*filled_parts(scene)[0]);
  add_guest(host, guest, place);
  const GlassContent& moved = *host.parts.at(0).material.content;
  const auto image = [&](const Vec3f& p, float scale) {
    const float c = std::cos(place.turn_rad), s = std::sin(place.turn_rad);
    return scale * Vec3f{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
  };
  const Vec3f direction = normalized(Vec3f{1, 0.4f, -0.2f});
  for (const auto& cloud : content.clouds()) {
    const Vec3f origin = cloud.gaussian.mean - 0.03f * direction, by{place.x, place.y, 0};
    const Vec3f start = image(origin, place.scale) + by, towards = image(direction, 1);
    EXPECT_NEAR(content.transmittance(origin, direction, 0.1f), moved.transmittance(start, towards, 0.16f), 1e-4f);
    EXPECT_LT(length(content.light(origin, direction, 0.1f).color - moved.light(start, towards, 0.16f).color), 1e-4f);
  }
}

// A plate inside an opaque glow, and above the body a lamp of which nothing arrives.
TEST(GlassContent, LightsWhatStandsInIt) {
  Scene scene = filled_block(1, {60, {0.5f, 0.25f, 0}, {}});
  scene.parts.push_back({.name = "plate",
                         .shape = rectangle({-0.2f, -0.2f, 0.5f}, {0.4f, 0, 0}, {0, 0.4f, 0}, 0.4f),
                         .material = {.albedo = [](const SurfacePoint&) {
                           return Vec3f{1, 1, 1};
                         }}});
  scene.environment = Environment(ImageF(16, 8, 3, 1.0f));
  const RayScene rays(scene);
  const Integrator integrator(rays, {.environment = scene.environment, .lamps = {}});
  IrradianceCache cache(scene);
  integrator.solve_irradiance(cache, {.direct_samples = 8, .gather_samples = 8, .passes = 1});
  const std::optional<Hit> hit = rays.first_hit({0, 0, 0.9f}, {0, 0, -1});
  ASSERT_TRUE(hit && hit->part->name == "plate");
  const Vec3f irradiance = cache.irradiance(*hit);
  EXPECT_NEAR(irradiance.x, 0.5f * kPi, 0.02f);
  EXPECT_NEAR(irradiance.y, 0.25f * kPi, 0.02f);
  EXPECT_NEAR(irradiance.z, 0, 1e-3f);
}

}  // namespace
}  // namespace vitrine::generate
