// An object on a plate, photographed all around in passes between which it is turned: points projected, no pictures.
#include "stages/sfm/passes.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/scene_info.h"

namespace vitrine {
namespace {

constexpr size_t kPoints = 60;  // of the object and of the plate
constexpr double kFocalPx = 800;

Rigid looking_at_origin(double azimuth, double elevation) {
  const Vec3d eye{3 * std::cos(azimuth) * std::cos(elevation), 3 * std::sin(azimuth) * std::cos(elevation),
                  3 * std::sin(elevation)};
  const Vec3d z = normalized(-eye), x = normalized(cross(z, Vec3d{0, 0, 1})), y = cross(z, x);
  const Mat3d cam_from_world = transposed(Mat3d{x, y, z});
  return {cam_from_world, -(cam_from_world * eye)};
}

struct TurnedCapture {
  // Of each pass: how the object stands on the plate, and how many photos go around it.
  explicit TurnedCapture(const std::vector<std::pair<Rigid, size_t>>& passes, bool object_decides = false) {
    Rng rng(7);
    const auto uniform = [&](double low, double high) { return low + (high - low) * rng.uniform(); };
    std::vector<Vec3d> object, plate;
    for (size_t i = 0; i < kPoints; ++i) {
      object.push_back({uniform(-0.4, 0.4), uniform(-0.2, 0.2), uniform(-0.2, 0.2)});
      plate.push_back({uniform(-1, 1), uniform(-1, 1), -0.3});
    }
    poses.cameras.push_back(colmap_pinhole(1, {1000, 800, kFocalPx, kFocalPx, 500, 400}));
    on_plate = poses, on_object = poses;
    for (size_t p = 0; p < passes.size(); ++p) {
      std::vector<std::string>& names = truth.emplace_back();
      for (size_t k = 0; k < passes[p].second; ++k) {
        const Rigid cam_from_plate =
            looking_at_origin(2 * std::numbers::pi * double(k) / double(passes[p].second), 0.5 + 0.1 * double(k % 2));
        const Rigid cam_from_object = cam_from_plate * passes[p].first;
        names.push_back(fmt::format("{}_{:02}.jpg", p, k));
        add_image(on_plate, names.back(), cam_from_plate);
        add_image(on_object, names.back(), cam_from_object);
        std::vector<float>& xy = matches.xy.emplace_back();
        for (const auto& [points, cam] : {std::pair(&object, cam_from_object), std::pair(&plate, cam_from_plate)})
          for (const Vec3d& point : *points) {
            const Vec3d q = cam * point;
            xy.push_back(float(kFocalPx * q.x / q.z + 500));
            xy.push_back(float(kFocalPx * q.y / q.z + 400));
          }
        std::vector<uint8_t>& flags = side.emplace_back(2 * kPoints, uint8_t{0});
        std::fill_n(flags.begin(), kPoints, uint8_t{1});
      }
    }
    poses = object_decides ? on_object : on_plate;
    for (size_t a = 0; a < matches.xy.size(); ++a)
      for (size_t b = a + 1; b < matches.xy.size(); ++b) {
        PhotoMatches& m = matches.pairs.emplace_back();
        m.a = poses.images[a].name, m.b = poses.images[b].name;
        matches.photos.push_back({a, b});
        auto& features = matches.features.emplace_back();
        for (uint32_t f = 0; f < 2 * kPoints; ++f) {
          m.in_a.push_back({matches.xy[a][2 * f], matches.xy[a][2 * f + 1]});
          m.in_b.push_back({matches.xy[b][2 * f], matches.xy[b][2 * f + 1]});
          features.push_back({f, f});
        }
      }
  }

  static void add_image(ColmapModel& model, const std::string& name, const Rigid& cam_from_world) {
    ColmapImage& image = model.images.emplace_back();
    image.id = uint32_t(model.images.size()), image.camera_id = 1, image.name = name;
    image.rotation = quaternion(cam_from_world.rotation), image.translation = cam_from_world.translation;
  }
  // Between passes nothing of the object matches any more.
  void forget_matches_of_object(const std::string& pass_a, const std::string& pass_b) {
    for (size_t p = 0; p < matches.pairs.size(); ++p) {
      PhotoMatches& m = matches.pairs[p];
      if (!m.a.starts_with(pass_a) || !m.b.starts_with(pass_b)) continue;
      m.in_a.erase(m.in_a.begin(), m.in_a.begin() + kPoints);
      m.in_b.erase(m.in_b.begin(), m.in_b.begin() + kPoints);
      matches.features[p].erase(matches.features[p].begin(), matches.features[p].begin() + kPoints);
    }
  }
  MotionEvidence evidence() const { return motion_evidence(poses, matches, side); }

  ColmapModel poses, on_plate, on_object;
  FoundMatches matches;
  std::vector<std::vector<uint8_t>> side;
  Passes truth;
};

Rigid turned(double degrees, const Vec3d& axis, const Vec3d& shift = {}) {
  const double half = degrees * std::numbers::pi / 360;
  return {rotation_matrix(Quatd{std::cos(half), std::sin(half) * axis.x, std::sin(half) * axis.y, std::sin(half) * axis.z}),
          shift};
}

TEST(Passes, AreFoundWhereTheObjectWasTurned) {
  const TurnedCapture two({{{}, 14}, {turned(170, {1, 0, 0}), 10}});
  EXPECT_EQ(two.evidence().passes, two.truth);
  EXPECT_EQ(passes_by_motion(two.on_object, std::vector{two.on_plate}), two.truth);
  const TurnedCapture three({{{}, 14}, {turned(170, {1, 0, 0}), 12}, {turned(90, {0, 1, 0}), 10}});
  EXPECT_EQ(three.evidence().passes, three.truth);
}

TEST(Passes, AreFoundWhereThePosesFollowTheObject) {
  const TurnedCapture two({{{}, 14}, {turned(170, {1, 0, 0}), 10}}, true);
  EXPECT_EQ(two.evidence().passes, two.truth);
}

TEST(Passes, AreFoundWhereTheySharePhotosOfThePlateAlone) {
  TurnedCapture two({{{}, 14}, {turned(170, {1, 0, 0}), 10}});
  two.forget_matches_of_object("0_", "1_");
  EXPECT_EQ(two.evidence().passes, two.truth);
}

TEST(Passes, AreNoneWhereNothingWasTurned) {
  const TurnedCapture still({{{}, 24}});
  EXPECT_LT(still.evidence().passes.size(), 2u);
  EXPECT_TRUE(passes_by_motion(still.on_object, std::vector{still.on_plate}).empty());
  // Photos from opposite sides share nothing of the object: no proof of anything.
  TurnedCapture halves({{{}, 12}});
  for (size_t p = 0; p < halves.matches.pairs.size(); ++p) {
    const auto [a, b] = halves.matches.photos[p];
    if (b - a > 3) halves.matches.pairs[p].in_a.clear(), halves.matches.pairs[p].in_b.clear(), halves.matches.features[p].clear();
  }
  EXPECT_LT(halves.evidence().passes.size(), 2u);
}

TEST(Passes, AreNotToldFromModelsOfSurroundingsThatShareNoPhoto) {
  const TurnedCapture two({{{}, 14}, {turned(170, {1, 0, 0}), 10}});
  const std::vector apart{restricted(two.on_plate, two.truth[0]), restricted(two.on_plate, two.truth[1])};
  EXPECT_TRUE(passes_by_motion(two.on_object, apart).empty());
  // COLMAP's models may share photos.
  const std::vector overlapping{two.on_plate, apart[1]};
  EXPECT_EQ(passes_by_motion(two.on_object, overlapping), two.truth);
}

TEST(Passes, AreNotTheTurnsOfATurntable) {
  std::vector<std::pair<Rigid, size_t>> turns;
  for (int i = 0; i < 12; ++i) turns.push_back({turned(30 * i, {0, 0, 1}), 1});
  const TurnedCapture turntable(turns, true);
  EXPECT_TRUE(turns_in_most_photos(turntable.on_object, std::vector{turntable.on_plate}));
  EXPECT_TRUE(passes_by_motion(turntable.on_object, std::vector{turntable.on_plate}).empty());
  const TurnedCapture two({{{}, 14}, {turned(170, {1, 0, 0}), 10}});
  EXPECT_FALSE(turns_in_most_photos(two.on_object, std::vector{two.on_plate}));
}

TEST(Passes, SurviveTheirFile) {
  const TemporaryFolder folder;
  EXPECT_TRUE(read_passes(folder.path()).empty());
  const Passes passes{{"a.jpg", "b.jpg"}, {"c.jpg"}, {"d.jpg"}};
  make_folders(folder.path() / "sfm");
  write_passes(folder.path(), passes, PosesOf::Object);
  EXPECT_EQ(read_passes(folder.path()), passes);
  EXPECT_EQ(passes_text(passes), "3 passes: 2, 1 and 1 photos");
  // Poses that do not follow the object say nothing of its surroundings.
  write_passes(folder.path(), passes, PosesOf::Surroundings);
  EXPECT_TRUE(read_passes(folder.path()).empty());
  EXPECT_NE(passes_summary(folder.path()).find("3 passes: 2, 1 and 1 photos"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
