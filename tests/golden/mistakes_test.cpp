// Mistakes of every kind through the real programs, and what they answer, word for word. A message says what is wrong, where or
// why, and what to try.
#include "tests/golden/told.h"

namespace vitrine {
namespace {

class GoldenMessages : public Told {
 protected:
  // The photos with their true poses, in the folder `out`.
  void capture() const {
    const auto stage = [&](const std::string& program, const std::string& input) {
      const std::string path = std::string(VITRINE_BIN_DIR) + "/" + program, poses = "poses=" + true_poses();
      Words words = {path, "-q", "-o", "out", "-i", input};
      if (program == "vitrine-sfm") words.insert(words.end(), {"-i", poses});
      ASSERT_TRUE(run_process({.arguments = words, .working_folder = folder.path(), .on_line = [](std::string_view) {}}).ok());
    };
    stage("vitrine-ingest", "photos=" + photos_);
    stage("vitrine-sfm", "ingest=out");
  }
  const std::string photos_ = "my phötos/room";
};

TEST_F(GoldenMessages, OnTheCommandLine) {
  fs::create_directories(folder.path() / "nothing");
  told("a command that there is not", {"vitrine", "runn", photos_});
  told("an option that there is not", {"vitrine", "run", photos_, "--presett", "preview"});
  told("no number", {"vitrine", "run", photos_, "-j", "many"});
  told("an option without its value", {"vitrine", "run", photos_, "-o"});
  told("a flag with a value", {"vitrine", "run", photos_, "--force=yes"});
  told("no photos", {"vitrine", "run"});
  told("photos that are not there", {"vitrine", "run", "nowhere"});
  told("the results among the photos", {"vitrine", "run", photos_, "-o", photos_ + "/out"});
  told("a format of the log that there is not", {"vitrine", "run", photos_, "--log-format", "xml"});
  told("a word too many", {"vitrine", "status", "a", "b"});
  told("no output folder of a run", {"vitrine", "status", "nothing"});
  told("a project that is not there", {"vitrine", "render", "nowhere"});
  told("what to do with the store", {"vitrine", "cache", "sweep", "nothing"});
  told("a format to export that there is not", {"vitrine", "export", "nowhere", "--formats", "mesh-gbl"});
  told("what to show of the options", {"vitrine", "config", "sho"});
  told("a stage that there is not", {"vitrine", "config", "reference", "mehs"});
  told("no project to edit", {"vitrine", "edit"});
  told("two folders of photos", {"vitrine", "inspect", photos_, "b"});
  told("no photos to mark", {"vitrine", "mark"});
  told("marks in no file of marks", {"vitrine", "mark", photos_, "--masks", "marks.txt"});
  told("an option of a stage that there is not", {"vitrine-mesh", "--thread", "2"});
  told("a word that is no option of a stage", {"vitrine-mesh", "stray"});
  told("an input that a stage does not have", {"vitrine-mesh", "-i", "photos=" + photos_, "-o", "m"});
  told("an input that is not there", {"vitrine-mesh", "-i", "sfm=nowhere", "-i", "optimize=nowhere", "-o", "m"});
  told("a stage without its input", {"vitrine-ingest", "-o", "i"});
  told("a stage without a place for its result", {"vitrine-ingest", "-i", "photos=" + photos_});
  told("a place that cannot be written to", {"vitrine-ingest", "-i", "photos=" + photos_, "-o", "/proc/i"});
  told("no size of memory", {"vitrine-ingest", "-i", "photos=" + photos_, "-o", "i", "--max-memory", "4 apples"});
  golden::expect_golden("on_the_command_line.txt", all());
}

TEST_F(GoldenMessages, InSettings) {
  const auto ingest = [&](const std::string& set) {
    return Words{"vitrine-ingest", "-i", "photos=" + photos_, "-o", "i", "--set", set};
  };
  told("a name with a typo", ingest("max_sid=640"));
  told("a word where a number stands", ingest("max_side=large"));
  told("a number out of its range", ingest("max_side=-3"));
  told("no value", ingest("max_side"));
  told("a choice that there is not", {"vitrine-masks", "-i", "sfm=x", "-o", "m", "--set", "frame=upright"});
  told("two options that contradict each other",
       {"vitrine-normals", "-i", "sfm=x", "-o", "o", "--set", "onnx.width=512"});
  const auto run = [&](const Words& more) {
    Words words = {"vitrine", "run", photos_, "-o", "out"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  put("typos.yaml", "preset: preview\nmesh:\n  voxle: 0.002\n  faces: 12k\noptimise:\n  iterations: 5\n");
  told("three mistakes in a file", run({"-c", "typos.yaml"}));
  told("the same, for a stage alone", {"vitrine-mesh", "-i", "sfm=x", "-i", "optimize=x", "-o", "m", "-c", "typos.yaml"});
  told("a file that is no YAML", run({"-c", put("broken.yaml", "mesh: {voxel: 0.1\noptimize: [\n")}));
  told("a key twice", run({"-c", put("twice.yaml", "mesh:\n  voxel: 0.1\nmesh:\n  faces: 9\n")}));
  told("a file that is not there", run({"-c", "nowhere.yaml"}));
  told("a preset that there is not", run({"--preset", "previw"}));
  told("a stage that there is not", run({"--from", "mehs"}));
  told("nothing to start from", run({"--from", "mesh"}));
  told("a range of no stage", run({"--from", "mesh", "--to", "sfm"}));
  told("two ways to choose stages", run({"--only", "mesh", "--from", "sfm"}));
  told("a size of memory", run({"--max-memory", "lots"}));
  told("a grey card in no photo", run({"--grey-card", "img_0099.png:1,2,3,4"}));
  told("a scale bar in one photo", run({"--scale-bar", "img_0001.png:1,2,3,4 = 5cm"}));
  told("a scale bar in no photo", run({"--scale-bar", "img_0001.png:1,2,3,4 img_0099.png:1,2,3,4 = 5cm"}));
  setenv("VITRINE_SET", "mesh.voxel=wide; sfm.mappper=global", 1);
  told("mistakes in VITRINE_SET", run({}));
  unsetenv("VITRINE_SET");
  golden::expect_golden("in_settings.txt", all());
}

TEST_F(GoldenMessages, AboutPhotosAndPoses) {
  const auto ingest = [](const std::string& folder) { return Words{"vitrine-ingest", "-i", "photos=" + folder, "-o", "i"}; };
  fs::create_directories(folder.path() / "empty");
  told("an empty folder", ingest("empty"));
  put("letters/a.txt", "no picture");
  told("a folder without pictures", ingest("letters"));
  put("broken/a.jpg", "");
  put("broken/b.png", read_file(photos() / "img_0001.png").substr(0, 900));
  told("pictures that cannot be read", ingest("broken"));
  fs::create_directories(folder.path() / "one");
  fs::copy_file(photos() / "img_0001.png", folder.path() / "one/a.png");
  told("one photo", ingest("one"));
  told("a file instead of a folder", ingest(put("photo.txt", "x")));

  capture();
  const auto sfm = [](const std::string& poses) {
    Words words = {"vitrine-sfm", "-i", "ingest=out", "-o", "s"};
    if (!poses.empty()) words.insert(words.end(), {"-i", "poses=" + poses});
    return words;
  };
  told("no poses where they should be", sfm("empty"));
  told("poses that are no JSON", sfm(put("cut.json", "{\"frames\": 3")));
  told("poses without cameras", sfm(put("frameless.json", "{\"frames\": []}")));
  const std::string poses = read_file(true_poses());
  told("poses of other photos", sfm(put("others.json", golden::replaced(poses, "img_00", "photo_"))));
  told("poses for photos of another size", sfm(put("large.json", golden::replaced(poses, "\"w\": 96", "\"w\": 960"))));
  put("model/sparse/0/cameras.bin", std::string(100, 'x'));
  put("model/sparse/0/images.bin", std::string(100, 'x'));
  told("a damaged model of COLMAP", sfm("model"));
  put("text/sparse/0/cameras.txt", "1 PINHOLE 96 64 90\n");
  put("text/sparse/0/images.txt", "1 1 0 0 0 0 0 2 1 img_0000.png\n\n");
  told("a camera without its numbers", sfm("text"));
  put("lens/sparse/0/cameras.txt", "1 FISHEYE_OF_MINE 96 64 90\n");
  put("lens/sparse/0/images.txt", "1 1 0 0 0 0 0 2 1 img_0000.png\n\n");
  told("a lens that nobody knows", sfm("lens"));
  setenv("VITRINE_COLMAP", "/nowhere/colmap", 1);
  told("no COLMAP", sfm({}));
  setenv("VITRINE_COLMAP", "/bin/true", 1);
  told("a program that is not COLMAP", sfm({}));
  unsetenv("VITRINE_COLMAP");
  told("photos in place of an artifact", {"vitrine-sfm", "-i", "ingest=" + photos_, "-o", "s"});
  golden::expect_golden("about_photos_and_poses.txt", all());
}

TEST_F(GoldenMessages, AboutMasksAndNormals) {
  capture();
  const auto masks = [](const std::string& given, const Words& more = {}) {
    Words words = {"vitrine-masks", "-i", "sfm=out", "-o", "m", "-i", "masks=" + given};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const auto mask = [&](const std::string& name, int width, int height, uint8_t level) {
    fs::create_directories((folder.path() / name).parent_path());
    write_ldr(folder.path() / name, Image8(width, height, 1, level));
  };
  told("files that are wanted and not given", {"vitrine-masks", "-i", "sfm=out", "-o", "m", "--set", "specular.source=files"});
  fs::create_directories(folder.path() / "none");
  told("a folder without masks", masks("none"));
  mask("others/specular/photo_1.png", 96, 64, 255);
  told("masks of other photos", masks("others"));
  mask("square/specular/img_0001.png", 64, 64, 255);
  told("masks of another shape", masks("square"));
  for (int i = 0; i < 12; ++i) mask(fmt::format("black/object/img_{:04}.png", i), 96, 64, 0);
  told("masks that mark nothing", masks("black"));
  put("broken/specular/img_0001.png", "no picture");
  told("a mask that cannot be read", masks("broken"));
  mask("twice/specular/img_0001.png", 96, 64, 255);
  mask("twice/specular/img_0001.jpg", 96, 64, 255);
  told("two masks of one photo", masks("twice"));
  told("mistakes in marks", masks(put("marks.yaml",
                                      "size: [96, 64]\nmarks:\n  - {photo: img_0001.png, class: glas, box: [1, 2, 3]}\n"
                                      "  - {photo: img_0077.png, class: object, box: [1, 2, 30, 40]}\n")));

  const auto normals = [](const Words& more) {
    Words words = {"vitrine-normals", "-i", "sfm=out", "-o", "n"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  told("a folder without normals", normals({"-i", "normals=none"}));
  mask("flat/img_0001.png", 96, 64, 128);
  told("a map without directions", normals({"-i", "normals=flat"}));
  told("a network that is none", normals({"-i", "network=" + put("n.onnx", "no network"), "--set", "source=onnx"}));
  golden::expect_golden("about_masks_and_normals.txt", all());
}

}  // namespace
}  // namespace vitrine
