// Films given to `vitrine run` and `vitrine inspect`: frames become photos of one camera; films that cannot be used, a machine
// without ffmpeg and an interrupted run leave no result and no child process.
#include "tests/support/scrolled_film.h"
#include "tests/support/vitrine_process.h"

namespace vitrine {
namespace {

class FilmRun : public VitrineProcess {
 protected:
  FilmRun() {
    unsetenv("VITRINE_STAGE_DIR");
    unsetenv("VITRINE_CONFIG_DIR");
  }
  void SetUp() override {
    if (!find_program("ffmpeg")) GTEST_SKIP() << "no ffmpeg";
    write_file(photos(), test::scrolled_films(folder.path()).front());
  }
  fs::path photos() const final { return folder.path() / "my film.mp4"; }
  Outcome to_ingest(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"--to", "ingest", "--no-progress"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  nlohmann::json ingested(const char* file) const { return nlohmann::json::parse(read_file(out() / "ingest" / file)); }
  // Number of processes that decode the film.
  size_t decoders() const {
    size_t count = 0;
    std::error_code ec;
    for (fs::directory_iterator at("/proc", ec), end; at != end; at.increment(ec)) {
      std::ifstream in(at->path() / "cmdline", std::ios::binary);
      const std::string line{std::istreambuf_iterator<char>(in), {}};
      count += line.find("file:" + photos().string()) != line.npos;
    }
    return count;
  }
};

TEST_F(FilmRun, FramesArePhotosOfOneCamera) {
  const Outcome look = call({"inspect", photos().string()});
  EXPECT_EQ(look.exit, 0) << look.text;
  EXPECT_TRUE(look.said("11 of 12 frames are used")) << look.text;
  ASSERT_EQ(to_ingest().exit, 0);
  const nlohmann::json films = ingested("films.json"), photos_now = ingested("photos.json").at("photos");
  EXPECT_EQ(films.at("films").at(0).at("chosen"), 11);
  ASSERT_EQ(photos_now.size(), 11u);
  for (const nlohmann::json& photo : photos_now) EXPECT_EQ(photo.at("camera"), "film my film.mp4");
  EXPECT_EQ(photos_now[1].at("name"), "my film_000100.png");  // at 0.1 s
  EXPECT_TRUE(fs::exists(out() / "ingest/films.jpg"));
  EXPECT_TRUE(to_ingest().said("everything up to date"));
  ASSERT_EQ(to_ingest({"--frames", "4"}).exit, 0);
  EXPECT_LE(ingested("photos.json").at("photos").size(), 4u);
  EXPECT_GE(ingested("photos.json").at("photos").size(), 2u);
  if (!fs::exists(fs::path(VITRINE_BIN_DIR) / "vitrine-mark.html")) return;  // a build without npm
  const Outcome page = call({"mark", out().string(), "-o", (folder.path() / "mark.html").string()});
  EXPECT_EQ(page.exit, 0) << page.text;
}

TEST_F(FilmRun, UnusableFilmsLeaveNoResult) {
  const std::string whole = read_file(photos());
  write_file(photos(), whole.substr(0, whole.size() / 2));
  const Outcome cut = to_ingest();
  EXPECT_EQ(cut.exit, 3);
  EXPECT_TRUE(cut.said("moov atom not found") && cut.said("try copy it from the camera again")) << cut.text;
  write_file(photos(), whole);
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  for (const Outcome& none : {to_ingest(), call({"inspect", photos().string()})}) {
    EXPECT_EQ(none.exit, 7);
    EXPECT_TRUE(none.said("which is not installed") && none.said("try apt-get install ffmpeg")) << none.text;
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(fs::exists(out() / "ingest"));
}

TEST_F(FilmRun, AnInterruptedRunStopsFfmpegAndGoesOn) {
  std::vector<std::string> words{"ffmpeg", "-nostdin", "-v", "error", "-y", "-f", "lavfi", "-i"};
  words.push_back("testsrc2=size=320x240:rate=25:duration=16,scroll=horizontal=0.005");
  words.insert(words.end(), {"-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p", photos().string()});
  ASSERT_TRUE(run_process({.arguments = words}).ok());
  const pid_t child = start({"run", photos().string(), "-o", out().string(), "--to", "ingest", "--quiet", "--frames", "5"});
  while (decoders() < 1 && waitpid(child, nullptr, WNOHANG) == 0) usleep(2000);
  ASSERT_EQ(kill(child, SIGINT), 0);
  EXPECT_EQ(wait_for(child), 130);
  EXPECT_EQ(decoders(), 0u);
  EXPECT_FALSE(fs::exists(out() / "ingest"));
  EXPECT_EQ(to_ingest({"--frames", "5"}).exit, 0);
  EXPECT_LE(ingested("photos.json").at("photos").size(), 5u);
}

}  // namespace
}  // namespace vitrine
