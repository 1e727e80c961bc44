#include "stages/normals/normals.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "tests/stages/normals/still_life.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using test::degrees;
using test::RecordingContext;
using test::StillLife;

const StillLife& scene() {
  static const StillLife life;
  return life;
}

struct Result {
  explicit Result(const std::map<std::string, fs::path>& inputs) : context(inputs) {}
  RecordingContext context;
  nlohmann::json report;
  fs::path normals() const { return context.output() / "normals"; }
};

std::unique_ptr<Result> run(const StillLife& life, const std::vector<std::pair<std::string, std::string>>& options,
                            const std::map<std::string, fs::path>& more = {}) {
  std::map<std::string, fs::path> inputs = more;
  inputs["sfm"] = life.sfm();
  auto result = std::make_unique<Result>(inputs);
  Stage stage = normals_stage();
  for (const auto& [path, text] : options) stage.options.find(path)->assign(text, "test");
  stage.run(result->context);
  result->report = nlohmann::json::parse(read_file(result->normals() / "report.json"));
  return result;
}

struct Errors {
  std::vector<double> degrees;  // of known pixels
  size_t pixels = 0;
  double confidence = 0;
  double known() const { return double(degrees.size()) / double(std::max<size_t>(pixels, 1)); }
  double percentile(double p) {
    if (degrees.empty()) return 180;
    const auto at = degrees.begin() + std::ptrdiff_t(p * double(degrees.size() - 1));
    std::nth_element(degrees.begin(), at, degrees.end());
    return *at;
  }
};

Errors errors_on(const StillLife& life, const fs::path& normals, StillLife::Surface surface) {
  Errors errors;
  for (size_t v = 0; v < life.views.size(); ++v) {
    const ExrImage map = read_exr(normals / (life.views[v].stem() + ".exr"));
    EXPECT_EQ(map.channels, (std::vector<std::string>{"X", "Y", "Z"}));
    const Image8 confidence = read_grey8(normals / (life.views[v].stem() + "_confidence.png"));
    const double sx = double(StillLife::kWidth) / map.pixels.width(), sy = double(StillLife::kHeight) / map.pixels.height();
    for (int y = 0; y < map.pixels.height(); ++y)
      for (int x = 0; x < map.pixels.width(); ++x) {
        if (life.at(v, sx * (x + 0.5), sy * (y + 0.5)).surface != surface) continue;
        ++errors.pixels;
        const float* p = map.pixels.pixel(x, y);
        const Vec3f n{p[0], p[1], p[2]};
        if (length(n) < 0.5f) {
          EXPECT_EQ(confidence.at(x, y), 0);
          continue;
        }
        EXPECT_NEAR(length(n), 1, 2e-3);
        errors.degrees.push_back(degrees(n, life.normal(v, sx * (x + 0.5), sy * (y + 0.5))));
        errors.confidence += confidence.at(x, y) / 255.0;
      }
  }
  errors.confidence /= double(std::max<size_t>(errors.degrees.size(), 1));
  return errors;
}

// --- geometric ------------------------------------------------------------------------------------------------------------
TEST(NormalsFromPhotos, AreRightOnPaintAndFromTheShapeOnAMirror) {
  const auto r = run(scene(), {}, {{"objects", scene().objects()}});
  EXPECT_EQ(r->report["source"], "geometric");
  EXPECT_TRUE(r->context.warnings.empty());
  Errors table = errors_on(scene(), r->normals(), StillLife::Table), ball = errors_on(scene(), r->normals(), StillLife::Ball),
         mirror = errors_on(scene(), r->normals(), StillLife::Mirror);
  EXPECT_GT(table.known(), 0.7);
  EXPECT_LT(table.percentile(0.5), 3);
  EXPECT_LT(table.percentile(0.9), 15);
  EXPECT_GT(ball.known(), 0.7);
  EXPECT_LT(ball.percentile(0.5), 20);
  EXPECT_GT(table.confidence, ball.confidence);
  EXPECT_GT(mirror.known(), 0.85);
  EXPECT_LT(mirror.percentile(0.5), 12);
  RecordProperty("table_median_deg", std::to_string(table.percentile(0.5)));
  RecordProperty("ball_median_deg", std::to_string(ball.percentile(0.5)));
  RecordProperty("mirror_median_deg", std::to_string(mirror.percentile(0.5)));
}

TEST(NormalsFromPhotos, AMirrorThatNobodyKnowsIsWorseThanItsShape) {
  const auto r = run(scene(), {{"source", "geometric"}, {"geometric.max_side", "60"}});
  Errors mirror = errors_on(scene(), r->normals(), StillLife::Mirror);
  EXPECT_TRUE(mirror.known() < 0.5 || mirror.percentile(0.5) > 20) << mirror.known() << " " << mirror.percentile(0.5);
}

// What is guessed gives no normal, and takes none.
TEST(NormalsFromPhotos, AGuessedObjectChangesNothing) {
  const TemporaryFolder folder;
  ObjectSet set = read_objects(scene().objects());
  for (Object& o : set.objects) o.trust = ObjectTrust::Guessed;
  test::write_objects_artifact(folder.path(), scene().masks(), scene().views, set);
  const std::vector<std::pair<std::string, std::string>> small{{"geometric.max_side", "60"}};
  const auto guessed = run(scene(), small, {{"objects", folder.path()}}), none = run(scene(), small);
  EXPECT_EQ(digest_folder(guessed->normals()), digest_folder(none->normals()));
  const auto given = run(scene(), small, {{"objects", scene().objects()}});
  EXPECT_NE(digest_folder(given->normals()), digest_folder(none->normals()));
}

// Glass that nothing fixes in space: stereo sees something else there.
TEST(NormalsFromPhotos, AreUnknownOnGlassWithoutAShape) {
  const TemporaryFolder folder;
  const ObjectSet set{.objects = {{.id = 1, .name = "glass", .role = ObjectRole::ThinGlass}}, .shapes = {}};
  make_folders(folder.path() / "masks");
  fs::copy(scene().masks() / "masks/specular", folder.path() / "masks/transparent", fs::copy_options::recursive);
  test::write_objects_artifact(folder.path(), folder.path(), scene().views, set);
  const auto r = run(scene(), {{"geometric.max_side", "60"}}, {{"objects", folder.path()}});
  EXPECT_LT(errors_on(scene(), r->normals(), StillLife::Mirror).known(), 0.1);
}

TEST(NormalsFromPhotos, AreTheSameBytesForAnyNumberOfThreads) {
  set_thread_limit(1);
  const auto one = run(scene(), {{"geometric.max_side", "60"}}, {{"objects", scene().objects()}});
  set_thread_limit(3);
  const auto three = run(scene(), {{"geometric.max_side", "60"}}, {{"objects", scene().objects()}});
  set_thread_limit(0);
  EXPECT_EQ(digest_folder(one->normals()), digest_folder(three->normals()));
}

TEST(NormalsFromPhotos, OwePhotosKeptForTheEvaluationNothing) {
  StillLife life;
  const std::vector<std::pair<std::string, std::string>> options{{"holdout_every", "6"}, {"geometric.max_side", "60"}};
  const auto before = run(life, options);
  ImageF black(StillLife::kWidth, StillLife::kHeight, 3);
  for (size_t v : {0, 6}) write_exr_rgb(linear_image_path(life.sfm(), life.views[v]), black);
  const auto after = run(life, options);
  EXPECT_NE(read_file(before->normals() / "view_00.exr"), read_file(after->normals() / "view_00.exr"));
  for (size_t v = 0; v < life.views.size(); ++v) {
    if (is_heldout(v, 6)) continue;
    const std::string file = life.views[v].stem() + ".exr";
    EXPECT_EQ(read_file(before->normals() / file), read_file(after->normals() / file)) << file;
  }
}

TEST(Normals, NoneWritesNoMap) {
  const auto r = run(scene(), {{"source", "none"}});
  EXPECT_EQ(r->report["photos"].size(), 0u);
  EXPECT_FALSE(fs::exists(r->normals() / "view_00.exr"));
}

// --- files ----------------------------------------------------------------------------------------------------------------
using Axes = std::function<Vec3f(const StillLife&, size_t view, const Vec3f& in_camera)>;
Vec3f opencv(const StillLife&, size_t, const Vec3f& n) { return n; }
Vec3f opengl(const StillLife&, size_t, const Vec3f& n) { return {n.x, -n.y, -n.z}; }
Vec3f left_up_back(const StillLife&, size_t, const Vec3f& n) { return -n; }
Vec3f mirrored(const StillLife&, size_t, const Vec3f& n) { return {-n.x, n.y, n.z}; }
Vec3f world(const StillLife& life, size_t view, const Vec3f& n) {
  return cast<float>(transposed_times(life.views[view].cam_from_world.rotation, cast<double>(n)));
}

enum class Kind { Png8, Png16, Exr };
// One map per photo, as a predictor would have left it.
fs::path write_maps(const StillLife& life, const fs::path& folder, Kind kind, const Axes& axes) {
  make_folders(folder);
  for (size_t v = 0; v < life.views.size(); ++v) {
    ImageF normal(StillLife::kWidth, StillLife::kHeight, 3);
    for (int y = 0; y < normal.height(); ++y)
      for (int x = 0; x < normal.width(); ++x) {
        const Vec3f own = life.normal(v, x + 0.5, y + 0.5);
        const Vec3f n = axes(life, v, own);
        for (size_t c = 0; c < 3; ++c)
          normal.at(x, y, int(c)) = kind == Kind::Exr ? n[c] : squared_length(own) == 0 ? 0 : (n[c] + 1) / 2;
      }
    const fs::path path = folder / life.views[v].stem();
    if (kind == Kind::Exr) {
      write_exr(path.string() + ".exr", {.pixels = normal, .channels = {"X", "Y", "Z"}, .attributes = {}});
    } else if (kind == Kind::Png16) {
      Image16 image(normal.width(), normal.height(), 3);
      for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = uint16_t(std::lround(65535 * normal.data()[i]));
      write_png16(path.string() + ".png", image);
    } else {
      Image8 image(normal.width(), normal.height(), 3);
      for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = uint8_t(std::lround(255 * normal.data()[i]));
      write_ldr(path.string() + ".png", image);
    }
  }
  return folder;
}

struct FileCase {
  std::string name;
  Kind kind;
  Axes axes;
  double worst_deg;
};

TEST(NormalFiles, TheFrameIsFoundWhateverTheSigns) {
  const std::vector<FileCase> cases{{"camera-opencv", Kind::Png16, opencv, 0.1},
                                    {"camera-opengl", Kind::Png8, opengl, 0.6},
                                    {"camera-left-up-back", Kind::Exr, left_up_back, 0.1},
                                    {"camera, axes x- y+ z+", Kind::Png16, mirrored, 0.1},
                                    {"world", Kind::Exr, world, 0.1}};
  for (const FileCase& c : cases) {
    TemporaryFolder folder;
    const auto r = run(scene(), {}, {{"normals", write_maps(scene(), folder.path() / "maps", c.kind, c.axes)}});
    EXPECT_EQ(r->report["source"], "files");
    EXPECT_EQ(r->report["space"]["name"], c.name);
    EXPECT_FALSE(r->report["space"]["declared"].get<bool>());
    for (StillLife::Surface s : {StillLife::Table, StillLife::Ball, StillLife::Mirror}) {
      Errors errors = errors_on(scene(), r->normals(), s);
      EXPECT_GT(errors.known(), 0.97) << c.name;
      EXPECT_LT(errors.percentile(1), c.worst_deg) << c.name;
    }
  }
}

TEST(NormalFiles, ADeclaredFrameIsTakenAndMapsAreReduced) {
  TemporaryFolder folder;
  const auto r = run(scene(), {{"files.space", "camera-opengl"}, {"max_side", "48"}},
                     {{"normals", write_maps(scene(), folder.path() / "maps", Kind::Png16, opengl)}});
  EXPECT_TRUE(r->report["space"]["declared"].get<bool>());
  EXPECT_EQ(r->report["photos"][0]["width"], 48);
  EXPECT_EQ(r->report["photos"][0]["height"], 36);
  Errors errors = errors_on(scene(), r->normals(), StillLife::Table);
  EXPECT_LT(errors.percentile(0.9), 1);
  EXPECT_NEAR(errors.confidence, 1, 0.04);
}

TEST(NormalFiles, AWronglyDeclaredFrameLooksAwayAndIsRefused) {
  TemporaryFolder folder;
  const fs::path maps = write_maps(scene(), folder.path() / "maps", Kind::Exr, left_up_back);
  const Error e = error_of([&] { run(scene(), {{"files.space", "camera-opencv"}}, {{"normals", maps}}); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.detail().code, "NORMALS_FACE_AWAY");
}

TEST(NormalFiles, NoiseIsInNoFrame) {
  TemporaryFolder folder;
  Rng rng(1);
  const fs::path maps = write_maps(scene(), folder.path() / "maps", Kind::Exr, [&](const StillLife&, size_t, const Vec3f&) {
    return normalized(Vec3f{rng.normal(), rng.normal(), rng.normal()});
  });
  const Error e = error_of([&] { run(scene(), {}, {{"normals", maps}}); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.detail().code, "AMBIGUOUS_NORMAL_SPACE");
}

TEST(NormalFiles, MissingMapsAreNamedAndAnEmptyFolderIsRefused) {
  TemporaryFolder folder;
  const fs::path maps = write_maps(scene(), folder.path() / "maps", Kind::Png16, opencv);
  fs::remove(maps / "view_03.png");
  const auto r = run(scene(), {{"files.space", "camera-opencv"}}, {{"normals", maps}});
  EXPECT_EQ(r->report["photos"].size(), scene().views.size() - 1);
  EXPECT_TRUE(r->context.warnings.contains("NORMALS_MISSING"));
  make_folders(folder.path() / "empty");
  EXPECT_EQ(error_of([&] { run(scene(), {}, {{"normals", folder.path() / "empty"}}); }).detail().code, "NO_NORMAL_FILES");
  EXPECT_EQ(error_of([&] { run(scene(), {{"source", "files"}}); }).kind(), ErrorKind::Usage);
}

TEST(NormalFiles, WhatIsNoNormalMapIsRefusedWithTheReason) {
  const auto refused = [](const std::function<void(const fs::path&)>& spoil) {
    TemporaryFolder folder;
    const fs::path maps = write_maps(scene(), folder.path() / "maps", Kind::Png16, opencv);
    spoil(maps / "view_05.png");
    const Error e = error_of([&] { run(scene(), {{"files.space", "camera-opencv"}}, {{"normals", maps}}); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(e.detail().where.find("view_05"), std::string::npos);
    return e.detail().code;
  };
  EXPECT_EQ(refused([](const fs::path& p) {  // a photo
              Image8 photo(StillLife::kWidth, StillLife::kHeight, 3, uint8_t(128));
              write_ldr(p, photo);
            }),
            "NOT_A_NORMAL_MAP");
  EXPECT_EQ(refused([](const fs::path& p) { write_ldr(p, Image8(StillLife::kWidth, StillLife::kHeight, 1, uint8_t(200))); }),
            "NOT_A_NORMAL_MAP");
  EXPECT_EQ(refused([](const fs::path& p) { write_ldr(p, Image8(80, 80, 3, uint8_t(200))); }), "SIZE_MISMATCH");
  EXPECT_NE(refused([](const fs::path& p) { write_file(p, read_file(p).substr(0, 200)); }), "");
  EXPECT_NE(refused([](const fs::path& p) { write_file(p, "no picture"); }), "");
}

}  // namespace
}  // namespace vitrine
