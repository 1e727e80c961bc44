#include "stages/decompose/metals.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "core/foundation/base/rng.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/render/model/kernels/ggx.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

namespace {

constexpr int kNeighbours = 8;  // offset of the compared pixel, horizontally and vertically
constexpr size_t kFewestPairs = 200, kMostPairs = 1500;
constexpr size_t kLobeRays = 32;  // per pixel: two halves with independent noise
constexpr float kSmoothest = 0.02f, kRoughest = 0.6f;
constexpr int kHalvings = 7;  // bisection steps
constexpr uint64_t kLobeSeed = 11;

using Pair = std::pair<size_t, size_t>;  // pixel indices

std::vector<Pair> mirrored_pairs(const MirroredPixels& pixels) {
  std::map<std::array<int, 3>, size_t> at;
  for (size_t i = 0; i < pixels.size(); ++i) at[{pixels.view[i], pixels.x[i], pixels.y[i]}] = i;
  std::vector<Pair> all;
  for (size_t i = 0; i < pixels.size(); ++i)
    for (const auto& [dx, dy] : {std::pair{kNeighbours, 0}, std::pair{0, kNeighbours}})
      if (const auto other = at.find({pixels.view[i], pixels.x[i] + dx, pixels.y[i] + dy}); other != at.end())
        all.emplace_back(i, other->second);
  std::vector<Pair> some;
  const size_t stride = all.size() / kMostPairs + 1;
  for (size_t p = 0; p < all.size(); p += stride) some.push_back(all[p]);
  return some;
}

class Contrast {
 public:
  Contrast(const MirroredPixels& pixels, const Vec3f& reflectance, const LightAlong& light)
      : pixels_(pixels),
        reflectance_(reflectance),
        light_(light),
        pairs_(mirrored_pairs(pixels)),
        place_(pixels.size(), SIZE_MAX) {
    for (const auto& [i, j] : pairs_)
      for (const size_t p : {i, j})
        if (place_[p] == SIZE_MAX) place_[p] = shown_.size(), shown_.push_back(p);
  }
  size_t pairs() const { return pairs_.size(); }

  // Mean squared luminance difference between neighbours.
  double of_photos() const {
    std::vector<double> photo;
    for (const size_t p : shown_) photo.push_back(double(luminance(pixels_.photo[p])));
    return between(photo, photo);
  }
  // The same for the reflections, from two independent halves of the rays, which removes the noise bias.
  double at(float roughness) const {
    std::vector<Vec3f> origins, directions;
    Rng rng(kLobeSeed);
    for (const size_t p : shown_)
      for (size_t s = 0; s < kLobeRays; ++s) {
        const float u0 = float(rng.uniform()), u1 = float(rng.uniform());
        const Vec3f& eye = pixels_.towards_eye[p];
        const Vec3f half = ggx_half_vector(pixels_.normals[p], roughness * roughness, u0, u1);
        const Vec3f out = 2 * dot(eye, half) * half - eye;
        origins.push_back(pixels_.origins[p]);
        // Sampled directions below the surface are replaced by the mirrored ray.
        directions.push_back(
            normalized(dot(out, pixels_.normals[p]) > 0 ? out : 2 * dot(eye, pixels_.normals[p]) * pixels_.normals[p] - eye));
      }
    const std::vector<Vec3f> light = light_(origins, directions);
    std::array<std::vector<double>, 2> halves;
    for (size_t n = 0; n < shown_.size(); ++n) {
      const size_t p = shown_[n];
      const Vec3f reflected = schlick(reflectance_, dot(pixels_.normals[p], pixels_.towards_eye[p])).value;
      std::array<double, 2> sum{};
      for (size_t s = 0; s < kLobeRays; ++s) sum[s % 2] += double(luminance(hadamard(reflected, light[n * kLobeRays + s])));
      for (size_t h = 0; h < 2; ++h) halves[h].push_back(sum[h] / (kLobeRays / 2));
    }
    return between(halves[0], halves[1]);
  }

 private:
  double between(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0;
    for (const auto& [i, j] : pairs_) sum += (a[place_[i]] - a[place_[j]]) * (b[place_[i]] - b[place_[j]]);
    return sum / double(std::max<size_t>(pairs_.size(), 1));
  }

  const MirroredPixels& pixels_;
  const Vec3f reflectance_;
  const LightAlong& light_;
  std::vector<Pair> pairs_;
  std::vector<size_t> place_, shown_;  // [pixel] index among the pixels of pairs; the pixels of pairs
};

}  // namespace

std::optional<float> roughness_of_contrast(const MirroredPixels& pixels, const Vec3f& reflectance, const LightAlong& light) {
  const Contrast contrast(pixels, reflectance, light);
  if (contrast.pairs() < kFewestPairs) return std::nullopt;
  const double photos = contrast.of_photos();
  float smooth = kSmoothest, rough = kRoughest;
  for (int i = 0; i < kHalvings; ++i) {
    const float middle = 0.5f * (smooth + rough);
    (contrast.at(middle) > photos ? smooth : rough) = middle;
  }
  return 0.5f * (smooth + rough);
}

}  // namespace vitrine
