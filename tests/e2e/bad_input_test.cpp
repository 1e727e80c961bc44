// What people do to their files: each has one clear message and its exit code, and nothing that was finished is lost.
#include <sys/mount.h>

#include "tests/e2e/tiny_room.h"

namespace vitrine {
namespace {

const std::vector<std::string> kShort = {"--set", "optimize.iterations=10", "--set", "mesh.resolution=32"};

// Turns over the bits of one byte in the middle of a file, in place: the store's hard link has it too.
void damage(const fs::path& file) {
  std::fstream f(file, std::ios::in | std::ios::out | std::ios::binary);
  ASSERT_TRUE(f) << file;
  const auto middle = static_cast<std::streamoff>(fs::file_size(file) / 2);
  f.seekg(middle);
  const int byte = f.get();
  f.seekp(middle);
  f.put(static_cast<char>(byte ^ 0xff));
}

TEST_F(TinyRoom, DamagedPhotosAreLeftOutByName) {
  write_file(photos() / "img_0001.png", "");
  write_file(photos() / "img_0003.png", read_file(photos() / "img_0003.png").substr(0, 3000));
  write_file(photos() / "img_0005.png", std::string(5000, 'x'));
  const Outcome o = room(true_poses(), {"--to", "sfm"});
  EXPECT_EQ(o.exit, 0) << o.text;
  EXPECT_TRUE(o.said("3 photos are left out")) << o.text;
  EXPECT_TRUE(o.said("img_0001.png: the file is empty"));
  EXPECT_TRUE(o.said("img_0003.png: the PNG has no end chunk: the file is truncated"));
  EXPECT_TRUE(o.said("img_0005.png: it is a text file, not a picture, called .png: fetch the picture itself"));
  EXPECT_TRUE(o.has("registered 9/9"));
}

TEST_F(TinyRoom, InspectTakesTheMasksOfARunOrThoseThatAreGiven) {
  // The output of a call that must end well, without its line breaks.
  const auto inspected = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "inspect");
    const Outcome o = call(words);
    EXPECT_EQ(o.exit, 0) << o.text;
    std::istringstream in(o.text);
    std::string text;
    for (std::string word; in >> word;) text += word + " ";
    return text;
  };
  const std::string masks = photos().string();
  EXPECT_NE(inspected({photos().string()}).find("without masks of yours"), std::string::npos);
  EXPECT_NE(inspected({photos().string(), "--masks", masks}).find("with layers"), std::string::npos);
  const Outcome nowhere = call({"inspect", photos().string(), "--masks", "nowhere"});
  EXPECT_EQ(nowhere.exit, 3);
  EXPECT_TRUE(nowhere.has("there are no such masks")) << nowhere.text;
  write_file(out() / "vitrine.yaml", fmt::format("input:\n  photos: \"{}\"\n  masks: \"{}\"\n", photos().string(), masks));
  EXPECT_NE(inspected({out().string()}).find("with layers"), std::string::npos);
}

TEST_F(TinyRoom, PosesThatDoNotFitAreRefused) {
  const ImageF photo = read_srgb(photos() / "img_0003.png");
  write_ldr(photos() / "img_0003.png", Image8(photo.width() / 2, photo.height(), 3));
  const Outcome size = room(true_poses());
  EXPECT_EQ(size.exit, 3);
  EXPECT_TRUE(size.has("the photos have 2 sizes")) << size.text;
  EXPECT_TRUE(size.has("FAILED  POSES_SIZE"));
  EXPECT_TRUE(size.has("  where  img_0003.png\n  why    the pose is for 96 x 64 pixels, the photo is 48 x 64\n  try    "));
  write_file(folder.path() / "broken/sparse/0/cameras.bin", "nonsense" + std::string(100, 'x'));
  write_file(folder.path() / "broken/sparse/0/images.bin", "nonsense" + std::string(100, 'x'));
  const Outcome model = room("broken");
  EXPECT_EQ(model.exit, 3);
  EXPECT_TRUE(model.has("FAILED  COLMAP_MODEL_DAMAGED")) << model.text;
  EXPECT_TRUE(model.has("sparse/0/cameras.bin\n  why    at byte 0 it announces"));
  write_file(folder.path() / "poses.json", "{\"frames\": 3");
  const Outcome text = room("poses.json");
  EXPECT_EQ(text.exit, 3);
  EXPECT_TRUE(text.has("error: this is not a usable transforms.json\n  where  ")) << text.text;
  EXPECT_EQ(room("nowhere").exit, 3);
}

TEST_F(TinyRoom, AGreyCardThatIsNotThereEndsTheRunBeforeItBegins) {
  const Outcome unknown = room(true_poses(), {"--grey-card", "img_0099.png:1,2,3,4"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_TRUE(unknown.has("error: the grey card cannot be found\n  where  img_0099.png:1,2,3,4\n  why    no photo in "))
      << unknown.text;
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(room(true_poses(), {"--set", "decompose.grey_card=img_0003.png"}).exit, 2);
  EXPECT_EQ(room(true_poses(), {"--grey-card", "img_0003.png:1,2,3,4", "--dry-run"}).exit, 0);
}

// A photo without a camera is known when sfm is done: before hours of training.
TEST_F(TinyRoom, MeasuresInAPhotoWithoutCameraEndTheRunBehindSfm) {
  auto poses = nlohmann::json::parse(read_file(true_poses()));
  auto& frames = poses["frames"];
  for (size_t i = 0; i < frames.size(); ++i)
    if (frames[i]["file_path"].get<std::string>().find("img_0003") != std::string::npos) frames.erase(i--);
  write_file(folder.path() / "poses.json", poses.dump());
  for (const auto& [option, text] : {std::pair{"--grey-card", "img_0003.png:1,2,3,4"},
                                     std::pair{"--scale-bar", "img_0001.png:9,9,20,9 img_0003.png:9,9,20,9 = 5cm"}}) {
    const Outcome o = room("poses.json", {option, text});
    EXPECT_EQ(o.exit, 2) << o.text;
    EXPECT_TRUE(o.said("no photo with a known camera is called 'img_0003.png'")) << o.text;
    EXPECT_EQ(states().at("masks"), "failed");
    EXPECT_FALSE(states().contains("objects"));
  }
}

TEST_F(TinyRoom, WithoutColmapTheFirstStageIsKept) {
  setenv("VITRINE_COLMAP", "/nonexistent", 1);
  const Outcome o = call({"run", photos().string(), "-o", out().string()});
  unsetenv("VITRINE_COLMAP");
  EXPECT_EQ(o.exit, 7);
  EXPECT_TRUE(o.has("error: COLMAP is missing: no program '/nonexistent'\n")) << o.text;
  EXPECT_TRUE(o.has("apt-get install --no-install-recommends colmap"));
  EXPECT_EQ(states(), (States{{"ingest", "ran"}, {"sfm", "failed"}}));
}

TEST_F(TinyRoom, FlippedBytesInTheStoreAreFoundAndComputedAgain) {
  ASSERT_EQ(room(true_poses(), kShort).exit, 0);
  const auto before = digests();
  damage(out() / "gaussians/diffuse.ply");
  damage(out() / "linear/img_0004.exr");
  const Outcome again = room(true_poses(), kShort);
  EXPECT_EQ(again.exit, 0);
  EXPECT_TRUE(again.said("the stored result of 'sfm' is damaged (linear/img_0004.exr has other contents")) << again.text;
  EXPECT_TRUE(again.said("the stored result of 'optimize' is damaged (gaussians/diffuse.ply has other contents"));
  EXPECT_EQ(states().at("mesh"), "cached");
  EXPECT_EQ(digests(), before);
}

// A file system of its own, for what a full or read-only disk does. Needs root.
class SmallDisk : public TinyRoom {
 protected:
  void SetUp() override {
    fs::create_directories(out());
    if (mount("tmpfs", out().c_str(), "tmpfs", 0, "size=1100k") != 0) GTEST_SKIP() << "mounting a small disk needs root";
    mounted_ = true;
  }
  void TearDown() override {
    if (mounted_) umount2(out().c_str(), MNT_DETACH);
  }
  void remount(unsigned long flags, const char* options) const {
    ASSERT_EQ(mount("tmpfs", out().c_str(), "tmpfs", MS_REMOUNT | flags, options), 0);
  }

 private:
  bool mounted_ = false;
};

TEST_F(SmallDisk, FullIsToldAndTheNextRunGoesOn) {
  const Outcome before = room(true_poses(), kShort);
  EXPECT_EQ(before.exit, 6) << before.text;
  EXPECT_TRUE(before.has("error: the disk is too small for the results\n  where  ")) << before.text;
  EXPECT_EQ(states(), (States{{"ingest", "ran"}, {"sfm", "failed"}}));
  std::vector<std::string> all_the_same = kShort;
  all_the_same.push_back("--no-preflight");
  const Outcome full = room(true_poses(), all_the_same);
  EXPECT_EQ(full.exit, 6) << full.text;
  EXPECT_TRUE(full.has("  FAILED  DISK_FULL")) << full.text;
  EXPECT_TRUE(full.has("  try    free some disk space and run the same command again")) << full.text;
  remount(0, "size=64m");
  const Outcome rest = room(true_poses(), kShort);
  EXPECT_EQ(rest.exit, 0) << rest.text;
  EXPECT_EQ(states().at("ingest"), "cached");
}

TEST_F(SmallDisk, ReadOnlyIsTold) {
  remount(MS_RDONLY, "size=64m");
  const Outcome o = room(true_poses(), kShort);
  EXPECT_EQ(o.exit, 6) << o.text;
  EXPECT_TRUE(o.has("Read-only file system\n  try    choose an output folder you can write to with -o\n")) << o.text;
}

}  // namespace
}  // namespace vitrine
