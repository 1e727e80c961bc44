// `vitrine edit` on a finished project, and what takes --edited.
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "pipeline/commands.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class EditCommand : public testing::Test {
 protected:
  EditCommand() {
    setenv("VITRINE_STAGE_DIR", VITRINE_BIN_DIR, 1);
    write_file(project() / "vitrine.yaml", "");
    const test::TwoBalls balls;
    ArtifactStore store(store_of(project()));
    for (const auto& [stage, folder] : balls.artifacts()) {
      const std::string key(32, stage[0]);
      PendingArtifact pending(store, stage, key);
      fs::copy(folder, pending.path(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
      Manifest manifest;
      manifest.stage = stage, manifest.key = key;
      pending.commit(manifest, "{}");
      set_current_key(project(), stage, key);
    }
  }
  ~EditCommand() override { unsetenv("VITRINE_STAGE_DIR"); }

  const fs::path& project() const { return folder_.path(); }
  fs::path list(const std::string& edits) const {
    write_file(outside_.path() / "edits.yaml", "edits:\n" + edits);
    return outside_.path() / "edits.yaml";
  }
  int edit(const Words& more) const {
    Words words{project().string()};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--quiet", "--no-progress"});
    return edit_command(words);
  }
  size_t surfels() const { return read_layer(project() / "edited/gaussians/diffuse.ply").size(); }

  TemporaryFolder folder_, outside_;
};

constexpr const char* kDeleteA = "  - select: {class: specular}\n    delete: true\n";
constexpr const char* kTintA = "  - select: {class: specular}\n    set: {tint: 0.5}\n";
constexpr const char* kNothing = "  - select: {box: [8, 8, 8, 9, 9, 9]}\n    delete: true\n";

TEST_F(EditCommand, EachListStartsFromTheOriginals) {
  const size_t all = test::TwoBalls().layer.size();
  EXPECT_EQ(edit({list(kDeleteA).string()}), 0);
  EXPECT_LT(surfels(), all);
  const std::string first = read_file(project() / "edited/gaussians/diffuse.ply");
  EXPECT_EQ(edit({list(kTintA).string()}), 0);
  EXPECT_EQ(surfels(), all);
  // A list that fails leaves what is there.
  EXPECT_EQ(edit({list(kNothing).string()}), exit_code(ErrorKind::Input));
  EXPECT_EQ(surfels(), all);
  EXPECT_NE(read_file(project() / "edited/edits.yaml").find("tint"), std::string::npos);
  // Without a file the list in the folder is replayed, as the user has left it there.
  fs::remove(project() / "edited/edits.yaml");
  write_file(project() / "edited/edits.yaml", std::string("edits:\n") + kDeleteA);
  EXPECT_EQ(edit({}), 0);
  EXPECT_EQ(read_file(project() / "edited/gaussians/diffuse.ply"), first);
}

TEST_F(EditCommand, PicturesOfTheEditedSceneLieBesideIt) {
  const Words picture{project().string(), "--views", "heldout", "--size", "32x24", "--quiet", "--no-progress"};
  const auto rendered = [&](bool edited) {
    Words words = picture;
    if (edited) words.emplace_back("--edited");
    return render_command(words);
  };
  EXPECT_EQ(error_of([&] { rendered(true); }).detail().code, "NO_EDITS");
  EXPECT_EQ(rendered(false), 0);
  const std::string original = read_file(project() / "render/view_0.png");
  EXPECT_EQ(edit({list(kDeleteA).string()}), 0);
  EXPECT_EQ(rendered(true), 0);
  const std::string without_a = read_file(project() / "edited/render/view_0.png");
  EXPECT_NE(without_a, original);
  EXPECT_EQ(read_file(project() / "render/view_0.png"), original);
  // Another list, and the pictures follow without another `vitrine edit`.
  write_file(project() / "edited/edits.yaml", std::string("edits:\n") + kTintA);
  EXPECT_EQ(rendered(true), 0);
  EXPECT_NE(read_file(project() / "edited/render/view_0.png"), without_a);
}

TEST_F(EditCommand, BadCallsSayWhatIsMissing) {
  EXPECT_EQ(error_of([&] { edit_command({}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { edit({"a.yaml", "b.yaml"}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { edit({"nowhere.yaml"}); }).detail().code, "MISSING_INPUT");
  EXPECT_EQ(error_of([&] { edit({}); }).detail().code, "NO_EDITS");
  EXPECT_EQ(edit({list("  - select: all\n").string()}), exit_code(ErrorKind::Usage));
  EXPECT_FALSE(fs::exists(project() / "edited"));
  write_file(store_of(project()) / "current.json", "{}");
  EXPECT_EQ(error_of([&] { edit({list(kTintA).string()}); }).detail().code, "NO_SCENE");
}

}  // namespace
}  // namespace vitrine
