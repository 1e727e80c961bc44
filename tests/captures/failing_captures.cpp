// Captures that go wrong in one way each, through inspect, ingest and sfm with the real COLMAP: the verdict must name the cause.
// The table in stages/sfm/README.md is printed by this test.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/scene/image/resample.h"
#include "stages/ingest/ingest.h"
#include "stages/inspect/inspect.h"
#include "stages/sfm/sfm.h"
#include "tests/captures/studio.h"
#include "tests/stages/inspect/drawn_photos.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using test::RecordingContext, test::Studio;

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 304;
constexpr size_t kPhotos = 8;

View view_from(const Vec3d& eye, const Vec3d& target) {
  return {.name = {},
          .intrinsics = {kWidth, kHeight, kFocal, kFocal, kWidth / 2.0, kHeight / 2.0},
          .cam_from_world = generate::looking_at(eye, target, {0, 0, 1})};
}

using Pictures = std::vector<ImageF>;  // linear

Pictures ring(const Studio& studio, size_t n, double arc = 0.7, double distance = 1.7) {
  Pictures out;
  for (size_t i = 0; i < n; ++i) {
    const double a = 0.3 + arc * double(i) / double(n - 1) * std::numbers::pi;
    out.push_back(studio.linear(view_from(Vec3d{distance * std::cos(a), distance * std::sin(a), 0.75 + 0.25 * double(i % 3)},
                                          {0.05 * double(i % 2), 0, 0.25})));
  }
  return out;
}

const Pictures& good() {
  static const Pictures pictures = ring(Studio({}), kPhotos);
  return pictures;
}

class Capture {
 public:
  void add(const ImageF& linear, const std::string& exif = {}) {
    const fs::path path = photos() / fmt::format("photo_{:02}.jpg", n_++);
    make_folders(photos());
    write_ldr(path, srgb8_from_linear(linear), 95);
    if (!exif.empty()) test::add_exif(path, exif);
  }
  void add(const Pictures& pictures, const std::string& exif = {}) {
    for (const ImageF& p : pictures) add(p, exif);
  }
  fs::path photos() const { return folder_.path() / "photos"; }
  fs::path photo(size_t i) const { return photos() / fmt::format("photo_{:02}.jpg", i); }

 private:
  TemporaryFolder folder_{"capture"};
  size_t n_ = 0;
};

std::string exif_of(unsigned mm, const std::string& model) {
  return test::exif_bytes({{0x110, 'a', 0, 1, model}}, {{0xa405, 's', mm}});
}
// What 304 pixels of 320 across are in 35 mm terms: 304 / 400 * 43.27.
constexpr unsigned kTrueMm = 33;

struct Verdict {
  std::string inspect, sfm;  // codes, separated by spaces; sfm: "ok 12/12" or the error's code
};

Verdict verdict_of(const Capture& capture) {
  Verdict v;
  {
    RecordingContext context({{"photos", capture.photos()}});
    inspect_stage().run(context);
    const auto report = nlohmann::json::parse(read_file(context.output() / "inspect" / "report.json"));
    for (const auto& f : report["findings"]) v.inspect += f["code"].get<std::string>() + " ";
  }
  RecordingContext ingest({{"photos", capture.photos()}});
  RecordingContext sfm({{"ingest", ingest.output()}});
  try {
    ingest_stage().run(ingest);
    Stage stage = sfm_stage();
    stage.options.find("retries")->assign("0", "test");  // one attempt is enough to name the cause, and takes a third of the time
    stage.run(sfm);
    v.sfm = fmt::format("ok {:.0f}/{:.0f}", sfm.metrics["registered"], sfm.metrics["photos"]);
    for (const auto& [code, text] : sfm.warnings) v.sfm += " " + code;
  } catch (const Error& e) {
    v.sfm = e.detail().code;
    if (std::getenv("VITRINE_SHOW_VERDICTS") != nullptr) fmt::print(stderr, "{}\n", e.what());
  }
  return v;
}

struct Row {
  std::string name, inspect, sfm;  // what must be among the codes; empty: nothing asked
  std::function<void(Capture&)> make;
};

std::vector<Row> rows() {
  std::vector<Row> all;
  all.push_back({"nothing wrong", "", "ok", [](Capture& c) { c.add(good(), exif_of(kTrueMm, "A")); }});
  all.push_back({"blur", "soft_set", "SFM_MOTION_BLUR", [](Capture& c) {
                   for (const ImageF& p : good())
                     c.add(linear_from_srgb_image([&] {
                       const Image8 s = test::smeared(srgb8_from_linear(p), 9, 1.5);
                       ImageF f(s.width(), s.height(), 3);
                       std::transform(s.data().begin(), s.data().end(), f.data().begin(),
                                      [](uint8_t b) { return float(b) / 255; });
                       return f;
                     }()));
                 }});
  all.push_back({"no overlap", "", "SFM_NO_OVERLAP", [](Capture& c) {
                   for (uint32_t i = 0; i < kPhotos; ++i) c.add(ring(Studio({.seed = 20 + i}), 2, 0, 1.7)[0]);
                 }});
  all.push_back({"two rooms", "", "SFM_SPLIT_MODELS", [](Capture& c) {
                   c.add(ring(Studio({}), 6, 0.5));
                   c.add(ring(Studio({.seed = 9}), 6, 0.5));
                 }});
  all.push_back({"all mirror", "", "SFM_REFLECTIONS_DOMINATE",
                 [](Capture& c) { c.add(ring(Studio({.mirrors = true}), kPhotos, 0.7, 1.25)); }});
  all.push_back(
      {"no texture", "low_texture", "SFM_TOO_FEW_FEATURES", [](Capture& c) { c.add(ring(Studio({.plain = true}), kPhotos)); }});
  all.push_back(
      {"rotation only", "", "SFM_PURE_ROTATION", [](Capture& c) {
         const Studio studio({});
         for (size_t i = 0; i < kPhotos; ++i) {
           const double a = 0.12 * double(i);
           c.add(studio.linear(view_from({0.9, -1.4, 1.2}, {0.9 - std::sin(a), -1.4 + std::cos(a), 0.9 + 0.1 * double(i % 2)})));
         }
       }});
  all.push_back({"mixed cameras", "mixed_cameras", "ok", [](Capture& c) {
                   for (size_t i = 0; i < kPhotos; ++i) c.add(good()[i], exif_of(kTrueMm, i % 2 ? "A" : "B"));
                 }});
  all.push_back({"wrong focal length", "", "ok SFM_BAD_FOCAL", [](Capture& c) { c.add(good(), exif_of(6 * kTrueMm, "A")); }});
  all.push_back({"one photo", "few_photos", "TOO_FEW_PHOTOS", [](Capture& c) { c.add(good()[0]); }});
  all.push_back({"duplicates", "near_duplicates", "", [](Capture& c) {
                   for (size_t i = 0; i < kPhotos; ++i) c.add(good()[i * 2 / kPhotos]);
                 }});
  all.push_back({"corrupt", "unreadable_photos", "TOO_FEW_PHOTOS", [](Capture& c) {
                   c.add(good());
                   for (size_t i = 1; i < kPhotos; ++i) {
                     const std::string bytes = read_file(c.photo(i));
                     write_file(c.photo(i), i % 2 ? bytes.substr(0, bytes.size() / 3) : std::string());
                   }
                 }});
  all.push_back({"tiny", "small_photos", "SFM_TOO_FEW_FEATURES", [](Capture& c) {
                   for (const ImageF& p : good()) c.add(resized(p, 40, 30));
                 }});
  all.push_back({"mixed exposure", "mixed_exposure", "SFM_MIXED_EXPOSURE", [](Capture& c) {
                   for (size_t i = 0; i < kPhotos; ++i) {
                     ImageF p = good()[i];
                     const float gain = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 0.004f : 40.0f;
                     for (float& v : p.data()) v *= gain;
                     c.add(p);
                   }
                 }});
  return all;
}

// All of the words.
bool contains(const std::string& codes, const std::string& wanted) {
  std::istringstream words(wanted);
  for (std::string word; words >> word;)
    if ((" " + codes + " ").find(" " + word + " ") == std::string::npos) return false;
  return true;
}

TEST(FailingCaptures, AreNamed) {
  if (!find_program("colmap") && std::getenv("VITRINE_COLMAP") == nullptr) GTEST_SKIP() << "COLMAP is not on this machine";
  const char* only = std::getenv("VITRINE_ONLY_CAPTURE");
  size_t wrong = 0;
  for (const Row& row : rows()) {
    if (only != nullptr && row.name != only) continue;
    Capture capture;
    row.make(capture);
    if (const char* keep = std::getenv("VITRINE_KEEP_CAPTURES"))
      fs::copy(capture.photos(), fs::path(keep) / row.name, fs::copy_options::recursive);
    const Verdict given = verdict_of(capture);
    const bool right = contains(given.inspect, row.inspect) && contains(given.sfm, row.sfm);
    wrong += !right;
    fmt::print("| {} | {} | {} | {} | {} | {} |\n", row.name, row.inspect, row.sfm, given.inspect, given.sfm,
               right ? "yes" : "NO");
    EXPECT_TRUE(right) << row.name << ": inspect says " << given.inspect << ", sfm says " << given.sfm;
  }
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace vitrine
