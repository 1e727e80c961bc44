#include "core/learn/trainer/training.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/checkpoint.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/learn/trainer/frozen_surfels.h"

namespace vitrine {

namespace {

constexpr double kRecentLossDecay = 0.02;
// Non-finite gradients: single ones occur at grazing surfels. If they exceed 1 % of all, or pictures contain no surfel, for ten
// consecutive steps, the run fails.
constexpr double kBadShare = 0.01;
constexpr uint32_t kBadStreak = 10;
// Fewer consecutive pictures without a surfel are tolerated: for example a photo of the lens cap.
constexpr uint32_t kBlankPictures = 3;

bool is_broken(const DescentCounts& done) { return double(done.skipped) > kBadShare * double(done.active); }

// Steps of align(), and how their size falls: from 0.06 degrees to 0.002.
constexpr int kAlignSteps = 60;
constexpr double kAlignRate = 1e-3, kAlignDecay = 0.03;

LossRays loss_rays(const SecondaryRays& rays) {
  return {.first_hit = rays.values.first_hit,
          .mean_distance = rays.mean_distance,
          .alpha = rays.alpha,
          .wall = {},
          .weight = rays.weight};
}

// Statistics of the last backward: sums over all passes that render surfels of the layer. nullptr: none did.
const SurfelStatistics* statistics_of(const Frame& frame, LayerKind kind) {
  if (kind == LayerKind::Diffuse) return &frame.statistics;
  const SecondaryRays& rays = kind == LayerKind::Reflection ? frame.reflection : frame.transmission;
  return rays.took_part ? &rays.statistics : nullptr;
}

std::vector<View> cameras_of(const Capture& capture) {
  std::vector<View> views;
  for (const PhotoPyramid& photo : capture.photos) views.push_back(photo.levels[0].view);
  return views;
}

}  // namespace

Training::Training(const TrainingDesc& desc, const ImageOptions& image, SplatScene start)
    : model_(image), poses_(cameras_of(desc.capture)), desc_(desc), state_(std::move(start)) {}

void Training::step() {
  const StepPlan plan = this->plan();
  const std::vector<uint32_t>& photos = desc_.capture.train;
  const uint32_t photo = photo_order(photos, desc_.seed, step_ / photos.size())[step_ % photos.size()];
  if (device_knows(plan, desc_.losses, step_, state_)) {
    step_on_device(plan, photo);
  } else {
    settle();
    const double loss = look(plan, photo);
    check_loss(loss, step_, view_.name);
    if (plan.pose_rates.turn > 0) poses_.descend(photo, pose_gradient_of(plan), plan.pose_rates);
    update(plan);
    record(step_, surfels(LayerKind::Diffuse), loss, l1_);
  }
  ++step_;
  end_step();
  if (finished()) settle();
}

void Training::step_on_device(const StepPlan& plan, uint32_t photo) {
  const PhotoLevel& level = desc_.capture.photos[photo].levels[plan.level];
  view_ = level.view;
  view_.cam_from_world = poses_.pose(photo);
  settle(state_.step(device_step(plan, desc_.losses, state_, view_, is_withheld(plan, photo)),
                     device_photo(photo, plan.level, level, desc_.targets.photos[photo][plan.level])));
  unsettled_ = {step_, surfels(LayerKind::Diffuse), view_.name};
}

// What update() and record() do, for a step of the device.
void Training::settle(const std::optional<blocks::StepReport>& report) {
  if (!report) return;
  check_loss(report->loss, unsettled_.step, unsettled_.photo);
  const DescentCounts done{report->active, report->skipped};
  state_.count_skipped(done.skipped);
  check_descent({done, is_broken(done), done.active == 0}, unsettled_.step, unsettled_.photo);
  record(unsettled_.step, unsettled_.surfels, report->loss, report->l1);
}

void Training::check_loss(double loss, uint64_t step, const std::string& photo) const {
  if (!std::isfinite(loss))
    throw Error(ErrorKind::Diverged, "training broke down: the loss is not a number",
                {.where = fmt::format("step {}, photo {}", step, photo), .hint = desc_.remedy, .code = "LOSS_NOT_FINITE"});
}

void Training::move(LayerKind kind, const DensifyConfig& config, const LayerTraining::Move& move) {
  const bool divides = config.strategy == DensifyStrategy::Divide;
  if (kind == LayerKind::Diffuse && state_.on_device() && divides) {
    state_.move(config, move);
  } else if (divides || move.now) {
    LayerTraining& layer = training(kind);
    layer.move(config, move, scene_to_change().layer(kind));
  }
}

PoseGradient Training::pose_gradient_of(const StepPlan& plan) const {
  return pose_gradient(scene().diffuse, grad_.diffuse, view_.cam_from_world, plan.image.diffuse.sh_degree);
}

void Training::align(uint32_t photo) {
  const StepPlan plan = this->plan();
  PoseTraining kept = poses_;
  poses_.restart();
  for (int step = 0; step < kAlignSteps; ++step) {
    look(plan, photo);
    const double rate = kAlignRate * std::pow(kAlignDecay, double(step) / kAlignSteps);
    poses_.descend(photo, pose_gradient_of(plan), {.turn = rate, .shift = rate * kSceneRadius});
  }
  kept.set(photo, poses_.pose(photo));
  poses_ = std::move(kept);
}

// Picture of the photo's camera, its loss and the gradient of the scene.
double Training::look(const StepPlan& plan, uint32_t photo) {
  const PhotoLevel& level = desc_.capture.photos[photo].levels[plan.level];
  view_ = level.view;
  view_.cam_from_world = poses_.pose(photo);
  model_.options() = plan.image;
  for (const LossTerm& term : desc_.losses.terms())
    model_.options().diffuse.distortion |= term.factory->name == "distortion" && term.schedule.at(plan.fraction) > 0;
  decode(level, target_);
  decode(desc_.targets.photos[photo][plan.level], images_);
  weigh_pixels(plan.specular_weight, is_withheld(plan, photo));
  choose_ray_pixels(plan);
  model_.forward(scene(), view_, frame_);
  raise_clipped(frame_.srgb, target_);
  l1_ = write_error_image();
  return learn(plan, view_);
}

// Weight zero in the ignore mask, and around an object that is trained alone: its surroundings moved during capture. Reduced
// weight on mirrors until a layer explains them; glass has full weight, as most of its content is behind it.
void Training::weigh_pixels(float specular_weight, bool withheld) {
  const auto ignore = images_.mask(MaskClass::Ignore), object = images_.mask(MaskClass::Object);
  const auto specular = images_.mask(MaskClass::Specular), transparent = images_.mask(MaskClass::Transparent);
  weight_.clear();
  const auto weigh = [&](std::span<const float> mask, const auto& weight_at) {
    if (!mask.empty()) weight_.resize(mask.size(), 1.f);
    for (size_t i = 0; i < mask.size(); ++i) weight_[i] *= weight_at(i);
  };
  weigh(ignore, [&](size_t i) { return 1 - ignore[i]; });
  weigh(object, [&](size_t i) { return object[i]; });
  if (withheld)
    for (const std::span<const float> mask : {specular, transparent, std::span<const float>(images_.coat)})
      weigh(mask, [&](size_t i) { return 1 - mask[i]; });
  if (specular_weight == 1) return;
  weigh(specular,
        [&](size_t i) { return 1 + (specular_weight - 1) * (specular[i] * (transparent.empty() ? 1 : 1 - transparent[i])); });
}

void Training::choose_ray_pixels(const StepPlan& plan) {
  const auto specular = images_.mask(MaskClass::Specular), transparent = images_.mask(MaskClass::Transparent);
  reflects_.assign(specular.begin(), specular.end());
  for (size_t i = 0; i < reflects_.size(); ++i) {
    if (!plan.glass_sends_rays && !transparent.empty()) reflects_[i] *= 1 - transparent[i];
    if (plan.coats_send_rays && !images_.coat.empty()) reflects_[i] = std::max(reflects_[i], images_.coat[i]);
  }
  frame_.seed = desc_.seed;
  frame_.step = step_;
  frame_.specular_mask = reflects_;
  frame_.transparent_mask = plan.glass_sends_rays ? transparent : std::span<const float>();
}

// Writes the weighted difference of the displayed picture, a mean over the channels. Returns its unweighted mean.
double Training::write_error_image() {
  const size_t pixels = frame_.pixel_count();
  frame_.error_image.resize(pixels);
  constexpr size_t kChunk = 1 << 14;
  std::vector<double> sums(chunk_count(pixels, kChunk));
  parallel_chunks(pixels, kChunk, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      frame_.error_image[i] = (std::abs(frame_.srgb[i] - target_[i]) + std::abs(frame_.srgb[pixels + i] - target_[pixels + i]) +
                               std::abs(frame_.srgb[2 * pixels + i] - target_[2 * pixels + i])) /
                              3.f;
    for (size_t i = begin; i < end; ++i) sums[chunk] += frame_.error_image[i];
    for (size_t i = begin; i < end && !weight_.empty(); ++i) frame_.error_image[i] *= weight_[i];
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0) / double(pixels);
}

// Evaluates the losses of a frame after forward; `grad_` becomes their gradient.
double Training::learn(const StepPlan& plan, const View& view) {
  const SplatScene& scene = this->scene();
  for (LayerKind kind : kAllLayers) {
    const SplatLayer& layer = scene.layer(kind);
    SplatLayer& grad = grad_.layer(kind);
    if (grad.size() != layer.size() || grad.sh_degree() != layer.sh_degree()) grad = layer.zeros_like();
    grad.fill(0.f);
  }
  const LossInput input{.view = &view,
                        .raster = &frame_.diffuse,
                        .prediction_srgb = frame_.srgb,
                        .target_srgb = target_,
                        .weight = weight_,
                        .diffuse = &scene.diffuse,
                        .targets = images_.spans(),
                        .step = step_,
                        .reflection = loss_rays(frame_.reflection),
                        .transmission = loss_rays(frame_.transmission)};
  LossGradient gradient{.raster = &frame_.grad_diffuse,
                        .prediction_srgb = frame_.grad_srgb,
                        .diffuse = &grad_.diffuse,
                        .reflection_first_hit = frame_.reflection.gradients.first_hit,
                        .transmission_first_hit = frame_.transmission.gradients.first_hit};
  const LossValues values = desc_.losses.evaluate(plan.fraction, input, gradient);
  model_.backward(scene, frame_, grad_);
  return values.total;
}

void Training::update(const StepPlan& plan) {
  SplatScene& scene = scene_to_change();
  damping_.clear();
  if (plan.glass_factor) freeze_glass(scene.diffuse, *plan.glass_factor, damping_, frame_.statistics.error, grad_.diffuse);
  if (plan.known_mirrors) freeze_mirrors(scene.diffuse, *plan.known_mirrors, plan.mirror_factor, damping_);
  Descended all;
  for (LayerKind kind : kAllLayers) {
    const SurfelStatistics* const statistics = statistics_of(frame_, kind);
    if (!statistics) continue;
    const bool diffuse = kind == LayerKind::Diffuse;
    const DescentCounts done =
        training(kind).descend(grad_.layer(kind), *statistics,
                               {.rates = plan.rates[static_cast<size_t>(kind)],
                                .damping = diffuse ? std::span<const float>(damping_) : std::span<const float>(),
                                .rarest = plan.rarest,
                                .trained = scene.layer(kind).size() - (diffuse ? plan.untrained : 0)},
                               scene.layer(kind));
    const bool bad = is_broken(done);
    if (bad && !all.broken) all.worst = done;
    all.broken |= bad;
    all.blank |= diffuse && done.active == 0;
  }
  if (plan.shapes) plan.shapes->descend(model_.shape().gradients(), plan.shape_rates);
  if (plan.medium) plan.medium->descend(model_.medium().gradient(), plan.medium_rate);
  if (plan.one_glass) share_glass(scene.diffuse);
  check_descent(all, step_, frame_.view->name);
}

void Training::check_descent(const Descended& done, uint64_t step, const std::string& photo) {
  const DescentCounts& worst = done.worst;
  broken_ = done.broken;
  bad_streak_ = done.broken || done.blank ? bad_streak_ + 1 : 0;
  if (bad_streak_ >= kBadStreak)
    throw Error(ErrorKind::Diverged, "training broke down: the surfels are gone or their gradients are not numbers",
                {.where = fmt::format("step {}, photo {}", step, photo),
                 .why = worst.active == 0 ? fmt::format("{} pictures in a row show no surfel", bad_streak_)
                                          : fmt::format("{} of {} gradients of visible surfels are broken, {} steps in a row",
                                                        worst.skipped, worst.active, bad_streak_),
                 .hint = desc_.remedy,
                 .code = "GRADIENTS_NOT_FINITE"});
}

bool Training::sound() const {
  if (broken_ || bad_streak_ >= kBlankPictures) return false;
  size_t all = 0, broken = 0;
  for (LayerKind kind : kAllLayers) {
    const SplatLayer& layer = scene().layer(kind);
    std::vector<float> poison(layer.size(), 0.f);  // x * 0 is 0 only for finite numbers
    for (const AttributeRow& r : kAttributes)
      for (size_t i = 0, width = layer.width(r.id); width > 0 && i < layer.size(); ++i)
        for (size_t c = 0; c < width; ++c) poison[i] += layer.at(r.id, i)[c] * 0.f;
    all += layer.size();
    broken += layer.size() - static_cast<size_t>(std::count(poison.begin(), poison.end(), 0.f));
  }
  return double(broken) <= kBadShare * double(all);
}

void Training::record(uint64_t step, size_t surfels, double loss, double l1) {
  recent_loss_ = step == 0 ? loss : recent_loss_ + kRecentLossDecay * (loss - recent_loss_);
  const size_t photos = desc_.capture.train.size();
  epoch_.loss += loss / double(photos);
  epoch_.l1 += l1 / double(photos);
  if ((step + 1) % photos != 0) return;
  epoch_.step = step + 1;
  epoch_.surfels = surfels;
  epochs_.push_back(epoch_);
  epoch_ = {};
}

void Training::run(const Run& run) {
  const auto keep = [&] {
    settle();
    const bool worth = sound();
    if (worth) {
      Archive state;
      transfer(state);
      write_checkpoint(run.checkpoint, state.bytes());
      run.after_checkpoint();
    } else {
      log_info("step {}: surfels are gone or no numbers; the checkpoint before it stays", step_);
    }
    return worth;
  };
  while (!finished()) {
    if (interrupt_signal() != 0) {
      if (keep()) log_info("checkpoint saved (step {})", step_);
      throw_if_interrupted();
    }
    step();
    run.after_step();
    const auto every = static_cast<uint64_t>(run.checkpoint_every);
    if (finished() || (every > 0 && step_ % every == 0)) keep();
  }
}

bool Training::resume(const std::filesystem::path& checkpoint, const std::function<void(const std::string&)>& damaged) {
  try {
    const std::optional<std::string> state = read_checkpoint(checkpoint);
    if (!state) return false;
    Archive archive(*state);
    transfer(archive);
    if (!archive.at_end()) archive.fail();
  } catch (const Error& error) {
    damaged(error.what());
    return false;
  }
  log_info("continues at step {}", step_);
  return true;
}

void Training::transfer(Archive& archive) {
  settle();
  archive.value(step_);
  archive.value(bad_streak_);
  archive.value(recent_loss_);
  archive.value(epoch_);
  archive.array(epochs_);
  state_.transfer(archive);
}

}  // namespace vitrine
