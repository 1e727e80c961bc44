// vitrine mark of photos, and of runs that ended early: the page has what is there, and the command says what is not.
#include "tests/e2e/tiny_room.h"

namespace vitrine {
namespace {

class MarkCommand : public TinyRoom {
 protected:
  void SetUp() override {
    if (!fs::exists(fs::path(VITRINE_BIN_DIR) / "vitrine-mark.html")) GTEST_SKIP() << "the build had no npm";
  }
  static bool has(const fs::path& page, const std::string& part) { return read_file(page).find(part) != std::string::npos; }
};

TEST_F(MarkCommand, OfPhotosWritesAPageIntoTheCurrentFolder) {
  const Outcome o = call({"mark", photos().string()});
  ASSERT_EQ(o.exit, 0) << o.text;
  const fs::path page = folder.path() / "mark.html";
  EXPECT_TRUE(o.has(page.string())) << o.text;
  EXPECT_TRUE(has(page, "\"has_cameras\":false"));
  EXPECT_TRUE(has(page, "vitrine run " + join_command({photos().string()})));
  EXPECT_EQ(call({"mark", (folder.path() / "nowhere").string()}).exit, 3);
  const Outcome marks = call({"mark", photos().string(), "--masks", "nowhere.yaml"});
  EXPECT_EQ(marks.exit, 3) << marks.text;
}

TEST_F(MarkCommand, OfARunShowsWhatIsThereAndSaysWhatIsNot) {
  const fs::path marks = folder.path() / "marks.yaml", page = out() / "mark.html";
  write_file(marks,
             "size: [96, 64]\nmarks:\n  - {photo: img_0000.png, class: object, box: [20, 10, 80, 60]}\n"
             "  - {photo: img_0003.png, class: object, box: [10, 5, 86, 60]}\n");
  const std::string poses = write_true_model();
  ASSERT_EQ(run({"--poses", poses, "--masks", marks.string(), "--to", "ingest"}).exit, 0);
  const Outcome early = call({"mark", out().string()});
  ASSERT_EQ(early.exit, 0) << early.text;
  EXPECT_TRUE(early.said("the stage 'sfm' of this run has not been computed")) << early.text;
  EXPECT_TRUE(has(page, "\"has_cameras\":false"));
  EXPECT_TRUE(has(page, "\"marks_name\":\"marks.yaml\""));
  ASSERT_EQ(run({"--poses", poses, "--masks", marks.string(), "--to", "sfm"}).exit, 0);
  const Outcome placed = call({"mark", out().string()});
  ASSERT_EQ(placed.exit, 0) << placed.text;
  EXPECT_TRUE(placed.said("the stage 'masks' of this run has not been computed")) << placed.text;
  EXPECT_TRUE(has(page, "\"has_cameras\":true"));
  ASSERT_EQ(run({"--poses", poses, "--masks", marks.string(), "--to", "masks"}).exit, 0);
  fs::remove(marks);
  const Outcome masked = call({"mark", out().string()});
  ASSERT_EQ(masked.exit, 0) << masked.text;
  EXPECT_TRUE(masked.said("the marks of this run are not there any more")) << masked.text;
  EXPECT_FALSE(masked.said("has not been computed")) << masked.text;
  EXPECT_TRUE(has(page, "\"mask_sources\":{\"object\":\"boxes\""));
  EXPECT_TRUE(has(page, "\"runs\":{\"object\":["));
}

}  // namespace
}  // namespace vitrine
