#include "stages/optimize/trainer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/train/photo_order.h"
#include "core/train/picture_step.h"
#include "stages/optimize/layer_init.h"
#include "stages/optimize/plane_inpainting.h"

namespace vitrine {

namespace {

constexpr double kSceneRadius = 1;   // the sfm stage scales the ring of cameras to it
constexpr double kNoiseScale = 5e5;  // noise per unit of the position's rate (Kheradmand et al. 2024)
constexpr double kRecentLossDecay = 0.02;
// Broken gradients: single ones happen at grazing surfels. A hundredth of all, or pictures without any surfel, ten steps in
// a row, is a failing run.
constexpr double kBadShare = 0.01;
constexpr uint32_t kBadStreak = 10;
// Fewer pictures in a row that show no surfel say nothing of the scene: a photo of the lens cap.
constexpr uint32_t kBlankPictures = 3;

Backend backend_of(const OptimizeConfig& config) { return config.backend == "reference" ? Backend::Reference : Backend::Cpu; }

}  // namespace

Trainer::Trainer(const TrainerSetup& setup, SplatLayer initial, std::vector<ScenePlane> planes, double background)
    : setup_(setup),
      densify_behind_glass_(setup.config.densify),
      model_(clock().image_options(setup.config.shading, backend_of(setup.config), setup.config.sh_degree)),
      scene_{.diffuse = std::move(initial)},
      planes_(std::move(planes)),
      background_(background),
      sheets_(trains_sheets(setup.config, setup.shapes) && setup.layers.transmittance),
      initial_surfels_(scene_.diffuse.size()) {
  // What no training photo shows through the glass may be what the next view shows: it stays where the diffuse layer had it.
  densify_behind_glass_.idle_weight = 0;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance})
    if (setup_.layers.has(kind)) scene_.layer(kind) = SplatLayer(kind, config().phases.of(kind).sh_degree, 0);
  grad_ = scene_.zeros_like();
  for (LayerKind kind : kAllLayers) training_.emplace_back(scene_.layer(kind));
}

// Room is left for hulls until their phases have begun.
size_t Trainer::diffuse_cap() const {
  const size_t all = cap(LayerKind::Diffuse);
  size_t room = 0;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance})
    if (setup_.layers.has(kind) && !begun_[static_cast<size_t>(kind)] && !(sheets_ && kind == LayerKind::Transmittance))
      room += std::min(static_cast<size_t>(config().phases.most_hull_points(kind)), all / 10);
  return all - room;
}

size_t Trainer::cap(const TrainerSetup& setup, LayerKind kind) {
  const auto part = [&](LayerKind k) {
    if (!setup.layers.has(k) || (k == LayerKind::Transmittance && trains_sheets(setup.config, setup.shapes))) return size_t{0};
    return static_cast<size_t>(setup.config.phases.of(k).share * double(setup.max_surfels));
  };
  if (kind != LayerKind::Diffuse) return part(kind);
  return setup.max_surfels - part(LayerKind::Reflection) - part(LayerKind::Transmittance);
}

size_t Trainer::level() const {
  return fraction() < config().resolution.quarter_until ? 2 : fraction() < config().resolution.half_until ? 1 : 0;
}

uint32_t Trainer::photo_of_step() {
  const uint64_t count = setup_.capture.train.size(), epoch = step_ / count;
  if (epoch != order_epoch_) {
    order_ = photo_order(setup_.capture.train, static_cast<uint64_t>(config().seed), epoch);
    order_epoch_ = epoch;
  }
  return order_[step_ % count];
}

void Trainer::step() {
  begin_phases();
  fill_unseen();
  const uint32_t photo = photo_of_step();
  const double loss = descend(photo);
  if (!std::isfinite(loss))
    throw Error(ErrorKind::Diverged, "training broke down: the loss is not a number",
                {.where = fmt::format("step {}, photo {}", step_, setup_.capture.photos[photo].name()),
                 .hint = "lower the rates (--set optimize.rates.mean=8e-5) or change the seed",
                 .code = "LOSS_NOT_FINITE"});
  ++step_;
  move_surfels();
}

// What the surfels can be blamed for: the difference in the displayed picture, a mean over the channels. Returns its mean.
double Trainer::blame(const PhotoLevel& photo) {
  decode(photo, target_);
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

// No loss where the ignore mask says so, nor around an object that is trained alone: what surrounds it did not stand still. Less
// on gloss until there is a layer to explain it; glass counts in full, as most of what it shows stands behind it.
void Trainer::weigh_pixels(const PhaseClock& clock) {
  weight_.clear();
  const auto ignore = target_images_.mask(MaskClass::Ignore), specular = target_images_.mask(MaskClass::Specular);
  if (!ignore.empty()) {
    weight_.resize(ignore.size());
    for (size_t i = 0; i < ignore.size(); ++i) weight_[i] = 1 - ignore[i];
  }
  if (const auto object = target_images_.mask(MaskClass::Object); setup_.object_alone && !object.empty()) {
    weight_.resize(object.size(), 1.f);
    for (size_t i = 0; i < object.size(); ++i) weight_[i] *= object[i];
  }
  const auto inside = static_cast<float>(config().phases.diffuse.specular_weight);
  if (specular.empty() || !setup_.layers.reflection || clock.begun(LayerKind::Reflection) || inside == 1) return;
  weight_.resize(specular.size(), 1.f);
  const auto transparent = target_images_.mask(MaskClass::Transparent);
  for (size_t i = 0; i < specular.size(); ++i) {
    const float gloss = specular[i] * (transparent.empty() ? 1 : 1 - transparent[i]);
    weight_[i] *= 1 + (inside - 1) * gloss;
  }
}

double Trainer::descend(uint32_t photo_index) {
  const size_t l = level();
  const PhotoLevel& photo = setup_.capture.photos[photo_index].levels[l];
  const PhaseClock clock = this->clock();
  const double f = fraction();
  model_.options() = image_options();
  for (const LossTerm& term : config().loss.terms())
    model_.options().diffuse.distortion |= term.factory->name == "distortion" && term.schedule.at(f) > 0;
  decode(setup_.targets.photos[photo_index][l], target_images_);
  weigh_pixels(clock);
  point_at_masks();
  model_.forward(scene_, photo.view, frame_);
  const double l1 = blame(photo);

  const PictureTarget target{.view = &photo.view, .srgb = target_, .weight = weight_, .targets = target_images_.spans()};
  const LossValues values = learn(target, config().loss, f, step_, model_, scene_, frame_, grad_);
  update(clock, photo.view.name);
  record(values.total, l1);
  return values.total;
}

void Trainer::update(const PhaseClock& clock, const std::string& photo) {
  damping_.clear();
  if (begun_[static_cast<size_t>(LayerKind::Transmittance)])
    hold_glass(scene_.diffuse, static_cast<float>(config().phases.transmittance.glass_factor), damping_, frame_.statistics.error,
               grad_.diffuse);
  if (!known_gloss_.empty())
    hold_gloss(scene_.diffuse, known_gloss_, static_cast<float>(config().phases.reflection.known_factor), damping_);
  DescentCounts worst;
  bool blank = false;
  broken_ = false;
  for (LayerKind kind : kAllLayers) {
    const SurfelStatistics& statistics = statistics_of(frame_, kind);
    const bool diffuse = kind == LayerKind::Diffuse;
    if (!took_part(frame_, kind)) continue;
    const std::span<const float> damping = diffuse ? std::span<const float>(damping_) : std::span<const float>();
    const AttributeRates rates = clock.rates(kind, config().rates, kSceneRadius);
    // What is guessed where no photo looks stays as guessed: its rims, which photos do see, would drift off into the gaps.
    const size_t trained = scene_.layer(kind).size() - (diffuse ? unseen_surfels_ : 0);
    const DescentCounts done = training(kind).descend(
        grad_.layer(kind), statistics,
        {.rates = rates, .damping = damping, .rarest = float(config().rates.rarest), .trained = trained}, scene_.layer(kind));
    const bool bad = double(done.skipped) > kBadShare * double(done.active);
    if (bad && !broken_) worst = done;
    broken_ |= bad;
    blank |= diffuse && done.active == 0;
  }
  if (fraction() >= config().phases.reflection.surface_from) shapes_.descend(model_.shape().gradients(), clock.shape_rates());
  if (begun_[static_cast<size_t>(LayerKind::Transmittance)] && config().phases.transmittance.one_glass)
    share_glass(scene_.diffuse);
  bad_streak_ = broken_ || blank ? bad_streak_ + 1 : 0;
  if (bad_streak_ >= kBadStreak)
    throw Error(ErrorKind::Diverged, "training broke down: the surfels are gone or their gradients are not numbers",
                {.where = fmt::format("step {}, photo {}", step_, photo),
                 .why = worst.active == 0 ? fmt::format("{} pictures in a row show no surfel", bad_streak_)
                                          : fmt::format("{} of {} gradients of visible surfels are broken, {} steps in a row",
                                                        worst.skipped, worst.active, bad_streak_),
                 .hint = "lower the rates (--set optimize.rates.mean=8e-5) or change the seed",
                 .code = "GRADIENTS_NOT_FINITE"});
}

bool Trainer::sound() const {
  if (broken_ || bad_streak_ >= kBlankPictures) return false;
  size_t all = 0, broken = 0;
  for (LayerKind kind : kAllLayers) {
    const SplatLayer& layer = scene_.layer(kind);
    std::vector<float> poison(layer.size(), 0.f);  // x * 0 is 0 for numbers alone
    for (const AttributeRow& r : kAttributes)
      for (size_t i = 0, width = layer.width(r.id); width > 0 && i < layer.size(); ++i)
        for (size_t c = 0; c < width; ++c) poison[i] += layer.at(r.id, i)[c] * 0.f;
    all += layer.size();
    broken += layer.size() - static_cast<size_t>(std::count(poison.begin(), poison.end(), 0.f));
  }
  return double(broken) <= kBadShare * double(all);
}

void Trainer::move_surfels() {
  const DensifyConfig& d = config().densify;
  if (d.strategy == "none") return;
  const double f = fraction();
  const PhaseClock clock = this->clock();
  for (LayerKind kind : kAllLayers) {
    const bool first = kind == LayerKind::Diffuse;
    const double from = first ? d.from : config().phases.of(kind).from + d.from;
    const double until = first ? d.until : config().phases.of(kind).densify_until;
    if (!begun_[static_cast<size_t>(kind)] || f < from || f > until) continue;
    const auto seed = static_cast<uint64_t>(config().seed);
    const float rate = clock.rates(kind, config().rates, kSceneRadius)[static_cast<size_t>(Attribute::Mean)];
    const size_t gone = kind == LayerKind::Transmittance ? from_behind_glass_ : 0;
    const DensifyRhythm rhythm = densify_rhythm(d, setup_.capture.train.size(), (until - from) * config().iterations);
    training(kind).move(kind == LayerKind::Transmittance ? densify_behind_glass_ : d,
                        {.moment = {.seed = first ? seed : mix64(seed, static_cast<uint64_t>(kind)),
                                    .step = step_,
                                    .cap = first ? diffuse_cap() : cap(kind) - gone,
                                    .times = rhythm.times,
                                    .scene_radius = kSceneRadius},
                         .now = step_ % rhythm.interval == 0 && training(kind).pictures() >= rhythm.pictures,
                         .noise = static_cast<float>(d.noise * kNoiseScale * rate)},
                        scene_.layer(kind));
    grad_.layer(kind).resize(scene_.layer(kind).size());
  }
}

LayerInitDesc Trainer::init_desc() const {
  return {.config = config(),
          .capture = setup_.capture,
          .targets = setup_.targets,
          .shapes = setup_.shapes,
          .glass = setup_.glass,
          .sh_degree = sh_degree()};
}

void Trainer::begin_sheets() {
  ShapeSet sheets = known_sheets(init_desc(), scene_);
  log_info("step {}: {} sheets of glass begin", step_, sheets.entries.size());
  shapes_.add(std::move(sheets));
}

void Trainer::finish() {
  if (!sheets_ || !begun_[static_cast<size_t>(LayerKind::Transmittance)] || glass_surfels_ > 0) return;
  const HullCounts counts = begin_transmittance(init_desc(), SIZE_MAX, SIZE_MAX, scene_);
  glass_surfels_ = counts.hull;
  log_info("{} surfels carry the glass; {} that are seen through it alone are the transmittance layer", counts.hull,
           counts.moved);
}

// A layer begins with what the diffuse layer knows at that moment.
void Trainer::begin_phases() {
  const PhaseClock clock = this->clock();
  const LayerInitDesc desc = init_desc();
  bool changed = false;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance}) {
    uint8_t& begun = begun_[static_cast<size_t>(kind)];
    if (begun || !clock.begun(kind)) continue;
    begun = 1;
    if (sheets_ && kind == LayerKind::Transmittance) {
      begin_sheets();
      continue;
    }
    changed = true;
    const auto begin = kind == LayerKind::Reflection ? begin_reflection : begin_transmittance;
    const HullCounts counts = begin(desc, cap(kind), diffuse_cap(), scene_);
    log_info("step {}: the {} layer begins with {} surfels; {} were put on the hull of its masks, {} moved from there", step_,
             name(kind), scene_.layer(kind).size(), counts.hull, counts.moved);
    if (kind == LayerKind::Reflection && !counts.known_points.empty())
      known_gloss_ = KnownSurface(counts.known_points, counts.known_reach);
    ShapeSet known = counts.shapes;
    if (!config().shading.shapes) known = known.without(ShapeRole::Mirror).without(ShapeRole::Coat);
    if (!config().shading.panes) known = known.without(ShapeRole::Sheet);
    shapes_.add(std::move(known));
    training(kind).restart(scene_.layer(kind));
  }
  if (!changed) return;
  training(LayerKind::Diffuse).restart(scene_.diffuse);  // other surfels, other attributes
  grad_ = scene_.zeros_like();
}

// When surfels are no longer moved, which would take away those that no photo needs, nor handed to other layers.
void Trainer::fill_unseen() {
  if (!config().fill_unseen || setup_.object_alone || filled_ || fraction() < config().densify.until) return;
  for (LayerKind kind : {LayerKind::Reflection, LayerKind::Transmittance})
    if (setup_.layers.has(kind) && !begun_[static_cast<size_t>(kind)]) return;
  filled_ = 1;
  const bool thin_glass = config().shading.glass == "thin" && setup_.layers.transmittance;
  if (thin_glass && !sheets_) fill_beside_glass();
  const SplatLayer unseen = inpainted_planes(thin_glass ? seen_through_glass(scene_) : scene_.diffuse, setup_.capture, planes_,
                                             background_, size_t(kMostUnseen * double(setup_.max_surfels)));
  scene_.diffuse = joined(scene_.diffuse, unseen);
  unseen_surfels_ = unseen.size();
  training(LayerKind::Diffuse).grow(scene_.diffuse.size());
  grad_.diffuse.resize(scene_.diffuse.size());
  log_info("step {}: {} surfels close gaps of the surroundings that no photo shows; their colours are guessed", step_,
           unseen_surfels_);
}

void Trainer::fill_beside_glass() {
  const size_t before = scene_.transmittance.size();
  const std::vector<uint32_t> stay = bring_out_from_behind_glass(setup_.capture, planes_, scene_);
  from_behind_glass_ = before - stay.size();
  if (from_behind_glass_ == 0) return;
  training(LayerKind::Transmittance).keep_only(stay);
  grad_.transmittance.resize(stay.size());
  training(LayerKind::Diffuse).grow(scene_.diffuse.size());
  grad_.diffuse.resize(scene_.diffuse.size());
  log_info("step {}: {} surfels of walls that photos show through glass alone close gaps beside the glass", step_,
           from_behind_glass_);
}

void Trainer::record(double loss, double l1) {
  recent_loss_ = step_ == 0 ? loss : recent_loss_ + kRecentLossDecay * (loss - recent_loss_);
  const double count = double(setup_.capture.train.size());
  epoch_.loss += loss / count;
  epoch_.l1 += l1 / count;
  if ((step_ + 1) % setup_.capture.train.size() != 0) return;
  epoch_.step = step_ + 1;
  epoch_.surfels = scene_.diffuse.size();
  epochs_.push_back(epoch_);
  epoch_ = {};
}

ImageOptions Trainer::image_options() const {
  ImageOptions options = clock().image_options(config().shading, backend_of(config()), sh_degree());
  options.diffuse.near_z = setup_.capture.near_z;
  options.shape.set = shapes_.set();
  if (filled_) options.panes.mirrored = scene_.diffuse.size() - unseen_surfels_ - glass_surfels_;
  return options;
}

// Masks ask for rays; those of glass only when there is a layer behind it. Sheets ask by themselves.
void Trainer::point_at_masks() {
  frame_.seed = static_cast<uint64_t>(config().seed);
  frame_.step = step_;
  frame_.specular_mask = target_images_.mask(MaskClass::Specular);
  frame_.transparent_mask = {};
  const auto transparent = target_images_.mask(MaskClass::Transparent);
  if (begun_[static_cast<size_t>(LayerKind::Transmittance)] && !sheets_) {
    frame_.transparent_mask = transparent;
  } else if (!transparent.empty() && !frame_.specular_mask.empty()) {
    gloss_.assign(frame_.specular_mask.begin(), frame_.specular_mask.end());
    for (size_t i = 0; i < gloss_.size(); ++i) gloss_[i] *= 1 - transparent[i];
    frame_.specular_mask = gloss_;
  }
  if (target_images_.coat.empty()) return;
  if (gloss_.data() != frame_.specular_mask.data()) gloss_.assign(frame_.specular_mask.begin(), frame_.specular_mask.end());
  for (size_t i = 0; i < gloss_.size(); ++i) gloss_[i] = std::max(gloss_[i], target_images_.coat[i]);
  frame_.specular_mask = gloss_;
}

void Trainer::picture(uint32_t photo, bool layers, Frame& frame) const {
  ImageOptions options = image_options();
  options.surface.ray_budget = 0;
  options.composite.layer_images = layers;
  model_.forward(scene_, setup_.capture.photos[photo].levels[0].view, options, frame);
}

}  // namespace vitrine
