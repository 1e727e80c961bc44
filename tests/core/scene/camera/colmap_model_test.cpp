#include "core/scene/camera/colmap_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "tests/core/scene/camera/tiny_model.h"

namespace vitrine {
namespace {

using test::tiny_model;

const char* const kParts[] = {"cameras", "images", "points3D"};

std::string extension(ColmapFormat format) { return format == ColmapFormat::Binary ? ".bin" : ".txt"; }

TEST(ColmapModel, RoundTripsThroughBinaryAndText) {
  const ColmapModel model = tiny_model();
  TemporaryFolder folder;
  for (ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    write_colmap_model(folder.path(), model, format);
    EXPECT_EQ(read_colmap_model(folder.path(), format), model) << extension(format);
  }
}

TEST(ColmapModel, TextWrittenFromReadBinaryIsTheSameText) {
  const ColmapModel model = tiny_model(2);
  TemporaryFolder a, b;
  write_colmap_model(a.path(), model, ColmapFormat::Text);
  write_colmap_model(b.path(), model, ColmapFormat::Binary);
  write_colmap_model(b.path(), read_colmap_model(b.path(), ColmapFormat::Binary), ColmapFormat::Text);
  for (const char* part : kParts)
    EXPECT_EQ(read_file(a.path() / (std::string(part) + ".txt")), read_file(b.path() / (std::string(part) + ".txt")));
}

TEST(ColmapModel, IsFoundInTheFoldersOfTheField) {
  for (const char* sub : {"sparse/0", "sparse", "dense/sparse", "."}) {
    for (ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
      TemporaryFolder root(
          "vitrine gr\xc3\xb6\xc3\x9f"
          "e");
      write_colmap_model(root.path() / sub, tiny_model(), format);
      const auto found = find_colmap_model(root.path());
      ASSERT_TRUE(found) << sub;
      EXPECT_TRUE(fs::equivalent(*found, root.path() / sub));
      EXPECT_EQ(read_colmap_model(*found), tiny_model());
    }
  }
  TemporaryFolder empty;
  EXPECT_FALSE(find_colmap_model(empty.path()));
  EXPECT_THROW(read_colmap_model(empty.path()), Error);
}

TEST(ColmapModel, ReadsForeignTextWithCommentsBlankLinesAndWindowsEnds) {
  TemporaryFolder folder;
  write_file(folder.path() / "cameras.txt", "# cameras\r\n\r\n1 SIMPLE_PINHOLE 10 20 5 5 10\r\n");
  write_file(folder.path() / "images.txt",
             "# two lines each\n9 1 0 0 0 0 0 0 1 a b.jpg\n\n# between\n3 1 0 0 0 1 2 3 1 c.jpg\n1.5 2.5 -1  3 4 7\n");
  write_file(folder.path() / "points3D.txt", "7 0 0 5 255 0 9 0.25 3 1\n");
  const ColmapModel m = read_colmap_model(folder.path());
  ASSERT_EQ(m.images.size(), 2u);
  EXPECT_EQ(m.images[0].id, 3u);  // sorted by id
  EXPECT_EQ(m.images[0].points.size(), 2u);
  EXPECT_EQ(m.images[0].points[0].point3d_id, kNoPoint3D);
  EXPECT_EQ(m.images[1].name, "a b.jpg");
  EXPECT_EQ(m.points.at(0).srgb[2], 9);
}

TEST(ColmapModel, KnowsEveryCameraModelByNameAndCount) {
  for (int id = 0; id <= 17; ++id) {
    const ColmapCameraType* type = colmap_camera_type(id);
    ASSERT_TRUE(type) << id;
    EXPECT_EQ(colmap_camera_type(type->name), type);
    ColmapModel m;
    m.cameras = {{1, id, 64, 48, std::vector<double>(type->parameter_count, 0.5)}};
    for (ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
      TemporaryFolder folder;
      write_colmap_model(folder.path(), m, format);
      EXPECT_EQ(read_colmap_model(folder.path(), format), m);
    }
  }
}

TEST(ColmapModel, UnknownCameraModelNamesTheIdAndTheVersion) {
  TemporaryFolder folder;
  write_colmap_model(folder.path(), tiny_model(), ColmapFormat::Binary);
  std::string bytes = read_file(folder.path() / "cameras.bin");
  bytes[12] = 42;  // model id of the first camera
  write_file(folder.path() / "cameras.bin", bytes);
  try {
    read_colmap_model(folder.path());
    FAIL() << "an unknown camera model was accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(e.detail().where.find("cameras.bin"), std::string::npos);
    EXPECT_NE(e.detail().why.find("42"), std::string::npos);
    EXPECT_NE(e.detail().why.find("4.1"), std::string::npos);
  }
}

// Reading damaged bytes succeeds or gives Error{Input} with a place and a cause; anything else (a crash, another exception,
// a huge allocation) fails the test. Returns whether it was an Error.
bool damage_is_reported(const fs::path& folder, ColmapFormat format) {
  try {
    read_colmap_model(folder, format);
    return false;
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input) << e.what();
    EXPECT_FALSE(e.detail().where.empty());
    EXPECT_FALSE(e.detail().why.empty());
    return true;
  }
}

TEST(ColmapModel, TruncationAtAnyByteIsAnErrorAndNeverACrash) {
  for (ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    TemporaryFolder folder;
    write_colmap_model(folder.path(), tiny_model(), format);
    for (const char* part : kParts) {
      const fs::path path = folder.path() / (part + extension(format));
      const std::string whole = read_file(path);
      for (size_t length = 0; length < whole.size(); length += 7) {
        test::replace_file(path, whole.substr(0, length));
        const bool reported = damage_is_reported(folder.path(), format);
        if (format == ColmapFormat::Binary) {
          EXPECT_TRUE(reported) << path << " cut at " << length;
        }
      }
      write_file(path, whole);
    }
  }
}

TEST(ColmapModel, FlippedBytesNeverCrash) {
  for (ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    TemporaryFolder folder;
    write_colmap_model(folder.path(), tiny_model(), format);
    size_t reported = 0;
    for (const char* part : kParts) {
      const fs::path path = folder.path() / (part + extension(format));
      const std::string whole = read_file(path);
      for (size_t i = 0; i < whole.size(); i += 3) {
        std::string bytes = whole;
        bytes[i] = static_cast<char>(bytes[i] ^ (i % 2 ? 0xff : 1 << (i % 8)));
        test::replace_file(path, bytes);
        reported += damage_is_reported(folder.path(), format);
      }
      write_file(path, whole);
    }
    EXPECT_GT(reported, 100u);
    EXPECT_EQ(read_colmap_model(folder.path(), format), tiny_model());
  }
}

TEST(ColmapModel, IsReadByColmapAsWritten) {
  if (!find_program("colmap")) GTEST_SKIP() << "colmap is not installed";
  const ColmapModel model = tiny_model();
  TemporaryFolder ours, theirs;
  write_colmap_model(ours.path(), model, ColmapFormat::Binary);
  const ProcessResult result = run_process({.arguments = {"colmap", "model_converter", "--input_path", ours.path().string(),
                                                          "--output_path", theirs.path().string(), "--output_type", "TXT"},
                                            .environment = {{"QT_QPA_PLATFORM", "offscreen"}}});
  ASSERT_TRUE(result.ok()) << result.tail;
  const ColmapModel back = read_colmap_model(theirs.path(), ColmapFormat::Text);
  EXPECT_EQ(back.cameras, model.cameras);
  ASSERT_EQ(back.images.size(), model.images.size());
  for (size_t i = 0; i < back.images.size(); ++i) {
    EXPECT_EQ(back.images[i].name, model.images[i].name);
    EXPECT_EQ(back.images[i].points, model.images[i].points);
    EXPECT_NEAR(back.images[i].rotation.x, model.images[i].rotation.x, 1e-12);
    EXPECT_EQ(back.images[i].translation, model.images[i].translation);
  }
  ASSERT_EQ(back.points.size(), model.points.size());
  for (size_t k = 0; k < back.points.size(); ++k) {
    EXPECT_EQ(back.points[k].position, model.points[k].position);
    EXPECT_EQ(back.points[k].srgb, model.points[k].srgb);
    EXPECT_EQ(back.points[k].track, model.points[k].track);
  }
}

TEST(ColmapModel, RefusesContradictions) {
  const auto refused = [](auto&& spoil) {
    ColmapModel m = tiny_model();
    spoil(m);
    try {
      check_colmap_model(m, "model");
      return false;
    } catch (const Error& e) {
      return e.kind() == ErrorKind::Input && e.detail().where == "model";
    }
  };
  EXPECT_FALSE(refused([](ColmapModel&) {}));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].camera_id = 77; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].id = m.images[1].id; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].name = "../outside.jpg"; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].name = "/etc/passwd"; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].name = m.images[1].name; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].rotation = {0, 0, 0, 0}; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].translation.x = std::nan(""); }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.points[0].track.push_back({1, 1u << 30}); }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.points[0].track.push_back({999, 0}); }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.images[0].points[0].point3d_id = 999999; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.cameras[0].width = 0; }));
  EXPECT_TRUE(refused([](ColmapModel& m) { m.cameras[0].params[0] = -1; }));
}

TEST(ColmapModel, MovingTheWorldKeepsEveryPixel) {
  const ColmapModel before = tiny_model();
  ColmapModel after = before;
  const Similarity move{2.5, rotation_matrix(normalized(Quatd{1, 2, -3, 0.5})), {1, -2, 3}};
  transform_world(after, move);
  for (size_t i = 0; i < before.images.size(); ++i) {
    for (size_t k = 0; k < before.points.size(); ++k) {
      const Vec3d a = before.images[i].cam_from_world() * before.points[k].position;
      const Vec3d b = after.images[i].cam_from_world() * after.points[k].position;
      EXPECT_NEAR(a.x / a.z, b.x / b.z, 1e-9 * (1 + std::abs(a.x / a.z)));
      EXPECT_NEAR(2.5 * a.z, b.z, 1e-9);
    }
  }
}

TEST(ColmapCamera, UnprojectUndoesProjectForEverySupportedModel) {
  const std::vector<ColmapCamera> cameras = {{1, 0, 640, 480, {500, 320, 240}},
                                             {2, 1, 640, 480, {500, 510, 320, 240}},
                                             {3, 2, 640, 480, {500, 320, 240, -0.2}},
                                             {4, 3, 640, 480, {500, 320, 240, -0.25, 0.08}},
                                             {5, 4, 640, 480, {500, 510, 320, 240, -0.28, 0.09, 0.002, -0.001}}};
  for (const ColmapCamera& camera : cameras) {
    for (int y = 0; y <= 480; y += 40) {
      for (int x = 0; x <= 640; x += 40) {
        const auto direction = unproject(camera, {double(x), double(y)});
        ASSERT_TRUE(direction) << camera.id << " " << x << " " << y;
        const Vec2d pixel = project(camera, *direction);
        EXPECT_NEAR(pixel.x, x, 1e-8);
        EXPECT_NEAR(pixel.y, y, 1e-8);
      }
    }
  }
}

TEST(ColmapCamera, FollowsTheFormulasOfTheModels) {
  const double u = 0.3, v = -0.2, r2 = u * u + v * v;
  const Vec2d radial = project({1, 3, 640, 480, {500, 320, 240, -0.25, 0.08}}, {u, v});
  EXPECT_NEAR(radial.x, 320 + 500 * u * (1 - 0.25 * r2 + 0.08 * r2 * r2), 1e-12);
  const Vec2d opencv = project({1, 4, 640, 480, {500, 510, 320, 240, 0, 0, 0.01, 0.02}}, {u, v});
  EXPECT_NEAR(opencv.x, 320 + 500 * (u + 2 * 0.01 * u * v + 0.02 * (r2 + 2 * u * u)), 1e-12);
  EXPECT_NEAR(opencv.y, 240 + 510 * (v + 2 * 0.02 * u * v + 0.01 * (r2 + 2 * v * v)), 1e-12);
}

TEST(ColmapCamera, FisheyeModelsFollowTheAngleFromTheAxisAndAreInvertedUpTo85Degrees) {
  const double theta = 0.9, azimuth = 0.7, t2 = theta * theta;
  const Vec2d along{std::cos(azimuth), std::sin(azimuth)}, d = std::tan(theta) * along;
  const Vec2d opencv = project({1, 5, 640, 480, {300, 310, 320, 240, 0.1, -0.02, 0.003, -0.0004}}, d);
  const double scaled = theta * (1 + 0.1 * t2 - 0.02 * t2 * t2 + 0.003 * t2 * t2 * t2 - 0.0004 * t2 * t2 * t2 * t2);
  EXPECT_NEAR(opencv.x, 320 + 300 * scaled * along.x, 1e-9);
  EXPECT_NEAR(opencv.y, 240 + 310 * scaled * along.y, 1e-9);
  const Vec2d fov = project({1, 7, 640, 480, {300, 310, 320, 240, 0.9}}, d);
  EXPECT_NEAR(fov.x, 320 + 300 * std::atan(2 * std::tan(theta) * std::tan(0.45)) / 0.9 * along.x, 1e-9);
  const double u = theta * along.x, v = theta * along.y;
  const Vec2d prism = project({1, 10, 640, 480, {300, 310, 320, 240, 0, 0, 0.01, 0.02, 0, 0, 0.003, -0.004}}, d);
  EXPECT_NEAR(prism.x, 320 + 300 * (u + 2 * 0.01 * u * v + 0.02 * (t2 + 2 * u * u) + 0.003 * t2), 1e-9);
  EXPECT_NEAR(prism.y, 240 + 310 * (v + 2 * 0.02 * u * v + 0.01 * (t2 + 2 * v * v) - 0.004 * t2), 1e-9);

  for (const ColmapCamera& camera :
       {ColmapCamera{1, 5, 640, 480, {300, 310, 320, 240, 0.05, -0.01, 0.002, -0.0003}},
        ColmapCamera{2, 7, 640, 480, {300, 310, 320, 240, 0.9}}, ColmapCamera{3, 8, 640, 480, {300, 320, 240, 0.04}},
        ColmapCamera{4, 9, 640, 480, {300, 320, 240, 0.04, -0.01}},
        ColmapCamera{5, 10, 640, 480, {300, 310, 320, 240, 0.03, 0.01, 0.001, -0.002, 0, 0, 1e-3, 2e-3}}}) {
    EXPECT_TRUE(is_distorted(camera));
    EXPECT_EQ(pinhole_part(camera).cx, 320);
    for (double angle = 0; angle < 85; angle += 7)
      for (double turn = 0; turn < 6.2; turn += 0.9) {
        const Vec2d from = std::tan(angle / 57.29578) * Vec2d{std::cos(turn), std::sin(turn)};
        const std::optional<Vec2d> back = unproject(camera, project(camera, from));
        ASSERT_TRUE(back) << camera.id << " " << angle;
        EXPECT_LT(std::hypot(back->x - from.x, back->y - from.y), 1e-7 * (1 + from.x * from.x + from.y * from.y))
            << camera.id << " " << angle;
      }
  }
  EXPECT_FALSE(unproject({1, 8, 640, 480, {200, 320, 240, 0}}, {320 + 200 * 1.58, 240})) << "behind the camera";
}

TEST(ColmapCamera, RefusesUnknownLensesAtUseAndDirectionsBeyondTheFold) {
  const ColmapCamera unknown{1, 11, 640, 480, std::vector<double>(16, 0.5)};
  EXPECT_THROW(project(unknown, {0, 0}), Error);
  EXPECT_THROW(unproject(unknown, {0, 0}), Error);
  // r (1 - 0.5 r^2) never exceeds 0.544: pixels beyond f * 0.544 from the centre are images of nothing.
  const ColmapCamera barrel{1, 2, 640, 480, {500, 320, 240, -0.5}};
  EXPECT_TRUE(unproject(barrel, {320 + 500 * 0.54, 240}));
  EXPECT_FALSE(unproject(barrel, {320 + 500 * 0.56, 240}));
}

}  // namespace
}  // namespace vitrine
