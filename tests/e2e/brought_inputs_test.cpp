// What people bring: folders and files as neighbouring programs, phones and file systems leave them. Each has one right answer of
// `vitrine run`, and `vitrine inspect` gives the same answer before anything is computed.
#include <set>

#include "core/image/resample.h"
#include "tests/support/vitrine_process.h"

#include "core/camera/colmap_model.h"
#include "core/camera/view_set.h"
#include "core/image/ldr.h"

namespace vitrine {
namespace {

constexpr int kWidth = 320, kHeight = 240;

// Twelve photos of the cabinet, a quarter of their pixels, with their true poses.
class BroughtInputs : public VitrineProcess {
 protected:
  BroughtInputs() {
    unsetenv("VITRINE_STAGE_DIR");
    unsetenv("VITRINE_CONFIG_DIR");
    unsetenv("VITRINE_COLMAP");
    make_folders(photos());
    const fs::path sample = fs::path(VITRINE_SOURCE_DIR) / "sample_data/cabinet";
    for (View view : read_transforms_json(sample / "truth/transforms.json")) {
      if (n_++ % 3 != 0) continue;
      const ImageF photo = read_srgb(sample / "photos" / view.name);
      const ImageF small = resized(photo, kWidth, kHeight);
      Image8 bytes(kWidth, kHeight, 3);
      for (size_t i = 0; i < bytes.data().size(); ++i) bytes.data()[i] = uint8_t(std::lround(255 * small.data()[i]));
      write_ldr(photos() / view.name, bytes, 95);
      view.intrinsics = view.intrinsics.scaled_to(kWidth, kHeight);
      views.push_back(view);
    }
  }
  fs::path photos() const final { return folder.path() / "photos"; }
  fs::path here(const std::string& name) const { return folder.path() / name; }

  // The codes of all that a run up to `to` says, and its exit code.
  struct Answer {
    int exit = -1;
    std::set<std::string> codes;
    std::string text;
  };
  Answer ran(std::vector<std::string> words, const std::string& to) const {
    words.insert(words.begin(), "run");
    for (const char* word : {"-o", "out", "--preset", "preview", "--log-format", "json", "--to"}) words.push_back(word);
    words.push_back(to);
    const Outcome o = call(words);
    Answer a{.exit = o.exit, .codes = {}, .text = o.text};
    std::istringstream lines(o.text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("{\"v\"")) continue;
      const auto record = nlohmann::json::parse(line);
      if (record["type"] == "warning" || record["type"] == "error") a.codes.insert(record["code"]);
    }
    return a;
  }
  Answer inspected(std::vector<std::string> words) const {
    words.insert(words.begin(), "inspect");
    words.push_back("--json");
    const Outcome o = call(words);
    Answer a{.exit = o.exit, .codes = {}, .text = o.text};
    const size_t at = o.text.find('{');
    if (at == std::string::npos) return a;
    const auto report = nlohmann::json::parse(o.text.substr(at), nullptr, false);
    if (!report.is_object()) return a;
    for (const auto& f : report["findings"]) a.codes.insert(f["code"]);
    return a;
  }
  // A run answers `in_run` with this exit code; inspect says `in_inspect` of the same words.
  void expect(const std::vector<std::string>& words, const std::string& to, int exit, const std::string& in_run,
              const std::string& in_inspect) const {
    const Answer run = ran(words, to);
    EXPECT_EQ(run.exit, exit) << run.text;
    EXPECT_TRUE(run.codes.contains(in_run)) << in_run << " is not in\n" << run.text;
    const Answer look = inspected(words);
    EXPECT_TRUE(look.codes.contains(in_inspect)) << in_inspect << " is not in\n" << look.text;
  }

  std::vector<View> views;

 private:
  size_t n_ = 0;
};

TEST_F(BroughtInputs, PosesInAxesOfOpenCVAreRefusedByName) {
  // The columns of y and z as OpenCV has them, in a file that means OpenGL's.
  for (View& v : views) {
    Rigid world_from_cam = inverse(v.cam_from_world);
    world_from_cam.rotation.c1 = -world_from_cam.rotation.c1;
    world_from_cam.rotation.c2 = -world_from_cam.rotation.c2;
    v.cam_from_world = inverse(world_from_cam);
  }
  write_transforms_json(here("transforms.json"), views, "photos");
  expect({photos().string(), "--poses", here("transforms.json").string()}, "sfm", 3, "POSES_DISAGREE", "POSES_DISAGREE");
}

}  // namespace
}  // namespace vitrine
