// Films made with ffmpeg: which frames are chosen, whether they are the frames of these times and upright, and what becomes of
// films that cannot be used.
#include <algorithm>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "core/intake/film/film_frames.h"
#include "core/intake/film/photos_and_films.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr int kWidth = 192, kHeight = 144, kFrames = 60, kStep = 1;  // pixels per frame

// A wall of patches.
ImageF wall() {
  Rng rng(7);
  const int w = kWidth + kStep * kFrames, h = kHeight;
  ImageF patches(w / 6, h / 6, 3);
  for (float& v : patches.data()) v = 40 + float(rng.below(180));
  return resized(patches, w, h);
}

// The view at `offset`, smeared over `smear` pixels (odd) across and down, around each pixel.
Image8 view(const ImageF& from, int offset, int smear = 1) {
  Image8 image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (int v = -(smear / 2); v <= smear / 2; ++v)
          for (int u = -(smear / 2); u <= smear / 2; ++u)
            sum += from.at(std::clamp(offset + x + u, 0, from.width() - 1), std::clamp(y + v, 0, kHeight - 1), c);
        image.at(x, y, c) = uint8_t(sum / float(smear * smear) + 0.5f);
      }
  return image;
}

// The stored samples of a frame: without its cICP chunk, which follows IHDR.
Image8 samples_of(const fs::path& frame) {
  std::string png = read_file(frame);
  EXPECT_EQ(png.substr(37, 4), "cICP");
  png.erase(33, 16);
  write_file(frame.string() + ".plain.png", png);
  return read_srgb8(frame.string() + ".plain.png");
}

class Films : public testing::Test {
 protected:
  void SetUp() override {
    if (!find_program("ffmpeg")) GTEST_SKIP() << "no ffmpeg";
  }
  fs::path at(const std::string& name) const { return folder.path() / name; }
  void ffmpeg(std::vector<std::string> words) const {
    words.insert(words.begin(), {"ffmpeg", "-nostdin", "-v", "error", "-y"});
    const ProcessResult r = run_process({.arguments = words});
    ASSERT_TRUE(r.ok()) << r.tail;
  }
  // A camera that moves by `step` pixels per frame; frames for which `blurred` is true are smeared.
  void pan(const std::string& name, int step, const std::function<bool(int)>& blurred, const std::string& filter = "null",
           std::vector<std::string> codec = {"-c:v", "libx264rgb", "-qp", "0"}, int smear = 9) const {
    const ImageF from = wall();
    const fs::path frames = at("made");
    make_folders(frames);
    for (int i = 0; i < kFrames; ++i)
      write_ldr(frames / fmt::format("f{:03}.png", i), view(from, step * i, blurred(i) ? smear : 1));
    std::vector<std::string> words{"-framerate", "25",   "-i",        (frames / "f%03d.png").string(),
                                   "-vf",        filter, "-fps_mode", "passthrough"};
    words.insert(words.end(), codec.begin(), codec.end());
    words.push_back(at(name).string());
    ffmpeg(words);
  }
  PhotosAndFilms cut(const fs::path& given, size_t most = 120) const {
    return photos_and_films(given, {.most_frames = most, .work = at("work"), .progress = [](double, const std::string&) {}});
  }
  Error error(const std::string& name) const {
    return error_of([&] { cut(at(name)); });
  }

  TemporaryFolder folder;
};

bool never(int) { return false; }
bool two_of_three(int i) { return i % 3 != 1; }

// Number of the made frame at a time, at 25 Hz.
int number_of(const FilmFrameReport& f) { return int(std::lround(f.time.seconds * 25)); }

TEST_F(Films, BlurredFramesAreAvoidedAndPixelsAreThoseOfTheTimes) {
  pan("a film's ünusual [name]: %d.mkv", kStep, two_of_three);
  const PhotosAndFilms all = cut(at("a film's ünusual [name]: %d.mkv"));
  ASSERT_GE(all.frames.size(), 6u);
  ASSERT_EQ(all.folder.photos.size(), all.frames.size());
  const ImageF from = wall();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    const int n = number_of(all.frames[i]);
    EXPECT_FALSE(two_of_three(n)) << n;
    EXPECT_EQ(all.folder.photos[i].source, all.frames[i].source);
    EXPECT_TRUE(std::ranges::equal(samples_of(all.folder.photos[i].path).data(), view(from, kStep * n).data())) << n;
    EXPECT_EQ(all.camera_of(all.frames[i].source), all.camera_of(all.frames[0].source));
    if (i > 0) EXPECT_GE(all.frames[i].motion - all.frames[i - 1].motion, all.least_motion - 1e-9);
  }
}

TEST_F(Films, FramesAreLimitedAndKeepTheirDistance) {
  pan("pan.mkv", kStep, never);
  const PhotosAndFilms all = cut(at("pan.mkv"), 4);
  EXPECT_LE(all.frames.size(), 4u);
  EXPECT_GE(all.frames.size(), 3u);
  EXPECT_GT(all.least_motion, 0.03);
  EXPECT_GT(number_of(all.frames.back()), kFrames / 2);
}

TEST_F(Films, VariableFrameRateKeepsTimesAndFrames) {
  pan("variable.mkv", kStep, two_of_three, "setpts='round((N+floor(N/7)*11)/25/TB)'");
  const PhotosAndFilms all = cut(at("variable.mkv"));
  ASSERT_GE(all.frames.size(), 6u);
  const ImageF from = wall();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    int n = 0;
    while (n + 1 < kFrames && n + n / 7 * 11 < number_of(all.frames[i])) ++n;
    EXPECT_EQ(n + n / 7 * 11, number_of(all.frames[i]));
    EXPECT_TRUE(std::ranges::equal(samples_of(all.folder.photos[i].path).data(), view(from, kStep * n).data())) << n;
  }
}

TEST_F(Films, RotationIsAppliedOnce) {
  pan("flat.mp4", kStep, never, "format=yuv444p", {"-c:v", "libx264", "-qp", "0"});
  // Two spellings of a quarter turn clockwise, of old and new versions of ffmpeg.
  const std::string flat_film = at("flat.mp4").string(), turned_film = at("turned.mp4").string();
  std::vector<std::string> words{"ffmpeg", "-v",      "error", "-y",   "-display_rotation", "270",
                                 "-i",     flat_film, "-c",    "copy", turned_film};
  if (!run_process({.arguments = words}).ok())
    ffmpeg({"-i", flat_film, "-c", "copy", "-metadata:s:v", "rotate=270", turned_film});
  ASSERT_EQ(read_film_info(turned_film).orientation, 6);
  const PhotosAndFilms flat = cut(flat_film);
  std::map<int64_t, Image8> upright;
  for (size_t i = 0; i < flat.frames.size(); ++i) upright[flat.frames[i].time.pts] = samples_of(flat.folder.photos[i].path);
  const PhotosAndFilms turned = cut(turned_film);
  size_t compared = 0;
  for (size_t i = 0; i < turned.frames.size(); ++i) {
    const auto stored = upright.find(turned.frames[i].time.pts);
    if (stored == upright.end()) continue;
    ++compared;
    const Image8 seen = samples_of(turned.folder.photos[i].path);
    ASSERT_EQ(seen.width(), kHeight);
    ASSERT_EQ(seen.height(), kWidth);
    for (int y = 0; y < kWidth; y += 7)
      for (int x = 0; x < kHeight; x += 7) ASSERT_EQ(seen.at(x, y, 1), stored->second.at(y, kHeight - 1 - x, 1)) << x << ' ' << y;
  }
  EXPECT_GE(compared, 1u);
}

TEST_F(Films, SameBytesForAnyNumberOfThreads) {
  pan("pan.mkv", kStep, two_of_three);
  std::vector<std::string> bytes[2];
  const int before = thread_limit();
  for (int k = 0; k < 2; ++k) {
    set_thread_limit(k == 0 ? 1 : 3);
    const PhotosAndFilms all = cut(at("pan.mkv"));
    for (const PhotoFile& p : all.folder.photos) bytes[k].push_back(p.source + read_file(p.path));
    write_film_report(at("out" + std::to_string(k)), all);
    for (const char* name : {"ingest/films.json", "ingest/films.jpg"})
      bytes[k].push_back(read_file(at("out" + std::to_string(k)) / name));
  }
  set_thread_limit(before);
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(Films, UnusableFilmsAreRefusedByTheirReason) {
  pan("still.mkv", 0, never);
  EXPECT_EQ(error("still.mkv").detail().code, "FILM_STANDS_STILL");
  pan(
      "soft.mkv", kStep, [](int) { return true; }, "null", {"-c:v", "libx264rgb", "-qp", "0"}, 15);
  EXPECT_EQ(error("soft.mkv").detail().code, "FILM_BLURRED");
  write_file(at("empty.mp4"), "");
  EXPECT_NE(error("empty.mp4").detail().why.find("0 bytes"), std::string::npos);
  write_file(at("text.mp4"), "this is no film\n");
  EXPECT_EQ(error("text.mp4").detail().code, "BAD_FILM");
  ffmpeg({"-f", "lavfi", "-i", "sine=duration=1", at("sound.mp4").string()});
  EXPECT_NE(error("sound.mp4").detail().why.find("no video stream"), std::string::npos);
  pan("whole.mp4", kStep, never, "format=yuv420p", {"-c:v", "libx264"});
  const std::string bytes = read_file(at("whole.mp4"));
  write_file(at("cut.mp4"), bytes.substr(0, bytes.size() / 2));
  EXPECT_NE(error("cut.mp4").detail().why.find("truncated"), std::string::npos);
  write_file(at("list.mp4"), "#EXTM3U\n#EXTINF:1,\n" + at("whole.mp4").string() + "\n");
  EXPECT_EQ(error("list.mp4").detail().code, "BAD_FILM");
}

TEST_F(Films, FilmOfAPhotoIsLeftOut) {
  make_folders(at("set"));
  pan("set/IMG_1.MOV", kStep, never, "format=yuv420p", {"-c:v", "libx264"});
  write_ldr(at("set/img_1.jpg"), view(wall(), 0));
  const PhotosAndFilms all = cut(at("set"));
  EXPECT_TRUE(all.films.empty());
  EXPECT_EQ(all.folder.live_photos, std::vector<std::string>{"IMG_1.MOV"});
  EXPECT_EQ(all.folder.photos.size(), 1u);
  EXPECT_EQ(notes_of(all.folder).front().code, "FILMS_OF_PHOTOS");
}

TEST(FilmInfoText, ColoursAndTurnsAreRead) {
  const std::string json =
      R"({"streams":[{"index":1,"codec_type":"video","codec_name":"hevc","pix_fmt":"yuv420p10le","width":1920,"height":1080,)"
      R"("color_primaries":"bt2020","color_transfer":"arib-std-b67","color_space":"bt2020nc","color_range":"tv","duration":"3.5",)"
      R"("side_data_list":[{"displaymatrix":"\n00000000: 0 65536 0\n00000001: -65536 0 0\n00000002: 0 0 1073741824\n"}]}]})";
  const FilmInfo info = parse_film_info(json, "film.mov");
  EXPECT_EQ(info.color.primaries, 9u);
  EXPECT_EQ(info.color.transfer, 18u);
  EXPECT_EQ(info.matrix, "bt2020");
  EXPECT_EQ(info.orientation, 6);
  EXPECT_TRUE(info.deep);
  EXPECT_TRUE(info.notes.empty());
  EXPECT_EQ(info.seconds, 3.5);
  for (const char* bad : {"", "[]", "{}", R"({"streams":[1,{"codec_type":2}]})", R"({"streams":[{"codec_type":"video"}]})"})
    EXPECT_EQ(error_of([&] { parse_film_info(bad, "film.mov"); }).detail().code, "BAD_FILM") << bad;
}

}  // namespace
}  // namespace vitrine
