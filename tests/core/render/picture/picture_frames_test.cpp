#include "core/render/picture/picture_frames.h"

#include <gtest/gtest.h>

#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST(PictureFrames, AreOneNumberOrTwo) {
  EXPECT_EQ(frames_of("", 60).count(), 60u);
  EXPECT_EQ(frames_of("7", 60).first, 7u);
  EXPECT_EQ(frames_of("7", 60).count(), 1u);
  EXPECT_EQ(frames_of("10-19", 60).first, 10u);
  EXPECT_EQ(frames_of("10-19", 60).last, 19u);
  EXPECT_EQ(part_text(frames_of("10-19", 60), 60), ", frames 10 to 19 of 60");
  EXPECT_EQ(part_text(frames_of("0-59", 60), 60), "");
  for (const char* bad : {"a", "1-", "-1", "1-2-3", "1..2", "1 - 2", "0x2", "99999999999999999999", "1-b"}) {
    EXPECT_NE(frames_problem(bad).find(std::string("\"") + bad + "\""), std::string::npos) << bad;
    EXPECT_EQ(error_of([&] { frames_of(bad, 60); }).kind(), ErrorKind::Usage) << bad;
  }
  EXPECT_NE(frames_problem("9-3").find("write 3-9"), std::string::npos);
}

TEST(PictureFrames, ThatTheListLacksAreNamedWithThoseItHas) {
  const Error e = error_of([] { frames_of("50-60", 60); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_EQ(e.detail().code, "NO_FRAME");
  EXPECT_NE(std::string(e.what()).find("frames 0 to 59"), std::string::npos) << e.what();
  EXPECT_EQ(e.detail().hint, "--frames 50-59");
}

class StoredFramesTest : public testing::Test {
 protected:
  static KeyTerms terms(const std::string& frames, const std::string& samples = "4") {
    return {{"stage", "render"}, {"option.frames", "\"" + frames + "\""}, {"option.samples", samples}};
  }
  void put(const KeyTerms& terms, const std::string& picture) {
    Manifest m;
    m.stage = "render", m.terms = terms, m.key = key_of(terms);
    PendingArtifact pending(store, "render", m.key);
    write_file(pending.path() / "render/b.png", picture);
    write_file(pending.path() / "render/layers/depth/b.exr", "depth");
    write_file(pending.path() / "render/a/b.png", "another");
    pending.commit(m, "{}");
  }
  // Whether the picture `stem` was there for the whole list.
  bool take(const std::string& stem) {
    fs::remove_all(folder.path() / "out");
    const fs::path scratch = store.scratch("render", key_of(terms("")));
    return StoredFrames(scratch, "").take("render", stem, folder.path() / "out");
  }
  TemporaryFolder folder;
  ArtifactStore store{folder.path() / "store"};
};

TEST_F(StoredFramesTest, ComeFromArtifactsThatDifferInTheFramesAlone) {
  put(terms("0-1", "64"), "noisier");
  EXPECT_FALSE(take("b"));
  put(terms("0-1"), "mine");
  ASSERT_TRUE(take("b"));
  EXPECT_EQ(read_file(folder.path() / "out/render/b.png"), "mine");
  EXPECT_TRUE(fs::exists(folder.path() / "out/render/layers/depth/b.exr"));
  EXPECT_FALSE(fs::exists(folder.path() / "out/render/a")) << "another picture";
  EXPECT_FALSE(take("c"));
}

TEST_F(StoredFramesTest, AreNotTakenFromADamagedArtifact) {
  put(terms("0-1"), "mine");
  const fs::path entry = store.entry("render", key_of(terms("0-1")));
  write_file(entry / "render/layers/depth/b.exr", "DEPTH");
  EXPECT_FALSE(take("b"));
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
  write_file(entry / "manifest.json", "{");
  EXPECT_FALSE(take("a/b"));
}

}  // namespace
}  // namespace vitrine
