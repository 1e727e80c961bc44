#include "stages/sfm/feature_masks.h"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/describe.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

namespace {

constexpr uint8_t bit(MaskClass kind) { return uint8_t(1u << unsigned(kind)); }
constexpr float kInside = 0.5f;

FeatureMaskUse use_of(const FeatureMasksConfig& c, MaskClass kind) {
  const FeatureMaskUse uses[] = {c.object, c.transparent, c.specular, c.ignore};
  return uses[size_t(kind)];
}

// Logs how many features each class removed.
void log_mask_effect(const MaskEffect& effect) {
  std::string classes;
  for (MaskClass kind : kMaskClasses)
    if (effect.photos[size_t(kind)] > 0)
      classes += fmt::format("{} {} {}", classes.empty() ? ":" : ",", name(kind), effect.removed[size_t(kind)]);
  log_info("sfm: masks keep {} of {} features out{}", effect.before - effect.after, effect.before, classes);
  if (effect.evidence)
    log_info("sfm: {}: {}", effect.object_applied ? "a turntable, the object's masks apply" : "no turntable",
             effect.evidence->why);
}

}  // namespace

void describe(Describer& d, FeatureMasksConfig& c) {
  d.choice("flat", c.flat, kMaskClassWords, "Class of mask files that do not lie in a folder called like a class.");
  const auto use = [&](const char* key, FeatureMaskUse& value, const char* doc) {
    d.choice(key, value, {"auto", "white", "black", "off"}, doc);
  };
  use("object", c.object,
      "On a turntable features outside are not used. What belongs to the class in files: white, black, or white after a "
      "check that this can be (auto); off: these masks are not used here.");
  use("transparent", c.transparent, "Features inside are not used; words as above.");
  use("specular", c.specular, "Features inside are not used; words as above.");
  use("ignore", c.ignore, "Features inside are not used; words as above.");
}

FeatureMasks::FeatureMasks(const std::filesystem::path& folder, const FeatureMasksConfig& config, Turntable turntable,
                           const std::vector<SfmPhoto>& photos)
    : turntable_(turntable) {
  std::vector<std::string> names;
  for (const SfmPhoto& p : photos) {
    names.push_back(p.name);
    sizes_.push_back({p.width, p.height});
    sides_.push_back(std::max(p.width, p.height));
  }
  const MaskFolder files(folder, config.flat, names);
  bool unread = false;  // a class has files that are not looked at here
  for (MaskClass kind : kMaskClasses) {
    const FeatureMaskUse use = use_of(config, kind);
    if (files.file_count(kind) == 0) continue;
    if (use == FeatureMaskUse::Off || (kind == MaskClass::Object && turntable == Turntable::No)) {
      unread = true;
      continue;
    }
    const std::string option = fmt::format("sfm.masks.{}", name(kind));
    std::atomic<size_t> other_shape{0};
    masks_[size_t(kind)].emplace(PhotoMasksDesc{.folder = files,
                                                .kind = kind,
                                                .photos = names,
                                                .polarity = static_cast<MaskPolarity>(use),
                                                .polarity_option = option,
                                                .off_setting = option + "=off",
                                                .usable = [&](size_t photo, const MaskFile& file, const ImageF& mask) {
                                                  const auto [w, h] = sizes_[photo];
                                                  if (same_shape(mask.width(), mask.height(), w, h)) return true;
                                                  if (same_shape(mask.width(), mask.height(), h, w))
                                                    throw_wrong_mask_size(file, mask, w, h, true);
                                                  ++other_shape;
                                                  return false;
                                                }});
    other_shape_ += other_shape;
    if (masks_[size_t(kind)]->matched() == 0) masks_[size_t(kind)].reset();
  }
  // A class whose masks are all empty is ignored. If all classes are empty, the files are wrong.
  const bool any = std::any_of(masks_.begin(), masks_.end(), [](const auto& m) { return m && !m->nothing(); });
  for (auto& masks : masks_) {
    if (!masks || !masks->nothing()) continue;
    if (!any && !unread) masks->throw_all_black();
    log_info("sfm: {}: no feature is held to them", masks->all_black_text());
    masks.reset();
  }
  if (turntable == Turntable::Yes && !has(MaskClass::Object))
    throw Error(ErrorKind::Input, "a turntable needs masks of the object",
                {.where = folder.string(),
                 .why = "sfm.turntable=yes says that the room moves against the object, and no mask says which is which",
                 .hint = "put one mask per photo into " + (folder / "object").string() + ", or --set sfm.turntable=no",
                 .code = "SFM_TURNTABLE_WITHOUT_MASKS"});
}

bool FeatureMasks::empty() const {
  return std::none_of(masks_.begin(), masks_.end(), [](const auto& m) { return m.has_value(); });
}

std::vector<uint8_t> FeatureMasks::classes_at(size_t photo, std::span<const float> xy) const {
  std::vector<uint8_t> classes(xy.size() / 2, 0);
  for (MaskClass kind : kMaskClasses) {
    if (!has_mask(kind, photo)) {
      if (kind == MaskClass::Object)
        for (uint8_t& c : classes) c |= bit(kind);
      continue;
    }
    const ImageF mask = masks_[size_t(kind)]->at(photo);
    const double sx = double(mask.width()) / sizes_[photo].first, sy = double(mask.height()) / sizes_[photo].second;
    for (size_t i = 0; i < classes.size(); ++i) {
      const int x = std::clamp(int(sx * double(xy[2 * i])), 0, mask.width() - 1);
      const int y = std::clamp(int(sy * double(xy[2 * i + 1])), 0, mask.height() - 1);
      if (mask.at(x, y) > kInside) classes[i] |= bit(kind);
    }
  }
  return classes;
}

std::vector<uint8_t> FeatureMasks::on_object(size_t photo, std::span<const float> xy) const {
  std::vector<uint8_t> on = classes_at(photo, xy);
  for (uint8_t& c : on) c = (c & bit(MaskClass::Object)) != 0;
  return on;
}

std::vector<std::vector<uint32_t>> suppress_features(const FeatureMasks& masks, UsedFeatures used,
                                                     std::span<const size_t> photo_of, std::vector<PhotoFeatures>& features,
                                                     MaskEffect& effect) {
  const size_t n = features.size();
  std::vector<std::vector<uint8_t>> classes(n);
  parallel_for(n, 1, [&](size_t i) {
    throw_if_interrupted();
    classes[i] = masks.classes_at(photo_of[i], features[i].xy);
  });
  std::vector<std::vector<uint32_t>> kept(n);
  // Keeps the features of features[i] whose classes satisfy `stay`.
  const auto leave = [&](size_t i, auto&& stay) {
    PhotoFeatures& f = features[i];
    size_t to = 0;
    for (size_t k = 0; k < f.count; ++k) {
      if (!stay(classes[i][kept[i][k]])) continue;
      kept[i][to] = kept[i][k];
      std::copy_n(f.xy.begin() + long(2 * k), 2, f.xy.begin() + long(2 * to));
      std::copy_n(f.descriptors.begin() + long(kDescriptorBytes * k), kDescriptorBytes,
                  f.descriptors.begin() + long(kDescriptorBytes * to));
      ++to;
    }
    f.count = to;
    kept[i].resize(to);
    f.xy.resize(2 * to);
    f.descriptors.resize(kDescriptorBytes * to);
  };
  for (size_t i = 0; i < n; ++i) {
    effect.before += features[i].count;
    kept[i].resize(features[i].count);
    std::iota(kept[i].begin(), kept[i].end(), 0u);
    for (MaskClass kind : kMaskClasses)
      if (kind != MaskClass::Object)
        for (uint8_t c : classes[i]) effect.removed[size_t(kind)] += (c & bit(kind)) != 0;
    leave(i, [](uint8_t c) { return (c & ~bit(MaskClass::Object)) == 0; });
  }
  const bool by_turntable = used == UsedFeatures::ByTurntable;
  effect.turntable = masks.turntable();
  effect.object_applied = by_turntable && masks.turntable() == Turntable::Yes;
  if (by_turntable && masks.turntable() == Turntable::Auto && masks.has(MaskClass::Object)) {
    // Mirrors and passers-by have no vote: what they show moves by laws of its own.
    std::vector<std::vector<uint8_t>> inside(n);
    std::vector<double> sides(n);
    for (size_t i = 0; i < n; ++i) {
      sides[i] = masks.longest_side(photo_of[i]);
      if (!masks.has_mask(MaskClass::Object, photo_of[i])) continue;
      for (uint32_t k : kept[i]) inside[i].push_back((classes[i][k] & bit(MaskClass::Object)) != 0);
    }
    effect.evidence = turntable_evidence({.photos = features, .inside = inside, .sides = sides});
    effect.object_applied = effect.evidence->turntable;
  }
  for (size_t i = 0; i < n; ++i) {
    if (effect.object_applied || used == UsedFeatures::Surroundings) {
      const auto stays = [&](uint8_t c) { return ((c & bit(MaskClass::Object)) != 0) == effect.object_applied; };
      for (uint8_t c : classes[i]) effect.removed[size_t(MaskClass::Object)] += !stays(c);
      leave(i, stays);
    }
    if (effect.removed_of_photo.size() <= photo_of[i]) effect.removed_of_photo.resize(photo_of[i] + 1, 0);
    effect.removed_of_photo[photo_of[i]] = classes[i].size() - kept[i].size();
    effect.after += kept[i].size();
  }
  for (MaskClass kind : kMaskClasses) effect.photos[size_t(kind)] = masks.photos_with(kind);
  if (by_turntable) log_mask_effect(effect);
  return kept;
}

}  // namespace vitrine
