// Turntables: what turns with the object is trained, the room is not.
#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/scene/camera/view_masks.h"
#include "core/render/model/layered_model.h"
#include "core/render/picture/trained_scene.h"
#include "stages/optimize/surroundings.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/turntable_capture.h"

namespace vitrine {
namespace {

using testing::TestContext;
using testing::TurntableCapture;
using Surface = TurntableCapture::Surface;

constexpr int kSide = 96;
constexpr int kHoldoutEvery = 8;

// What a capture's photos say of its surroundings, and which pixels are trained.
struct Decided {
  explicit Decided(const TurntableCapture& c, size_t without_mask = 0) : desc(c), folder("turntable-test") {
    c.write(sfm(), masks());
    for (size_t i = 0; i < without_mask; ++i) fs::remove(view_mask_path(masks(), MaskClass::Object, c.view(int(5 * i + 1))));
    capture = load_capture(sfm(), kSide, kHoldoutEvery);
    targets = load_targets(capture, masks(), {}, std::nullopt);
    const DenseDepth dense = dense_depth(capture, kSide, 5, 1);
    const auto get = [&]() -> const DenseDepth& { return dense; };
    surroundings = surroundings_to_train(WantedSurroundings::Auto, {}, capture, get, targets);
  }
  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path masks() const { return folder.path() / "masks"; }

  // Mean weight of the pixels that show a surface, those at the rims of surfaces left out.
  double weight(Surface wanted) const {
    double sum = 0, count = 0;
    const int w = desc.width, h = desc.height;
    for (int photo = 0; photo < desc.photos; ++photo) {
      const std::vector<Surface> shows = desc.surfaces(photo, w, h);
      const auto& masks = targets.photos[size_t(photo)][0].masks;
      const auto &object = masks[size_t(MaskClass::Object)], &ignore = masks[size_t(MaskClass::Ignore)];
      constexpr int kRim = 4;
      for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
          bool inner = true;
          for (int v = std::max(0, y - kRim); v <= std::min(h - 1, y + kRim); ++v)
            for (int u = std::max(0, x - kRim); u <= std::min(w - 1, x + kRim); ++u)
              inner &= shows[size_t(v) * size_t(w) + size_t(u)] == wanted;
          if (!inner) continue;
          const size_t i = size_t(y) * size_t(w) + size_t(x);
          count += 1;
          sum += (object.empty() ? 1 : object[i] / 255.) * (ignore.empty() ? 1 : 1 - ignore[i] / 255.);
        }
    }
    return sum / count;
  }

  TurntableCapture desc;
  TemporaryFolder folder;
  Capture capture;
  Targets targets;
  Surroundings surroundings;
};

TEST(Turntable, ThePlateIsTrainedAndTheRoomWeighsNothing) {
  const std::pair<const char*, TurntableCapture> captures[] = {
      {"painted", {.seed = 2}},
      {"white plate, no points around", {.points_around = false, .plain_plate = true}},
      {"both plain", {.plain_plate = true, .plain_room = true}},
      {"from the hand", {.shake = 0.12}}};
  for (const auto& [name, desc] : captures) {
    SCOPED_TRACE(name);
    const Decided d(desc);
    EXPECT_EQ(d.surroundings.trained, Trained::StillPart) << d.surroundings.why;
    EXPECT_GT(d.weight(Surface::Object), 0.999);
    EXPECT_GT(d.weight(Surface::Plate), 0.9) << d.surroundings.why;
    EXPECT_LT(d.weight(Surface::Room), 0.08) << d.surroundings.why;
  }
}

TEST(Turntable, APhotoWithoutAMaskTrainsWhatIsKnownToStandStill) {
  const Decided d({}, 4);
  EXPECT_EQ(d.surroundings.trained, Trained::StillPart) << d.surroundings.why;
  EXPECT_GT(d.weight(Surface::Plate), 0.9);
  EXPECT_LT(d.weight(Surface::Room), 0.08);
}

TEST(Turntable, WhereEverythingStandsStillNothingIsLeftOut) {
  for (const TurntableCapture& desc : {TurntableCapture{.room_turns_along = true},
                                       // A white plate in the middle of all photos is alike in place without moving.
                                       TurntableCapture{.room_turns_along = true, .plain_plate = true},
                                       TurntableCapture{.room_turns_along = true, .points_around = false}}) {
    const Decided d(desc);
    EXPECT_EQ(d.surroundings.trained, Trained::Everything) << d.surroundings.why;
    EXPECT_FALSE(d.targets.any(MaskClass::Ignore));
  }
}

TEST(Turntable, AnObjectWithoutAPlateIsTrainedAlone) {
  for (const TurntableCapture& desc : {TurntableCapture{.plate = false, .plain_room = true}, TurntableCapture{.plate = false}}) {
    const Decided d(desc);
    EXPECT_EQ(d.surroundings.trained, Trained::ObjectAlone) << d.surroundings.why;
    EXPECT_LT(d.weight(Surface::Room), 0.01);
  }
}

// PSNR of the held-out photos where they show the object or its plate.
double psnr_of_what_turns(const TurntableCapture& desc, const fs::path& sfm, const fs::path& artifact) {
  const TrainedScene trained = read_trained_scene(artifact);
  LayeredModel model(trained.image);
  Frame frame;
  double sum = 0, count = 0;
  for (int photo = 0; photo < desc.photos; photo += kHoldoutEvery) {
    const View view = desc.view(photo);
    model.forward(trained.surfels, view, frame);
    const ImageF truth = srgb_from_linear_image(read_exr_rgb(linear_image_path(sfm, view)));
    const std::vector<Surface> shows = desc.surfaces(photo, desc.width, desc.height);
    for (size_t i = 0; i < shows.size(); ++i)
      for (size_t c = 0; c < 3 && shows[i] != Surface::Room; ++c) {
        const double d = frame.srgb[c * shows.size() + i] - std::clamp(truth.data()[3 * i + c], 0.f, 1.f);
        sum += d * d, count += 1;
      }
  }
  return -10 * std::log10(sum / count);
}

OptimizeConfig turntable_config(int iterations) {
  OptimizeConfig config = testing::tiny_config(iterations);
  config.max_gaussians = 4000;
  config.initial.frustum_points = 2000;
  config.initial.stereo_side = kSide;
  config.holdout_every = kHoldoutEvery;
  return config;
}

TEST(TurntableRun, IsClearerThanWithTheRoom) {
  const TurntableCapture desc{.plain_plate = true, .plain_room = true};
  const TemporaryFolder folder("turntable-run");
  const fs::path sfm = folder.path() / "sfm", masks = folder.path() / "masks";
  desc.write(sfm, masks);
  // One training scatters by 2 dB: rounding alone decides where the room's fog stands.
  const std::array<uint64_t, 2> training_seeds{1, 2};
  OptimizeConfig config = turntable_config(400);
  double gain = 0;
  for (const uint64_t seed : training_seeds) {
    config.seed = seed;
    std::map<std::string, double> psnr;
    for (const bool part : {false, true}) {
      config.surroundings = part ? WantedSurroundings::Auto : WantedSurroundings::Train;
      TestContext context(sfm, folder.path() / ((part ? "auto" : "train") + std::to_string(seed)));
      context.masks = masks;
      run_optimize(config, context);
      psnr[part ? "auto" : "train"] = psnr_of_what_turns(desc, sfm, context.output());
      const auto views = nlohmann::json::parse(read_file(context.output() / "optimize/views.json"));
      EXPECT_EQ(views.value("object_alone", false), part);
      const auto mask = read_view_mask(context.output() / "optimize/trained", MaskClass::Object, desc.view(0));
      EXPECT_EQ(mask.has_value(), part);
      if (part) {  // of what was trained
        EXPECT_NEAR(context.metrics.at("heldout_psnr"), psnr["auto"], 3);
      }
    }
    gain += (psnr["auto"] - psnr["train"]) / double(training_seeds.size());
  }
  EXPECT_GT(gain, 1);
}

TEST(TurntableRun, KilledAndContinuedItEndsWithTheSameBytes) {
  const TurntableCapture desc{.photos = 12, .width = 48, .height = 36};
  const TemporaryFolder folder("turntable-killed");
  const fs::path sfm = folder.path() / "sfm", masks = folder.path() / "masks";
  desc.write(sfm, masks);
  OptimizeConfig config = turntable_config(30);
  config.checkpoint_every = 10;
  TestContext whole(sfm, folder.path() / "whole"), killed(sfm, folder.path() / "killed");
  whole.masks = killed.masks = masks;
  whole.thread_count = 1;
  run_optimize(config, whole);
  killed.after_step = [](int step) {
    if (step == 15) throw testing::Stopped{};
  };
  EXPECT_THROW(run_optimize(config, killed), testing::Stopped);
  killed.after_step = nullptr;
  run_optimize(config, killed);
  EXPECT_TRUE(fs::exists(whole.output() / "optimize/trained"));
  EXPECT_EQ(digest_folder(whole.output()), digest_folder(killed.output()));
}

}  // namespace
}  // namespace vitrine
