#include "core/learn/trainer/frozen_surfels.h"

#include <utility>

#include "core/foundation/base/parallel.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr float kOpaque = 0.9f;              // 1 - tau of non-glass surfels
constexpr float kMinFrozenSpecular = 0.01f;  // k_s: surfels below it are not frozen, and not looked up

}  // namespace

void freeze_glass(const SplatLayer& diffuse, float glass_factor, std::vector<float>& damping, std::span<float> error,
                  SplatLayer& grad) {
  damping.resize(diffuse.size());
  for (size_t i = 0; i < damping.size(); ++i) {
    const float opaque = 1 - sigmoid(*diffuse.at(Attribute::Transmission, i));
    damping[i] = opaque + glass_factor * (1 - opaque);
    error[i] *= opaque;
    if (opaque > kOpaque) *grad.at(Attribute::Transmission, i) = 0;
  }
}

void share_glass(SplatLayer& diffuse) {
  std::vector<uint32_t> glass;
  for (size_t i = 0; i < diffuse.size(); ++i)
    if (*diffuse.at(Attribute::Transmission, i) > 0) glass.push_back(static_cast<uint32_t>(i));
  for (Attribute a : {Attribute::F0, Attribute::SpecularWeight})
    for (size_t c = 0; c < diffuse.width(a); ++c) {
      double sum = 0;
      for (uint32_t i : glass) sum += double(diffuse.at(a, i)[c]);
      for (uint32_t i : glass) diffuse.at(a, i)[c] = static_cast<float>(sum / double(glass.size()));
    }
}

void freeze_mirrors(const SplatLayer& diffuse, const KnownSurface& known, float mirror_factor, std::vector<float>& damping) {
  damping.resize(diffuse.size(), 1.f);
  parallel_for(damping.size(), 1024, [&](size_t i) {
    const float k_s = sigmoid(*diffuse.at(Attribute::SpecularWeight, i)), *mean = diffuse.at(Attribute::Mean, i);
    if (k_s > kMinFrozenSpecular && known.near({mean[0], mean[1], mean[2]})) damping[i] *= 1 - (1 - mirror_factor) * k_s;
  });
}

KnownSurface::KnownSurface(std::vector<Vec3f> points, float reach) : reach_(reach) {
  if (points.empty() || !(reach > 0)) return;
  points_ = std::make_shared<const std::vector<Vec3f>>(std::move(points));
  tree_ = std::make_shared<const KdTreef>(*points_);
}

bool KnownSurface::near(const Vec3f& place) const { return tree_ && tree_->any(place, reach_); }

void KnownSurface::transfer(Archive& archive) {
  std::vector<Vec3f> points = points_ ? *points_ : std::vector<Vec3f>();
  archive.array(points);
  archive.value(reach_);
  if (archive.reads()) *this = KnownSurface(std::move(points), reach_);
}

}  // namespace vitrine
