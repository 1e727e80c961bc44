// Scale, heading and place from GPS coordinates: exact ones, noisy ones with outliers, and those that give no scale.
#include "stages/sfm/gps_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "stages/sfm/similarity_fit.h"
#include "tests/core/intake/poses/synthetic_model.h"

namespace vitrine {
namespace {

const Geodetic kPlace{47.3769, 8.5417, 431};

// Cameras at places in metres (east, north, up), seen from a model of another scale, rotation and place.
struct Capture {
  std::vector<Vec3d> places;
  Similarity model_from_local{0.07, rotation_matrix(normalized(Quatd{0.9, 0.2, -0.3, 0.1})), {5, -3, 11}};
  Geodetic middle = kPlace;
  double noise_m = 0;  // standard deviation of east and north; that of up is twice as much
  uint64_t seed = 1;
  bool altitudes = true;

  std::vector<GpsSighting> sightings() const {
    const LocalFrame frame(middle);
    std::vector<GpsSighting> out;
    for (size_t i = 0; i < places.size(); ++i) {
      Rng rng(seed, i);
      const double east = rng.normal(), north = rng.normal(), up = rng.normal();
      const Geodetic g = frame.place(places[i] + noise_m * Vec3d{east, north, 2 * up});
      out.push_back({model_from_local * places[i],
                     {g.latitude, g.longitude, altitudes ? std::optional(g.altitude) : std::nullopt, {}, {}}});
    }
    return out;
  }
  GpsPriors priors(UpMethod method = UpMethod::Level) const {
    return {.orientation = {model_from_local.rotation * Vec3d{0, 0, 1}, method}};
  }
  GpsFit fit() const { return *fitted_gps(sightings(), priors()); }
  double true_scale() const { return 1 / model_from_local.scale; }
};

std::vector<Vec3d> circle(size_t n, double radius, double height = 1.5) {
  std::vector<Vec3d> out;
  for (size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * double(i) / double(n);
    out.push_back({radius * std::cos(angle), radius * std::sin(angle), height + 0.3 * std::sin(5 * angle)});
  }
  return out;
}

std::vector<Vec3d> line(size_t n, double spacing) {
  std::vector<Vec3d> out;
  for (size_t i = 0; i < n; ++i) out.push_back({spacing * double(i) * 0.6, spacing * double(i) * 0.8, 1.5});
  return out;
}

double degrees(const Vec3d& a, const Vec3d& b) {
  return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1.0, 1.0)) * 180 / std::numbers::pi;
}

void expect_exact(const Capture& capture, double tolerance) {
  const GpsFit fit = capture.fit();
  ASSERT_EQ(fit.refused, "");
  EXPECT_NEAR(fit.local_from_model.scale, capture.true_scale(), tolerance * capture.true_scale());
  const Mat3d& r = fit.local_from_model.rotation;
  EXPECT_LT(degrees(r * (capture.model_from_local.rotation * Vec3d{1, 0, 0}), {1, 0, 0}), 100 * tolerance);
  EXPECT_LT(degrees(r * (capture.model_from_local.rotation * Vec3d{0, 0, 1}), {0, 0, 1}), 100 * tolerance);
  EXPECT_EQ(fit.agreeing, capture.places.size());
  EXPECT_LT(fit.rms_m, 1e-3);
}

TEST(GpsFrame, ExactCoordinatesGiveScaleHeadingAndUp) {
  expect_exact({.places = circle(12, 15)}, 1e-6);
  expect_exact({.places = circle(12, 15), .altitudes = false}, 1e-4);  // 431 m above the ellipsoid: 0.7e-4 of the radius
  expect_exact({.places = circle(4, 15)}, 1e-6);
  expect_exact({.places = circle(12, 15), .middle = {-16.8, 180, 12}}, 1e-6);  // both signs of the longitude
  expect_exact({.places = circle(300, 40)}, 1e-6);
}

TEST(GpsFrame, NoiseAndOutliersLeaveTheScale) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Capture capture{.places = circle(24, 20), .noise_m = 1.2, .seed = seed};
    std::vector<GpsSighting> sightings = capture.sightings();
    for (size_t i = 0; i < 24; i += 4) sightings[i].gps.latitude += 0.0006 * (1 + double(i) / 8);  // 70 m and more
    sightings[3].gps.altitude = 900;
    const GpsFit fit = *fitted_gps(sightings, capture.priors());
    ASSERT_EQ(fit.refused, "") << seed;
    EXPECT_NEAR(fit.local_from_model.scale / capture.true_scale(), 1, 0.05) << seed;
    EXPECT_LT(degrees(fit.local_from_model.rotation * (capture.model_from_local.rotation * Vec3d{1, 0, 0}), {1, 0, 0}), 4)
        << seed;
    EXPECT_LE(fit.agreeing, 17u);
    EXPECT_GT(fit.rms_m, 0.8);
    EXPECT_LT(fit.rms_m, 2.5);
  }
}

TEST(GpsFrame, NoiseIsNoScale) {
  // Rooms and objects between receivers of 1 to 8 m: none may be accepted with a wrong scale.
  size_t accepted = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed)
    for (const size_t n : {4u, 5u, 8u, 24u})
      for (const auto& [radius, noise] : {std::pair(2.0, 5.0), std::pair(2.0, 1.0), std::pair(4.0, 2.0), std::pair(0.5, 8.0)})
        for (const auto& places : {circle(n, radius), line(n, 2 * radius / double(n))}) {
          const Capture capture{.places = places, .noise_m = noise, .seed = seed};
          const GpsFit fit = capture.fit();
          if (!fit.used()) continue;
          ++accepted;
          EXPECT_NEAR(fit.local_from_model.scale / capture.true_scale(), 1, 0.25)
              << seed << ": " << n << " photos within " << radius << " m, noise " << noise << " m";
        }
  EXPECT_LT(accepted, 10u) << "of 640";
  const Capture room{.places = circle(24, 2), .noise_m = 5};
  EXPECT_NE(gps_text(room.fit()).find("no scale from GPS of 24 photos: "), std::string::npos) << gps_text(room.fit());
}

TEST(GpsFrame, ALineGivesTheScaleAndKeepsUp) {
  const Capture capture{.places = line(12, 5), .noise_m = 0.6};
  const GpsFit fit = capture.fit();
  ASSERT_EQ(fit.refused, "");
  EXPECT_TRUE(fit.on_a_line);
  EXPECT_NEAR(fit.local_from_model.scale / capture.true_scale(), 1, 0.04);
  EXPECT_LT(degrees(fit.local_from_model.rotation * (capture.model_from_local.rotation * Vec3d{0, 0, 1}), {0, 0, 1}), 3);
  EXPECT_NE(gps_text(fit).find("the photos stand on one line"), std::string::npos);
}

TEST(GpsFrame, FewOrEqualPositionsAreRefusedWithTheReason) {
  const auto why = [](const Capture& capture, auto&& change) {
    std::vector<GpsSighting> sightings = capture.sightings();
    for (size_t i = 0; i < sightings.size(); ++i) change(i, sightings[i].gps);
    const auto fit = fitted_gps(sightings, capture.priors());
    return fit ? fit->refused : "nothing to fit";
  };
  const auto nothing = [](size_t, GpsPosition&) {};
  EXPECT_EQ(why({.places = {}}, nothing), "nothing to fit");
  EXPECT_EQ(why({.places = circle(3, 15)}, nothing), "3 photos have coordinates, 4 are needed");
  EXPECT_EQ(why({.places = circle(12, 15)}, [](size_t, GpsPosition& g) { g.latitude = 47, g.longitude = 8; }),
            "12 photos with coordinates stand on 1 spot, 4 are needed");
  EXPECT_EQ(
      why({.places = circle(12, 15)}, [](size_t i, GpsPosition& g) { g.latitude = 47 + 0.001 * double(i / 4), g.longitude = 8; }),
      "12 photos with coordinates stand on 3 different spots, 4 are needed");
  EXPECT_EQ(why({.places = circle(12, 15)}, [](size_t i, GpsPosition& g) { g.error_m = i < 3 ? 4 : 65; }),
            "3 photos have coordinates with a stated error below 20 m, 4 are needed");
  EXPECT_EQ(why({.places = circle(12, 15)},
                [](size_t i, GpsPosition& g) {
                  if (i == 5) g.datum = "TOKYO";
                }),
            "the coordinates refer to the datum 'TOKYO', not to WGS84");
}

TEST(GpsFrame, APlaceWithALargeStatedErrorAgreesFromFartherAway) {
  const Capture capture{.places = circle(12, 25)};
  std::vector<GpsSighting> sightings = capture.sightings();
  sightings[2].gps.latitude += 7 / 111000.0;  // 7 m
  EXPECT_EQ(fitted_gps(sightings, capture.priors())->agreeing, 11u);
  sightings[2].gps.error_m = 12;
  EXPECT_EQ(fitted_gps(sightings, capture.priors())->agreeing, 12u);
}

TEST(GpsFrame, GivenPosesInMetresKeepTheirUnit) {
  Capture capture{.places = circle(24, 20), .noise_m = 1};
  GpsPriors priors = capture.priors();
  priors.given_poses = true;
  const GpsFit other = *fitted_gps(capture.sightings(), priors);
  EXPECT_FALSE(other.confirms_metres) << "a unit of 14 m is no metre";
  EXPECT_NEAR(other.local_from_model.scale / capture.true_scale(), 1, 0.05);
  capture.model_from_local.scale = 1;
  const GpsFit fit = *fitted_gps(capture.sightings(), priors);
  EXPECT_TRUE(fit.confirms_metres);
  EXPECT_EQ(fit.local_from_model.scale, 1);
  EXPECT_NE(gps_text(fit).find("given poses in metres, confirmed by GPS of 24 of 24 photos"), std::string::npos) << gps_text(fit);
  priors.given_poses = false;
  EXPECT_NE(fitted_gps(capture.sightings(), priors)->local_from_model.scale, 1) << "structure from motion has no unit";
}

TEST(GpsFrame, AChosenUpStays) {
  const Capture capture{.places = circle(24, 20)};
  GpsPriors priors = capture.priors(UpMethod::Mean);
  priors.orientation.up = capture.model_from_local.rotation * normalized(Vec3d{0.05, 0, 1});
  const Vec3d up = normalized(priors.orientation.up);
  EXPECT_GT(degrees(fitted_gps(capture.sightings(), priors)->local_from_model.rotation * up, {0, 0, 1}), 2);
  priors.up_chosen = true;
  EXPECT_LT(degrees(fitted_gps(capture.sightings(), priors)->local_from_model.rotation * up, {0, 0, 1}), 0.2);
}

TEST(GpsFrame, TheSameBitsEveryTime) {
  const Capture capture{.places = circle(40, 20), .noise_m = 1.5};
  const GpsFit a = capture.fit(), b = capture.fit();
  EXPECT_EQ(a.local_from_model.scale, b.local_from_model.scale);
  EXPECT_EQ(a.local_from_model.rotation, b.local_from_model.rotation);
  EXPECT_EQ(a.local_from_model.translation, b.local_from_model.translation);
}

TEST(GpsFrame, TheSceneIsEastNorthUpAroundItsOrigin) {
  // The ring of the model stands at one unit to 12.5 m, turned by 40 degrees.
  const ColmapModel model = synthetic_model(ring(16, 3, 1.5, {0, 0, 1}), cloud(50, 1));
  const double turn = 40 * std::numbers::pi / 180;
  const Similarity local_from_model{
      12.5, rotation_matrix(normalized(Quatd{std::cos(turn / 2), 0, 0, std::sin(turn / 2)})), {3, 4, 5}};
  std::vector<Photo> photos;
  for (const ColmapImage& image : model.images) {
    Photo& p = photos.emplace_back();
    p.name = image.name;
    const Geodetic g = LocalFrame(kPlace).place(local_from_model * inverse(image.cam_from_world()).translation);
    p.gps = GpsPosition{g.latitude, g.longitude, g.altitude, {}, {}};
  }
  photos.resize(14);  // two of the cameras are without
  Orientation orientation = scene_up(model);
  std::optional<GpsFit> fit = fitted_gps(gps_sightings(model, photos), {.orientation = orientation});
  const SceneInfo scene = framed_scene(model, orientation, fit);
  ASSERT_TRUE(scene.geo);
  EXPECT_EQ(fit->photos, 14u);
  EXPECT_TRUE(scene.scale_known);
  EXPECT_NEAR(*scene.metres_per_unit(), 12.5 / scene.scene_from_colmap.scale, 1e-4);
  const LocalFrame around({scene.geo->latitude, scene.geo->longitude, *scene.geo->altitude});
  for (const ColmapImage& image : model.images) {
    const Vec3d centre = inverse(image.cam_from_world()).translation;
    const Vec3d by_gps = around.local(LocalFrame(kPlace).place(local_from_model * centre));
    const Vec3d by_scene = *scene.metres_per_unit() * (scene.scene_from_colmap * centre);
    EXPECT_LT(length(by_gps - by_scene), 1e-3) << image.name;
  }
}

TEST(GpsFrame, WithoutGpsTheFrameIsThatOfThePhotos) {
  const ColmapModel model = synthetic_model(ring(16, 3, 1.5, {0, 0, 1}), cloud(50, 1));
  Orientation orientation = scene_up(model);
  const Similarity before = scene_from_colmap(model, orientation);
  std::optional<GpsFit> none = fitted_gps(gps_sightings(model, std::vector<Photo>{}), {.orientation = orientation});
  EXPECT_FALSE(none);
  const SceneInfo scene = framed_scene(model, orientation, none);
  EXPECT_FALSE(scene.geo);
  EXPECT_FALSE(scene.scale_known);
  EXPECT_EQ(scene.scene_from_colmap.rotation, before.rotation);
  EXPECT_EQ(scene.scene_from_colmap.scale, before.scale);
}

TEST(SimilarityFit, RefinementConvergesFromAWrongStart) {
  const Capture capture{.places = circle(12, 15)};
  std::vector<SpotPair> pairs;
  for (const Vec3d& p : capture.places) pairs.push_back({capture.model_from_local * p, p});
  const Similarity truth = inverse(capture.model_from_local);
  const UpPrior up{normalized(capture.model_from_local.rotation * Vec3d{0, 0, 1})};
  Similarity start = truth;
  start.scale *= 1.08;
  start.rotation = Mat3d{rotation_matrix(normalized(Quatd{1, 0.02, -0.03, 0.05})) * truth.rotation};
  Vec3d middle{};
  for (const SpotPair& p : pairs) middle += p.from / 12.0;
  start.translation = truth * middle - start.scale * (start.rotation * middle) + Vec3d{1, -1, 0.5};
  const Similarity s = refined(start, pairs, up);
  EXPECT_LT(truncated_cost(s, pairs, up), 1e-9);
  EXPECT_GT(truncated_cost(start, pairs, up), 0.1);
  EXPECT_NEAR(s.scale / truth.scale, 1, 1e-7);
}

TEST(SimilarityFit, SpotsThatCoincideOrLieOnALineGiveNoHypothesis) {
  const Vec3d up{0, 0, 1};
  EXPECT_FALSE(similarity_of_two({{1, 2, 0}, {0, 0, 0}}, {{1, 2, 5}, {3, 0, 0}}, up)) << "one above the other";
  EXPECT_FALSE(similarity_of_two({{1, 2, 0}, {4, 4, 0}}, {{2, 2, 0}, {4, 4, 9}}, up)) << "one place by GPS";
  const SpotPair first{{0, 0, 0}, {0, 0, 0}}, second{{1, 0, 0}, {2, 0, 0}}, third{{2, 0, 0}, {4, 0, 0}};
  EXPECT_FALSE(similarity_of_three(first, second, third)) << "one line";
  const SpotPair aside{{0, 1, 0}, {0, 2, 0}};
  const auto s = similarity_of_three(first, second, aside);
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->scale, 2, 1e-12);
}

}  // namespace
}  // namespace vitrine
