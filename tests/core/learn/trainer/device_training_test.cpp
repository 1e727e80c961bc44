// A training that stays on a device, with the kernels as loops where the card would be: it learns as on the CPU, its bytes depend
// on no order and no interruption, steps that the kernels do not know run on the CPU in between, and no surfels travel.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/hash.h"
#include "core/learn/optim/rates.h"
#include "core/learn/trainer/blocks/step_blocks.h"
#include "core/learn/trainer/training.h"
#include "core/render/raster/device.h"
#include "core/scene/surfels/activation.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

struct Copies {
  size_t up = 0, down = 0, largest = 0;  // number of copies; bytes of the largest
};

// Loops that count what is copied, with so much memory.
class CountingLoops : public BlockLoops {
 public:
  static inline uint64_t shuffle_seed = 0;
  static inline size_t memory = ~size_t{0};
  static inline Copies copies;
  CountingLoops() : BlockLoops(shuffle_seed) {}
  size_t free_memory() const { return memory; }
  template <class T>
  void upload(T* to, const T* from, size_t size) const {
    ++copies.up;
    copies.largest = std::max(copies.largest, size * sizeof(T));
    BlockLoops::upload(to, from, size);
  }
  template <class T>
  void download(T* to, const T* from, size_t size) const {
    ++copies.down;
    copies.largest = std::max(copies.largest, size * sizeof(T));
    BlockLoops::download(to, from, size);
  }
};

constexpr int kWidth = 48, kHeight = 32, kPhotos = 4;
constexpr size_t kPixels = size_t{kWidth} * kHeight;
constexpr uint32_t kSurfels = 100, kCap = 130;
constexpr float kNear = 0.05f;
constexpr size_t kFaint = 9;  // every so many surfels is faint

SplatLayer photographed_surfels() {
  SplatLayer layer(LayerKind::Diffuse, 1, kSurfels);
  Rng rng(5);
  for (size_t i = 0; i < layer.size(); ++i) {
    const double range[] = {3, 2, 1};
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, i)[c] = float((rng.uniform() - 0.5) * range[c]);
    layer.at(Attribute::Rotation, i)[0] = 1;
    for (size_t c = 1; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = 0.2f * rng.normal();
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(0.15f + 0.1f * rng.uniform());
    *layer.at(Attribute::Opacity, i) = 2 * rng.uniform();
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, i)[c] = 2 * (rng.uniform() - 0.5f);
    for (size_t c = 0; c < layer.width(Attribute::ShRest); ++c) layer.at(Attribute::ShRest, i)[c] = 0.05f * rng.normal();
    for (Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
      std::fill_n(layer.at(a, i), layer.width(a), -6.f);
  }
  return layer;
}

SplatLayer disturbed(SplatLayer layer) {
  Rng rng(6);
  for (float& v : layer.values(Attribute::ShDc)) v += 1.5f * (rng.uniform() - 0.5f);
  for (float& v : layer.values(Attribute::Mean)) v += 0.02f * (rng.uniform() - 0.5f);
  for (size_t i = 0; i < layer.size(); i += kFaint) *layer.at(Attribute::Opacity, i) = -5.5f;  // faint: they walk, and are relocated
  return layer;
}

View camera_of(int k) {
  View view;
  view.name = fmt::format("view_{}.png", k);
  view.intrinsics = {kWidth, kHeight, kWidth, kWidth, 0.5 * kWidth, 0.5 * kHeight};
  const double x = 0.3 * (k - 1.5);
  view.cam_from_world = {.rotation = Mat3d::identity(), .translation = {-x, 0, 3}};
  view.gain = k % 2 ? Vec3d{1.1, 1, 0.9} : Vec3d{1, 1, 1};
  return view;
}

ImageOptions image_options() {
  ImageOptions image;
  image.diffuse.sh_degree = 1;
  image.diffuse.near_z = kNear;
  return image;
}

Capture photographed(const SplatLayer& truth) {
  Capture capture;
  const LayeredModel model(image_options());
  const SplatScene scene{.diffuse = truth};
  Frame frame;
  for (int k = 0; k < kPhotos; ++k) {
    const View view = camera_of(k);
    model.forward(scene, view, frame);
    PhotoPyramid& photo = capture.photos.emplace_back();
    for (PhotoLevel& level : photo.levels) {
      level.view = view;
      for (const float v : frame.srgb) level.srgb.push_back(static_cast<uint16_t>(std::lround(v * 65535)));
    }
    capture.view_set.views.push_back(view);
    capture.train.push_back(static_cast<uint32_t>(k));
  }
  return capture;
}

// All masks, and normals: a wall that faces the camera.
TargetLevel some_targets(int k) {
  TargetLevel t;
  const auto mask = [&](MaskClass m) -> std::vector<uint8_t>& { return t.masks[static_cast<size_t>(m)]; };
  for (MaskClass m : kMaskClasses) mask(m).assign(kPixels, m == MaskClass::Object ? 255 : 0);
  t.coat.assign(kPixels, 0);
  for (size_t i = 0; i < kPixels; ++i) {
    const int x = int(i) % kWidth, y = int(i) / kWidth;
    if (x < 6 + k) mask(MaskClass::Ignore)[i] = 255;
    if (y < 4) mask(MaskClass::Object)[i] = 100;
    if (x > 20 && x < 30) mask(MaskClass::Specular)[i] = 200;
    if (x > 25 && x < 30) mask(MaskClass::Transparent)[i] = 255;
    if (y > 26) t.coat[i] = 255;
  }
  t.normals.assign(3 * kPixels, 0);
  std::fill_n(t.normals.begin() + 2 * kPixels, kPixels, int16_t{-32767});
  t.confidence.assign(kPixels, 180);
  return t;
}

struct Plans {
  uint64_t unknown_from = 0, unknown_until = 0;  // steps that only the CPU knows
  bool masks = false, withheld = false;
  float rate = 1;
};

class TinyTraining : public Training {
 public:
  TinyTraining(const TrainingDesc& desc, const Plans& plans, SplatLayer start)
      : Training(desc, image_options(), {.diffuse = std::move(start)}), plans_(plans) {}
  std::string bytes() {
    Archive archive;
    transfer(archive);
    return archive.bytes();
  }
  std::string digest() { return digest_bytes(bytes()).short_hex(); }
  void read(const std::string& bytes) {
    Archive archive(bytes);
    transfer(archive);
  }

 private:
  StepPlan plan() override {
    StepPlan plan{.fraction = fraction(), .image = image_options(), .rarest = 2};
    plan.image.diffuse.materials = step_index() >= plans_.unknown_from && step_index() < plans_.unknown_until;
    plan.rates[0] = rates_at({}, fraction(), kSceneRadius);
    for (float& rate : plan.rates[0]) rate *= plans_.rate;
    if (plans_.masks) plan.specular_weight = 0.3f;
    if (plans_.withheld) plan.withheld = withheld_;
    return plan;
  }
  void end_step() override {
    DensifyConfig densify;
    densify.growth = 1.1;
    move(LayerKind::Diffuse, densify,
         {.moment = {.seed = 3, .step = step_index(), .cap = kCap},
          .now = step_index() % 8 == 0 && pictures(LayerKind::Diffuse) >= kPhotos,
          .noise = 3.f});
  }
  Plans plans_;
  std::vector<uint8_t> withheld_{1, 0, 1, 0};
};

class DeviceTraining : public ::testing::Test {
 protected:
  DeviceTraining() : capture_(photographed(photographed_surfels())) {
    targets_.photos.resize(kPhotos);
    masked_.photos.resize(kPhotos);
    for (int k = 0; k < kPhotos; ++k) masked_.photos[size_t(k)].fill(some_targets(k));
    CountingLoops::shuffle_seed = 0;
    CountingLoops::memory = ~size_t{0};
    CountingLoops::copies = {};
    provide_device(
        []() -> std::unique_ptr<blocks::BlockPass> { return std::make_unique<blocks::ExecutorPass<BlockLoops>>(BlockLoops()); });
    provide_step_device([]() -> std::unique_ptr<blocks::StepPass> {
      return std::make_unique<blocks::StepBlocks<CountingLoops>>(CountingLoops());
    });
    use_device(Device::Cuda);
  }
  ~DeviceTraining() override {
    use_device(Device::Cpu);
    provide_device(before_);
    provide_step_device(steps_before_);
  }
  std::unique_ptr<TinyTraining> training(uint64_t steps, const Plans& plans = {}) {
    return training(steps, plans, disturbed(photographed_surfels()));
  }
  std::unique_ptr<TinyTraining> training(uint64_t steps, const Plans& plans, SplatLayer start) {
    return std::make_unique<TinyTraining>(
        TrainingDesc{
            .capture = capture_, .targets = plans.masks ? masked_ : targets_, .losses = losses_, .steps = steps, .remedy = {}},
        plans, std::move(start));
  }
  static void run(TinyTraining& training) {
    while (!training.finished()) training.step();
  }
  std::string digest_after(uint64_t steps, const Plans& plans = {}) {
    const auto t = training(steps, plans);
    run(*t);
    return t->digest();
  }
  // PSNR of the photos, dB, rendered on the CPU.
  double psnr(const TinyTraining& training) {
    use_device(Device::Cpu);
    const LayeredModel model(image_options());
    use_device(Device::Cuda);
    Frame frame;
    double sum = 0;
    for (const PhotoPyramid& photo : capture_.photos) {
      model.forward(training.scene(), photo.levels[0].view, frame);
      for (size_t i = 0; i < frame.srgb.size(); ++i) {
        const double off = double(frame.srgb[i]) - photo.levels[0].srgb[i] / 65535.0;
        sum += off * off / (double(frame.srgb.size()) * kPhotos);
      }
    }
    return -10 * std::log10(sum);
  }

  Capture capture_;
  Targets targets_, masked_;
  LossSet losses_;

 private:
  DevicePassMaker before_ = provide_device(nullptr);
  StepPassMaker steps_before_ = provide_step_device(nullptr);
};

TEST_F(DeviceTraining, LearnsAsTheCpu) {
  constexpr uint64_t kSteps = 36;
  constexpr double kClose = 0.01;
  for (const bool masks : {false, true}) {
    SCOPED_TRACE(masks);
    const auto device = training(kSteps, {.masks = masks, .withheld = masks});
    const double before = psnr(*device);
    run(*device);
    EXPECT_GT(CountingLoops::copies.up, 0u) << "the device was not used";
    use_device(Device::Cpu);
    const auto cpu = training(kSteps, {.masks = masks, .withheld = masks});
    run(*cpu);
    use_device(Device::Cuda);
    ASSERT_EQ(device->epochs().size(), cpu->epochs().size());
    for (size_t e = 0; e < cpu->epochs().size(); ++e) {
      const EpochRecord &there = device->epochs()[e], &here = cpu->epochs()[e];
      EXPECT_EQ(there.step, here.step);
      EXPECT_EQ(there.surfels, here.surfels);
      EXPECT_NEAR(there.loss, here.loss, kClose * here.loss) << e;
      EXPECT_NEAR(there.l1, here.l1, kClose * here.l1) << e;
    }
    EXPECT_NEAR(device->recent_loss(), cpu->recent_loss(), kClose * cpu->recent_loss());
    EXPECT_EQ(device->scene().diffuse.size(), kCap);
    EXPECT_GT(device->counts(LayerKind::Diffuse).relocated, 0u);
    EXPECT_GT(psnr(*cpu), before + 3);
    EXPECT_NEAR(psnr(*device), psnr(*cpu), 0.2);
  }
}

TEST_F(DeviceTraining, TheFirstStepHasTheLossOfTheCpu) {
  for (const bool masks : {false, true}) {
    double loss[2];
    for (const int on_device : {0, 1}) {
      use_device(on_device ? Device::Cuda : Device::Cpu);
      const auto t = training(1, {.masks = masks, .withheld = masks});
      run(*t);
      loss[on_device] = t->recent_loss();
    }
    EXPECT_NEAR(loss[1], loss[0], 1e-5 * loss[0]) << masks;
  }
}

// Without rates only the random walk moves surfels, the faint ones.
TEST_F(DeviceTraining, FaintSurfelsWalkAsOnTheCpu) {
  constexpr int kSteps = 5;
  std::vector<float> moved[2];
  const SplatLayer start = disturbed(photographed_surfels());
  for (const int on_device : {0, 1}) {
    use_device(on_device ? Device::Cuda : Device::Cpu);
    const auto t = training(kSteps, {.rate = 0});
    run(*t);
    const SplatLayer& end = t->scene().diffuse;
    for (size_t i = 0; i < kSurfels; ++i) {
      moved[on_device].push_back(end.at(Attribute::Mean, i)[0] - start.at(Attribute::Mean, i)[0]);
      EXPECT_EQ(end.at(Attribute::ShDc, i)[1], start.at(Attribute::ShDc, i)[1]);
    }
  }
  for (size_t i = 0; i < kSurfels; ++i) {
    EXPECT_NEAR(moved[1][i], moved[0][i], 1e-4) << i;
    if (i % kFaint == 0) {
      EXPECT_GT(std::abs(moved[0][i]), 0.01) << i;
    }
  }
}

TEST_F(DeviceTraining, BytesDependOnNoOrder) {
  const Plans plans{.masks = true, .withheld = true};
  const std::string in_order = digest_after(17, plans);
  CountingLoops::shuffle_seed = 4;
  EXPECT_EQ(digest_after(17, plans), in_order);
}

TEST_F(DeviceTraining, AnInterruptedRunEndsWithTheSameBytes) {
  const std::string whole = digest_after(14);
  for (const uint64_t at : {7, 8, 12}) {
    const auto first = training(14);
    while (first->step_index() < at) first->step();
    const std::string saved = first->bytes();
    const auto second = training(14, {}, SplatLayer(LayerKind::Diffuse, 1, 0));
    second->read(saved);
    run(*second);
    EXPECT_EQ(second->digest(), whole) << at;
    run(*first);
    EXPECT_EQ(first->digest(), whole) << at;
  }
}

TEST_F(DeviceTraining, StepsThatTheKernelsDoNotKnowRunOnTheCpu) {
  const Plans plans{.unknown_from = 10, .unknown_until = 14};
  const auto mixed = training(24, plans);
  run(*mixed);
  const auto pure = training(24);
  run(*pure);
  EXPECT_NE(mixed->digest(), pure->digest());
  EXPECT_EQ(mixed->epochs().size(), 6u);
  EXPECT_NEAR(mixed->epochs().back().loss, pure->epochs().back().loss, 0.01 * pure->epochs().back().loss);
  EXPECT_NEAR(psnr(*mixed), psnr(*pure), 0.2);
  EXPECT_EQ(digest_after(24, plans), mixed->digest());
}

TEST_F(DeviceTraining, NoSurfelsTravelFromStepToStep) {
  const auto t = training(20);
  while (t->step_index() < 9) t->step();  // all photos are there, and a relocation is done
  CountingLoops::copies = {};
  while (t->step_index() < 14) t->step();
  EXPECT_EQ(t->surfels(LayerKind::Diffuse), 111u);
  EXPECT_EQ(CountingLoops::copies.up, 0u);
  EXPECT_LE(CountingLoops::copies.largest, 128u) << "bytes: more than the losses came back";
  EXPECT_EQ(CountingLoops::copies.down, 5u);

  EXPECT_EQ(t->scene().diffuse.size(), 111u);
  EXPECT_GT(CountingLoops::copies.largest, 4 * kSurfels) << "reading the scene brings it back";
  const size_t down = CountingLoops::copies.down;
  t->scene();
  EXPECT_EQ(CountingLoops::copies.down, down) << "it was there";
  t->step();
  EXPECT_EQ(CountingLoops::copies.up, 0u) << "and need not be sent again";
}

TEST_F(DeviceTraining, PhotosThatDoNotFitAreCopiedForEachStep) {
  const Plans plans{.masks = true};
  const std::string all = digest_after(12, plans);
  CountingLoops::memory = 2 * 25 * kPixels;  // for one photo of 18 bytes a pixel
  const auto t = training(12, plans);
  while (t->step_index() < 9) t->step();
  CountingLoops::copies = {};
  while (t->step_index() < 12) t->step();
  EXPECT_GE(CountingLoops::copies.up, 14u);  // of three steps at most one has its photo: eight arrays each
  EXPECT_EQ(t->digest(), all);
}

TEST_F(DeviceTraining, BreaksDownWithTheErrorsOfTheCpu) {
  SplatLayer unseen = photographed_surfels(), poisoned = photographed_surfels();
  for (float& v : unseen.values(Attribute::Opacity)) v = -20;
  for (size_t i = 0; i < poisoned.size(); ++i) poisoned.at(Attribute::ShRest, i)[4] = NAN;
  for (const SplatLayer& start : {unseen, poisoned}) {
    std::string codes[2], places[2], reasons[2];
    for (const int on_device : {0, 1}) {
      use_device(on_device ? Device::Cuda : Device::Cpu);
      const auto t = training(40, {.rate = 0}, start);
      const Error error = error_of([&] { run(*t); });
      codes[on_device] = error.detail().code;
      places[on_device] = error.detail().where;
      reasons[on_device] = error.detail().why;
      EXPECT_EQ(error.kind(), ErrorKind::Diverged);
    }
    EXPECT_EQ(codes[0], codes[1]);
    EXPECT_EQ(places[0], places[1]);
    EXPECT_EQ(reasons[0], reasons[1]);
  }
}

}  // namespace
}  // namespace vitrine
