// Films made with ffmpeg: which frames are chosen, whether they are the frames of these times and upright, and what becomes of
// films that cannot be used.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "core/intake/film/film_frames.h"
#include "core/intake/film/photos_and_films.h"
#include "core/intake/photos/linear_photo.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr int kWidth = 160, kHeight = 120, kFrames = 40, kStep = 1;  // pixels per frame

// A wall of patches.
Image8 wall() {
  Rng rng(7);
  const int w = kWidth + kStep * kFrames, h = kHeight;
  ImageF patches(w / 5, h / 5, 3);
  for (float& v : patches.data()) v = 40 + float(rng.below(180));
  const ImageF large = resized(patches, w, h);
  Image8 out(w, h, 3);
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = uint8_t(large.data()[i] + 0.5f);
  return out;
}

// The mean of `smear` pixels (odd) across and down, around each pixel.
Image8 smeared(const Image8& from, int smear) {
  Image8 image(from.width(), from.height(), 3);
  const int r = smear / 2;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int v = -r; v <= r; ++v)
          for (int u = -r; u <= r; ++u)
            sum += from.at(std::clamp(x + u, 0, image.width() - 1), std::clamp(y + v, 0, image.height() - 1), c);
        image.at(x, y, c) = uint8_t(sum / (smear * smear));
      }
  return image;
}

// The view at `offset`.
Image8 view(const Image8& from, int offset) {
  Image8 image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = from.at(std::min(offset + x, from.width() - 1), y, c);
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
  // Films that several tests use: sharp ones are a third of the frames of `pan.mkv`, all of `flat.mp4`.
  static void SetUpTestSuite() {
    if (!find_program("ffmpeg")) return;
    shared_ = std::make_unique<TemporaryFolder>();
    pan(shared("pan.mkv"), kStep, "null", kLossless, [](int i) { return i % 3 != 1; });
    pan(shared("flat.mp4"), kStep, "format=yuv444p", {"-c:v", "libx264", "-qp", "0"});
  }
  static void TearDownTestSuite() { shared_.reset(); }
  void SetUp() override {
    if (!shared_) GTEST_SKIP() << "no ffmpeg";
  }
  static fs::path shared(const std::string& name) { return shared_->path() / name; }
  fs::path at(const std::string& name) const { return folder.path() / name; }
  static void ffmpeg(std::vector<std::string> words) {
    words.insert(words.begin(), {"ffmpeg", "-nostdin", "-v", "error", "-y"});
    const ProcessResult r = run_process({.arguments = words});
    ASSERT_TRUE(r.ok()) << r.tail;
  }
  // A camera that moves by `step` pixels per frame; frames for which `blurred` is true are smeared.
  static void pan(
      const fs::path& film, int step, const std::string& filter = "null", const std::vector<std::string>& codec = kLossless,
      const std::function<bool(int)>& blurred = [](int) { return false; }) {
    const Image8 sharp = wall(), soft = smeared(sharp, 9);
    std::string pixels;
    for (int i = 0; i < kFrames; ++i) {
      const Image8 frame = view(blurred(i) ? soft : sharp, step * i);
      pixels.append(reinterpret_cast<const char*>(frame.data().data()), frame.data().size());
    }
    const TemporaryFolder made;
    const fs::path raw = made.path() / "made.rgb";
    write_file(raw, pixels);
    std::vector<std::string> words{"-f", "rawvideo", "-pixel_format", "rgb24", "-video_size"};
    words.insert(words.end(), {fmt::format("{}x{}", kWidth, kHeight), "-framerate", "25", "-i", raw.string(), "-vf", filter});
    words.insert(words.end(), {"-fps_mode", "passthrough", "-preset", "ultrafast"});
    words.insert(words.end(), codec.begin(), codec.end());
    words.push_back(film.string());
    ffmpeg(words);
  }
  PhotosAndFilms cut(const fs::path& given, size_t most = 120, const std::string& work = "work") const {
    return photos_and_films(given, {.most_frames = most, .work = at(work), .progress = [](double, const std::string&) {}});
  }
  Error error(const fs::path& film) const {
    return error_of([&] { cut(film); });
  }

  static const inline std::vector<std::string> kLossless{"-c:v", "libx264rgb", "-qp", "0"};
  static inline std::unique_ptr<TemporaryFolder> shared_;
  TemporaryFolder folder;
};

// Number of the made frame at a time, at 25 Hz.
int number_of(const FilmFrameReport& f) { return int(std::lround(f.time.seconds * 25)); }

TEST_F(Films, BlurredFramesAreAvoidedAndPixelsAreThoseOfTheTimes) {
  const fs::path film = at("a film's ünusual [name]: %d.mkv");
  fs::copy_file(shared("pan.mkv"), film);
  const PhotosAndFilms all = cut(film);
  EXPECT_EQ(all.least_motion, 0.03);
  ASSERT_GE(all.frames.size(), 5u);
  ASSERT_EQ(all.folder.photos.size(), all.frames.size());
  const Image8 from = wall();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    const int n = number_of(all.frames[i]);
    EXPECT_EQ(n % 3, 1) << n;
    EXPECT_EQ(all.folder.photos[i].source, all.frames[i].source);
    EXPECT_TRUE(std::ranges::equal(samples_of(all.folder.photos[i].path).data(), view(from, kStep * n).data())) << n;
    EXPECT_EQ(all.camera_of(all.frames[i].source), all.camera_of(all.frames[0].source));
    if (i > 0) {
      EXPECT_GE(all.frames[i].motion - all.frames[i - 1].motion, all.least_motion - 1e-9);
    }
  }
}

TEST_F(Films, VariableFrameRateKeepsTimesAndFrames) {
  pan(at("variable.mkv"), kStep, "setpts='round((N+floor(N/7)*11)/25/TB)'");
  const PhotosAndFilms all = cut(at("variable.mkv"));
  ASSERT_GE(all.frames.size(), 5u);
  const Image8 from = wall();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    int n = 0;
    while (n + 1 < kFrames && n + n / 7 * 11 < number_of(all.frames[i])) ++n;
    EXPECT_EQ(n + n / 7 * 11, number_of(all.frames[i]));
    EXPECT_TRUE(std::ranges::equal(samples_of(all.folder.photos[i].path).data(), view(from, kStep * n).data())) << n;
  }
}

TEST_F(Films, HundredsOfTimesAreDecoded) {
  const FilmInfo info = read_film_info(shared("pan.mkv"));
  std::vector<int64_t> only;
  for (int64_t ms = 0; ms < 40 * kFrames; ms += 8) only.push_back(ms);  // every fifth is that of a frame
  std::string damage;
  const std::vector<FrameTime> times = decode_frames(
      {.film = info, .filters = "null", .pixel_format = "gray", .frame_bytes = kWidth * kHeight, .only = only},
      [](size_t, std::span<const uint8_t>) {}, damage);
  ASSERT_EQ(times.size(), size_t(kFrames));
  for (size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i].pts, int64_t(40 * i));
  EXPECT_EQ(damage, "");
}

TEST_F(Films, OfFramesWithOneTimeTheFirstIsUsed) {
  pan(at("doubled.mkv"), kStep, "setpts=2*floor(N/2)");
  const PhotosAndFilms all = cut(at("doubled.mkv"));
  EXPECT_EQ(all.films[0].frames, size_t(kFrames / 2));
  ASSERT_GE(all.frames.size(), 4u);
  const Image8 from = wall();
  for (size_t i = 0; i < all.frames.size(); ++i) {
    const int n = number_of(all.frames[i]);
    EXPECT_EQ(n % 2, 0) << n;  // the first of two
    EXPECT_TRUE(std::ranges::equal(samples_of(all.folder.photos[i].path).data(), view(from, kStep * n).data())) << n;
  }
}

TEST_F(Films, RotationIsAppliedOnce) {
  const fs::path flat_film = shared("flat.mp4"), turned_film = at("turned.mp4");
  std::string bytes = read_file(flat_film);
  const size_t track = bytes.find("tkhd");
  ASSERT_NE(track, bytes.npos);
  constexpr size_t kMatrix = 44;  // of version 0, after the type (ISO/IEC 14496-12, 8.3.2)
  constexpr uint8_t kQuarterTurn[] = {0,    0,    0, 0, 0, 1, 0, 0, 0, 0, 0, 0,   // clockwise: 0 1 0
                                      0xff, 0xff, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};  // -1 0 0
  std::copy(std::begin(kQuarterTurn), std::end(kQuarterTurn), bytes.begin() + long(track + kMatrix));
  write_file(turned_film, bytes);
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

// One colour as 10-bit YCbCr of limited range with the matrix of BT.2020; luma is that of the diffuse white (ITU-R BT.2408).
TEST_F(Films, HdrBecomesLinearOverItsDiffuseWhite) {
  struct Curve {
    const char* name;
    int luma;
    unsigned transfer;
  };
  for (const Curve& curve : {Curve{"smpte2084", 573, 16}, Curve{"arib-std-b67", 721, 18}}) {
    const fs::path film = at("hdr.mkv"), frame = at("hdr.png");
    // By a filter: as options of the output, ffmpeg 7 takes them for a wish to convert.
    ffmpeg({"-f", "lavfi", "-i", "color=black:size=32x24:rate=5:duration=0.2,format=yuv420p10le", "-vf",
            fmt::format("geq=lum={}:cb=512:cr=576,setparams=range=tv:color_primaries=bt2020:color_trc={}:colorspace=bt2020nc",
                        curve.luma, curve.name),
            "-c:v", "ffv1", film.string()});
    write_film_frames(read_film_info(film), {{0, frame}}, [](size_t) {});
    const ImageF seen = read_linear_photo(frame, read_photo_head(frame)).linear;
    ImageF expected(2, 1, 3);  // this colour, and grey of its luma
    const float y = float(curve.luma - 64) / 876, cr = 64.0f / 896;
    const float rgb[] = {y + 1.4746f * cr, y - 0.57135f * cr, y};
    for (int c = 0; c < 3; ++c) expected.at(0, 0, c) = rgb[c], expected.at(1, 0, c) = y;
    cicp_profile({.primaries = 9, .transfer = curve.transfer})->to_linear(expected);
    EXPECT_NEAR(expected.at(1, 0, 1), 1, 0.005) << curve.name;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen.at(16, 12, c), expected.at(0, 0, c), 0.002) << curve.name;
  }
}

TEST_F(Films, SameBytesForAnyNumberOfThreads) {
  std::vector<std::string> bytes[2];
  const int before = thread_limit();
  for (int k = 0; k < 2; ++k) {
    set_thread_limit(k == 0 ? 1 : 3);
    const PhotosAndFilms all = cut(shared("pan.mkv"));
    for (const PhotoFile& p : all.folder.photos) bytes[k].push_back(p.source + read_file(p.path));
    write_film_report(at("out" + std::to_string(k)), all);
    for (const char* name : {"ingest/films.json", "ingest/films.jpg"})
      bytes[k].push_back(read_file(at("out" + std::to_string(k)) / name));
  }
  set_thread_limit(before);
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(Films, UnusableFilmsAreRefusedByTheirReason) {
  pan(at("still.mkv"), 0);
  EXPECT_EQ(error(at("still.mkv")).detail().code, "FILM_STANDS_STILL");
  pan(at("soft.mkv"), kStep, "gblur=sigma=8");
  EXPECT_EQ(error(at("soft.mkv")).detail().code, "FILM_BLURRED");
  write_file(at("empty.mp4"), "");
  EXPECT_NE(error(at("empty.mp4")).detail().why.find("0 bytes"), std::string::npos);
  write_file(at("text.mp4"), "this is no film\n");
  EXPECT_EQ(error(at("text.mp4")).detail().code, "BAD_FILM");
  ffmpeg({"-f", "lavfi", "-i", "sine=duration=1", at("sound.mp4").string()});
  EXPECT_NE(error(at("sound.mp4")).detail().why.find("no video stream"), std::string::npos);
  const std::string bytes = read_file(shared("flat.mp4"));
  write_file(at("cut.mp4"), bytes.substr(0, bytes.size() / 2));
  EXPECT_NE(error(at("cut.mp4")).detail().why.find("truncated"), std::string::npos);
  write_file(at("list.mp4"), "#EXTM3U\n#EXTINF:1,\n" + shared("flat.mp4").string() + "\n");
  EXPECT_EQ(error(at("list.mp4")).detail().code, "BAD_FILM");
}

TEST_F(Films, FilmOfAPhotoIsLeftOut) {
  make_folders(at("set"));
  fs::copy_file(shared("flat.mp4"), at("set/IMG_1.MOV"));
  write_ldr(at("set/img_1.jpg"), view(wall(), 0));
  const PhotosAndFilms all = cut(at("set"));
  EXPECT_TRUE(all.films.empty());
  EXPECT_EQ(all.folder.live_photos, std::vector<std::string>{"IMG_1.MOV"});
  EXPECT_EQ(all.folder.photos.size(), 1u);
  EXPECT_EQ(notes_of(all.folder).front().code, "FILMS_OF_PHOTOS");
}

// A film of 1000 frames, each `motion` after the one before; every fifth is sharp.
std::vector<TrackedFrame> steady_track(double motion) {
  std::vector<TrackedFrame> track;
  for (int i = 0; i < 1000; ++i) track.push_back({{i, i / 25.0}, i % 5 == 2 ? 1.0 : 0.9, motion * i});
  return track;
}

TEST(ChoiceOfFrames, KeepsADistanceAndSharesALimitAmongFilms) {
  const std::vector<std::vector<TrackedFrame>> films{steady_track(0.001), steady_track(0.003)};
  const auto count = [](const FrameChoice& choice, size_t film) {
    return std::ranges::count(choice.frames, film, &ChosenFrame::film);
  };
  const FrameChoice all = choose_frames(films, 1000), few = choose_frames(films, 60);
  EXPECT_EQ(all.least_motion, 0.03);
  EXPECT_LE(few.frames.size(), 60u);
  EXPECT_GE(few.frames.size(), 54u);
  EXPECT_NEAR(double(count(few, 1)) / double(count(few, 0)), 3, 0.5);  // its camera moves three times as far
  for (const FrameChoice* choice : {&all, &few})
    for (size_t i = 0; i + 1 < choice->frames.size(); ++i) {
      const ChosenFrame &a = choice->frames[i], &b = choice->frames[i + 1];
      if (a.film != b.film) continue;
      EXPECT_GE(films[b.film][b.frame].motion - films[a.film][a.frame].motion, choice->least_motion - 1e-9);
    }
  for (const ChosenFrame& c : few.frames) EXPECT_EQ(c.frame % 5, 2u) << c.frame;
}

TEST(FilmTimes, AreIntegersInTheirBase) {
  const char* line = "[Parsed_showinfo_1 @ 0x55] [info] n:   7 pts:-9007199254740993 pts_time:-7e+11 pos: 5 fmt:yuv420p";
  EXPECT_EQ(parse_frame_time(line), -9007199254740993);
  for (const char* bad : {"", "n: 0 pts: 5 pts_time:1", "[showinfo] n: 0 pts: NOPTS pts_time:NOPTS", "[showinfo] n: 0 pts: 5",
                          "[showinfo] n: 0 pts: 99999999999999999999 pts_time:1"})
    EXPECT_FALSE(parse_frame_time(bad)) << bad;
  TimeBase base;
  ASSERT_TRUE(parse_time_base("[Parsed_showinfo_1 @ 0x55] [info] config in time_base: 1001/30000, frame_rate: 25/1", base));
  EXPECT_DOUBLE_EQ(base.seconds(30000), 1001);
  for (const char* bad :
       {"config in time_base: 1/25", "[showinfo] config in time_base: 1/0,", "[showinfo] config in time_base: -1/5,",
        "[showinfo] config in time_base: 1", "[showinfo] config in time_base: /"})
    EXPECT_FALSE(parse_time_base(bad, base)) << bad;
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
  EXPECT_EQ(info.bits, 10);
  EXPECT_TRUE(info.notes.empty());
  EXPECT_EQ(info.seconds, 3.5);
  for (const char* bad : {"", "[]", "{}", R"({"streams":[1,{"codec_type":2}]})", R"({"streams":[{"codec_type":"video"}]})"})
    EXPECT_EQ(error_of([&] { parse_film_info(bad, "film.mov"); }).detail().code, "BAD_FILM") << bad;
}

}  // namespace
}  // namespace vitrine
