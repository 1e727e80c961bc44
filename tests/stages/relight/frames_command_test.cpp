// --frames of `vitrine relight` and `vitrine render` on a finished project: parts in one folder, and the whole made of them.
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "tests/stages/compose/projects.h"
#include "tests/support/error_of.h"
#include "tests/support/files_below.h"

namespace vitrine {
namespace {

class FramesCommand : public testing::Test {
 protected:
  fs::path project() const { return projects_.at("room"); }
  int relight(const Words& more) const {
    Words words{project().string(), "--turntable", "4", "--size", "16x12", "--spp", "2", "--quiet", "--no-progress"};
    words.insert(words.end(), more.begin(), more.end());
    return relight_command(words);
  }
  test::Projects projects_;
};

TEST_F(FramesCommand, PartsGatherInOneFolderAndTheWholeTakesThem) {
  ASSERT_EQ(relight({"-o", projects_.at("alone").string()}), 0);
  auto whole = test::files_below(projects_.at("alone"));
  fs::remove_all(store_of(project()) / "relight");
  ASSERT_EQ(relight({"--frames", "2-3"}), 0);
  ASSERT_EQ(relight({"--frames", "0-1"}), 0);
  auto parts = test::files_below(project() / "relit");
  EXPECT_EQ(parts.size(), 4u * 2 + 2) << "pictures, transforms.json, settings.json";
  for (const auto& [file, bytes] : parts) EXPECT_EQ(bytes, whole.at("relit/" + file)) << file;
  ASSERT_EQ(relight({}), 0);
  std::map<std::string, std::string> made;
  for (const auto& [file, bytes] : test::files_below(project() / "relit")) made["relit/" + file] = bytes;
  EXPECT_EQ(made, whole);
  EXPECT_EQ(whole.contains("relit/captured/turntable.mp4"), find_program("ffmpeg").has_value());
  // Linked from the parts, not computed again.
  EXPECT_GE(fs::hard_link_count(project() / "relit/captured/frame_0003.exr"), 3u);
}

TEST_F(FramesCommand, SeveralMachinesMayWorkOnPartsAtOnce) {
  const int other = open((project() / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  ASSERT_EQ(flock(other, LOCK_SH), 0);
  EXPECT_EQ(render_command({project().string(), "--views", "all", "--frames", "2", "--size", "16x12", "--quiet"}), 0);
  EXPECT_TRUE(fs::exists(project() / "render/view_2.png"));
  EXPECT_FALSE(fs::exists(project() / "render/view_1.png"));
  EXPECT_EQ(error_of([&] { render_command({project().string(), "--quiet"}); }).kind(), ErrorKind::Locked);
  ASSERT_EQ(flock(other, LOCK_EX), 0);
  EXPECT_EQ(error_of([&] { relight({"--frames", "2"}); }).kind(), ErrorKind::Locked);
  close(other);
}

TEST_F(FramesCommand, PartsThatEndTogetherAreAllThere) {
  std::vector<pid_t> children;
  for (const char* frames : {"0", "1", "2", "3"}) {
    children.push_back(fork());
    if (children.back() == 0) _exit(relight({"--frames", frames}));
  }
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(fs::exists(project() / fmt::format("relit/captured/frame_000{}.png", i))) << i;
  EXPECT_TRUE(fs::exists(project() / "relit/captured/transforms.json"));
}

TEST_F(FramesCommand, WrongFramesAreMistakesOfUsage) {
  for (const char* wrong : {"x", "3-1", "2-4"}) EXPECT_EQ(relight({"--frames", wrong}), exit_code(ErrorKind::Usage)) << wrong;
  EXPECT_FALSE(fs::exists(project() / "relit"));
}

}  // namespace
}  // namespace vitrine
