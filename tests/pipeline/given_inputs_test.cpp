// What is handed in beside the photos is looked at before anything is computed.
#include "pipeline/given_inputs.h"

#include <cstdlib>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/scene/image/ldr.h"
#include "pipeline/measures_in_photos.h"

namespace vitrine {
namespace {

// Marks of a mirror in two photos.
const std::string kRightMarks =
    "size: [60, 40]\nmarks:\n  - {photo: img_0002.jpg, class: specular, box: [1, 1, 20, 30]}\n"
    "  - {photo: img_0001, class: specular, box: [1, 1, 20, 30]}\n";

struct Answer {
  int code;
  std::string text;
};
Answer answer_of(std::vector<std::string> words) {
  words.insert(words.begin(), (fs::path(VITRINE_BIN_DIR) / "vitrine").string());
  Answer a;
  const ProcessResult r =
      run_process({.arguments = words, .on_line = [&](std::string_view line) { a.text += std::string(line) + "\n"; }});
  a.code = r.exit_code;
  return a;
}

class GivenInputs : public testing::Test {
 protected:
  GivenInputs() {
    unsetenv("VITRINE_STAGE_DIR");
    make_folders(photos);
    for (const char* name : {"img_0001.jpg", "img_0002.jpg", "upper.JPG", "upper.png", "linear.exr"})
      write_file(photos / name, "x");
  }
  Answer dry_run(const std::vector<std::string>& options) const {
    std::vector<std::string> words{"run", photos.string(), "-o", (folder.path() / "out").string(), "--dry-run"};
    words.insert(words.end(), options.begin(), options.end());
    return answer_of(words);
  }
  fs::path marks(const std::string& text, const char* name = "marks.yaml") const {
    write_file(folder.path() / name, text);
    return folder.path() / name;
  }

  TemporaryFolder folder;
  fs::path photos = folder.path() / "photos";
};

// A plan of a farm with the real stages: marks next to the photos are given, and costs are known.
TEST_F(GivenInputs, PlansOfFarmsTakeTheMarksNextToPhotos) {
  const fs::path capture = folder.path() / "captures/kettle", results = folder.path() / "results";
  make_folders(capture / "photos");
  for (const char* name : {"img_0001.jpg", "img_0002.jpg"}) write_ldr(capture / "photos" / name, Image8(60, 40, 3, 90));
  write_file(capture / "marks.yaml", kRightMarks);
  const Answer a = answer_of({"farm", "plan", capture.parent_path().string(), "-o", results.string(), "--cores", "2"});
  ASSERT_EQ(a.code, 0) << a.text;
  const std::string commands = read_file(results / "tasks.txt");
  EXPECT_NE(commands.find("--masks " + (capture / "marks.yaml").string()), std::string::npos) << commands;
  EXPECT_EQ(a.text.find("0.0 h the longest"), std::string::npos) << a.text;
  write_file(capture / "marks.yaml", "size: [60, 40]\nmarks:\n  - {photo: none.jpg, class: specular, box: [1, 1, 20, 30]}\n");
  EXPECT_EQ(answer_of({"farm", "plan", capture.parent_path().string(), "-o", results.string()}).code, 2);
}

TEST_F(GivenInputs, PhotosHaveTheNamesThatIngestGivesThem) {
  const PhotoNames names(photos);
  for (const char* name : {"img_0001.jpg", "img_0001", "upper.JPG", "upper_png.png", "linear.png", "linear"})
    EXPECT_TRUE(names.has(name)) << name;
  for (const char* name : {"img_0003.jpg", "linear.exr", "upper.png", ""}) EXPECT_FALSE(names.has(name)) << name;
  YamlReader in(parse_yaml("linear.exr", "name"));
  EXPECT_EQ(names.find_by_part(in.root(), in), names.find("linear.png"));
  EXPECT_EQ(names.nearest("img_0003.jpg"), "img_0001.jpg");
  EXPECT_TRUE(PhotoNames(folder.path() / "nowhere").empty());
}

TEST_F(GivenInputs, ThatDoNotExistEndTheRunAtOnce) {
  for (const char* flag : {"--masks", "--poses", "--normals", "--truth"}) {
    const Answer a = dry_run({flag, "/nowhere/at.all"});
    EXPECT_EQ(a.code, 3) << flag;
    EXPECT_NE(a.text.find("does not exist"), std::string::npos) << a.text;
    EXPECT_NE(a.text.find("/nowhere/at.all"), std::string::npos) << a.text;
    EXPECT_NE(a.text.find(flag), std::string::npos) << a.text;
  }
  EXPECT_EQ(dry_run({"--truth", "none"}).code, 0);
}

TEST_F(GivenInputs, MarksAreReadBeforeAnythingIsComputed) {
  EXPECT_EQ(dry_run({"--masks", marks(kRightMarks).string()}).code, 0);
  const Answer syntax = dry_run({"--masks", marks("marks: [\n").string()});
  EXPECT_EQ(syntax.code, 2);
  EXPECT_NE(syntax.text.find("marks.yaml:"), std::string::npos) << syntax.text;
  for (const char* name : {"marks.yaml", "MARKS.YML"}) {
    const Answer photo = dry_run({"--masks", marks("marks:\n  - photo: img_0022.jpg\n    class: specular\n", name).string()});
    EXPECT_EQ(photo.code, 2);
    EXPECT_NE(photo.text.find(std::string(name) + ":2:12"), std::string::npos) << photo.text;
    EXPECT_NE(photo.text.find("did you mean 'img_0002.jpg'"), std::string::npos) << photo.text;
  }
  const char* crossing = "marks:\n  - {photo: img_0002.jpg, class: specular, polygon: [[1, 1], [9, 9],\n    [9, 1], [1, 9]]}\n";
  const Answer crosses = dry_run({"--masks", marks(crossing).string()});
  EXPECT_EQ(crosses.code, 2);
  EXPECT_NE(crosses.text.find("marks.yaml:3:5: error: the outline crosses itself"), std::string::npos) << crosses.text;
}

// Every mistake ends the run, and inspect, with its line before a stage starts.
TEST_F(GivenInputs, MistakesInMarksAreFoundByRunAndInspect) {
  write_ldr(photos / "a.png", Image8(60, 40, 3, 90));
  write_ldr(photos / "b.png", Image8(60, 40, 3, 90));
  const std::string one = "  - {photo: a.png, class: specular, box: [1, 1, 20, 30]}\n", head = "size: [60, 40]\nmarks:\n" + one;
  const auto second = [](const std::string& rest) { return "  - {photo: b.png, " + rest + "}\n"; };
  const struct {
    std::string text, where, what;
  } cases[] = {
      {head + second("class: glass, box: [1, 1, 20, 30]"), ":4:27: ", "'glass' is no class"},
      {head + second("class: glass, box: [1, 1, 20, 30]"), ":4:27: ", "did you mean 'transparent'?"},
      {head + second("class: specular, box: [1, 1, 20, 41]"), ":4:42: ", "(20, 41) lies outside a photo of 60x40"},
      {head + second("class: specular, box: [1, 1, 20, 30], size: [60, 60]"), ":4:5: ", "is not this one, which is 60x40"},
      {head + second("class: specular, box: [20, 1, 1, 30]"), ":4:42: ", "left must be smaller than right"},
      {head + second("class: specular"), ":4:5: ", "a mark has a box or a polygon"},
      {head + one, ":4:13: ", "'specular' is marked twice in this photo"},
      {head, ":3:5: ", "'specular' is marked in one photo only"},
      {"marks:\n" + one, ":2:5: ", "of what size was the photo that was marked?"},
      {"size: [60, 40]\nmarks: []\n", ":2:8: ", "marks must be a list of marks"},
      {"", ":1:1: ", "marks must be a list of marks"},
      {"mark:\n" + one, ":1:1: ", "unknown key 'mark'; did you mean 'marks'?"},
  };
  for (const auto& c : cases) {
    const std::string file = marks(c.text).string();
    const Answer run = answer_of({"run", photos.string(), "-o", (folder.path() / "out").string(), "--masks", file}),
                 look = answer_of({"inspect", photos.string(), "--masks", file});
    for (const Answer& a : {run, look}) {
      EXPECT_EQ(a.code, 2) << c.text << a.text;
      EXPECT_NE(a.text.find("marks.yaml" + c.where), std::string::npos) << c.text << a.text;
      EXPECT_NE(a.text.find(c.what), std::string::npos) << c.text << a.text;
    }
    EXPECT_FALSE(fs::exists(folder.path() / "out"));
  }
}

// A card or scale bar measured at the resolution of the camera lies outside the reduced photo.
TEST_F(GivenInputs, MeasuresCountInPixelsOfReducedPhotos) {
  write_ldr(photos / "a.png", Image8(640, 480, 3, 90));
  write_ldr(photos / "b.png", Image8(640, 480, 3, 90));
  const auto run = [&](const char* option, const std::string& text) {
    return dry_run({option, text, "--set", "ingest.max_side=320"});
  };
  const std::pair<const char*, std::string> outside[] = {{"--grey-card", "a.png:410,220,60,40"},
                                                         {"--scale-bar", "a.png:10,10,20,10 b.png:410,220,470,260 = 5cm"}};
  for (const auto& [option, text] : outside) {
    const Answer a = run(option, text);
    EXPECT_EQ(a.code, 2) << a.text;
    EXPECT_NE(a.text.find("it reaches to column 470 and row 260"), std::string::npos) << a.text;
    EXPECT_NE(a.text.find("has 320x240 pixels; the photo has 640x480"), std::string::npos) << a.text;
    EXPECT_NE(a.text.find("multiply its coordinates by 0.5"), std::string::npos) << a.text;
    EXPECT_EQ(dry_run({option, text, "--set", "ingest.max_side=0"}).code, 0);
  }
  // In no size of the photo.
  const Answer beyond = run("--grey-card", "a.png:700,20,60,40");
  EXPECT_EQ(beyond.code, 2);
  EXPECT_EQ(beyond.text.find("multiply"), std::string::npos) << beyond.text;
  // Inside either size: accepted, and the size that counts is named.
  EXPECT_NE(check_grey_card("a.png:100,50,20,20", photos, 320).find("pixels of images/a.png (about 320x240)"), std::string::npos);
  EXPECT_EQ(check_grey_card("a.png:100,50,20,20", photos), "");
}

TEST_F(GivenInputs, MasksInFoldersThatAreNoClassesEndTheRunAtOnce) {
  const fs::path masks = folder.path() / "masks";
  write_file(masks / "object/img_0001.png", "x");
  EXPECT_EQ(dry_run({"--masks", masks.string()}).code, 0);
  write_file(masks / "glass/img_0001.png", "x");
  const Answer a = dry_run({"--masks", masks.string()});
  EXPECT_EQ(a.code, 3);
  EXPECT_NE(a.text.find("did you mean 'transparent'"), std::string::npos) << a.text;
  EXPECT_NE(a.text.find((masks / "glass").string()), std::string::npos) << a.text;
  // The photos may have such a folder themselves.
  write_file(photos / "glass/img_0001.jpg", "x");
  EXPECT_EQ(dry_run({"--masks", masks.string()}).code, 0);
}

TEST_F(GivenInputs, MasksOfOtherPhotosEndTheRunAtOnceUnlessTheyAreNotUsed) {
  const fs::path masks = folder.path() / "masks";
  write_file(masks / "specular/other.png", "x");
  const Answer a = dry_run({"--masks", masks.string()});
  EXPECT_EQ(a.code, 3);
  EXPECT_NE(a.text.find("no photo has a mask of the class 'specular'"), std::string::npos) << a.text;
  EXPECT_EQ(dry_run({"--masks", masks.string(), "--set", "masks.specular.source=none", "--set", "sfm.masks.specular=off"}).code,
            0);
}

// The libraries of the codecs find no address space: not a fault of the build.
TEST_F(GivenInputs, TooLittleAddressSpaceIsNamedAsThat) {
  write_ldr(photos / "picture.png", Image8(64, 48, 3, 90));  // its codec is loaded when it is read
  const std::string program = (fs::path(VITRINE_BIN_DIR) / "vitrine-ingest").string(), out = (folder.path() / "out").string();
  Answer a;
  const ProcessResult r = run_process({.arguments = {"bash", "-c", "ulimit -v 200000; exec \"$@\"", "bash", program, "--input",
                                                     "photos=" + photos.string(), "--output", out},
                                       .on_line = [&](std::string_view line) { a.text += std::string(line) + "\n"; }});
  EXPECT_EQ(r.exit_code, 6) << a.text;
  EXPECT_NE(a.text.find("not enough memory for the codecs"), std::string::npos) << a.text;
  EXPECT_NE(a.text.find("ulimit -v"), std::string::npos) << a.text;
}

TEST_F(GivenInputs, ResultsAreNeverWrittenIntoThemOrOverThem) {
  const fs::path link = folder.path() / "link", scene = folder.path() / "scene";
  fs::create_directory_symlink(photos, link);
  const auto answer = [&](const fs::path& of, const fs::path& out, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", of.string(), "-o", out.string(), "--dry-run"});
    return answer_of(more);
  };
  for (const auto& [of, out] :
       {std::pair{photos, photos / "out"}, std::pair{link, photos / "out"}, std::pair{photos, link / "out"},
        std::pair{photos, photos}, std::pair{photos, link}, std::pair{link, photos / "new/../out"}}) {
    const Answer a = answer(of, out);
    EXPECT_EQ(a.code, 2) << of << " " << out << a.text;
    EXPECT_NE(a.text.find("inside the folder of photos"), std::string::npos) << a.text;
    EXPECT_FALSE(fs::exists(photos / "out"));
  }
  // images/ in the output folder holds undistorted photos; photos/ holds nothing of a run.
  write_file(scene / "images/a.jpg", "x");
  write_file(scene / "photos/a.jpg", "x");
  fs::create_directory_symlink(scene, folder.path() / "scene link");
  for (const fs::path& out : {scene, folder.path() / "scene link"}) {
    const Answer a = answer(scene / "images", out);
    EXPECT_EQ(a.code, 2);
    EXPECT_NE(a.text.find("lies where results are written"), std::string::npos) << a.text;
    EXPECT_EQ(answer(scene / "photos", out).code, 0);
  }
  write_file(scene / "masks/object/a.png", "x");
  EXPECT_EQ(answer(scene / "photos", scene, {"--masks", (scene / "masks").string()}).code, 2);
  EXPECT_EQ(answer(scene / "photos", scene / "masks/out", {"--masks", (scene / "masks").string()}).code, 2);
}

TEST_F(GivenInputs, SettingsThatAreReplacedAreNamed) {
  const fs::path out = folder.path() / "out", given = marks(kRightMarks);
  const auto run = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {"run", photos.string(), "-o", out.string(), "--no-preflight"});
    return answer_of(options);  // ends at ingest, whose photos are none; the settings are written before
  };
  EXPECT_EQ(run({"--preset", "preview", "--masks", given.string()}).text.find("note: the settings"), std::string::npos);
  const std::string said = dry_run({}).text;
  EXPECT_NE(said.find("preset preview -> standard"), std::string::npos) << said;
  EXPECT_NE(said.find("masks " + given.string() + " -> none"), std::string::npos) << said;
  EXPECT_EQ(dry_run({"--preset", "preview", "--masks", given.string()}).text.find("note: the settings"), std::string::npos);

  // What no chosen stage reads may be gone by now, but not what is given now.
  fs::remove(given);
  EXPECT_EQ(answer_of({"run", out.string(), "--dry-run", "--to", "ingest"}).code, 0);
  EXPECT_EQ(answer_of({"run", out.string(), "--dry-run"}).code, 3);
  EXPECT_EQ(dry_run({"--to", "ingest", "--masks", given.string()}).code, 3);
}

// A folder `truth` beside the photos counts for all commands alike.
TEST_F(GivenInputs, TruthBesideThePhotosIsInTheSettings) {
  make_folders(folder.path() / "truth");
  Settings settings(load_graph(VITRINE_BIN_DIR));
  settings.load({.flags = {{"input.photos", photos.string(), "command line"}}});
  EXPECT_EQ(settings.text("input.truth"), (folder.path() / "truth").string());
  Settings without(load_graph(VITRINE_BIN_DIR));
  without.load({.flags = {{"input.photos", photos.string(), "command line"}, {"input.truth", "none", "--truth"}}});
  EXPECT_EQ(without.text("input.truth"), "none");
}

}  // namespace
}  // namespace vitrine
