#include "core/scene/camera/lens_circle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/math/quantile.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr int kSectors = 32, kRings = 512;               // rings from the centre to the farthest corner
constexpr float kBlack = 20;                             // of 255: noise and stray light stay below
constexpr double kEdge = 0.04;                           // of the radius: how far the edges of the sectors differ at most
constexpr double kLeastRadius = 0.3;                     // of the shorter side; smaller ones are no picture
constexpr double kSoftEdge_px = 1.5, kSoftEdge = 0.008;  // left out inside the edge: pixels, and of the radius
constexpr double kAgreeing = 0.8;                        // of the sectors

}  // namespace

LensCircle::LensCircle(int width, int height, const Vec2d& centre)
    : width_(width), height_(height), centre_(centre), brightest_(size_t(kSectors) * kRings) {}

void LensCircle::add(const Image8& photo) {
  ++photos_;
  const double sx = double(width_) / photo.width(), sy = double(height_) / photo.height();
  const double farthest = std::hypot(std::max(centre_.x, width_ - centre_.x), std::max(centre_.y, height_ - centre_.y));
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 0; x < photo.width(); ++x) {
      const double dx = (x + 0.5) * sx - centre_.x, dy = (y + 0.5) * sy - centre_.y;
      const int ring = std::min(int(kRings * std::hypot(dx, dy) / farthest), kRings - 1);
      const int sector = std::min(int(kSectors * (std::atan2(dy, dx) / (2 * std::numbers::pi) + 0.5)), kSectors - 1);
      const uint8_t* p = photo.pixel(x, y);
      float& brightest = brightest_[size_t(sector) * kRings + size_t(ring)];
      brightest = std::max(brightest, float(std::max({p[0], p[1], p[2]})));
    }
}

double LensCircle::radius() const {
  if (photos_ == 0) return 0;
  const double farthest = std::hypot(std::max(centre_.x, width_ - centre_.x), std::max(centre_.y, height_ - centre_.y));
  std::vector<double> edges;  // of the sectors that end in black within the photo
  for (int s = 0; s < kSectors; ++s) {
    const double angle = 2 * std::numbers::pi * ((s + 0.5) / kSectors - 0.5);
    const Vec2d d{std::cos(angle), std::sin(angle)};
    const double to_x = d.x > 0 ? (width_ - centre_.x) / d.x : -centre_.x / d.x;
    const double to_y = d.y > 0 ? (height_ - centre_.y) / d.y : -centre_.y / d.y;
    const int border = std::min(int(kRings * std::min(to_x, to_y) / farthest), kRings) - 1;
    int last = border;
    while (last >= 0 && brightest_[size_t(s) * kRings + size_t(last)] < kBlack) --last;
    if (last < 0) return 0;
    if (border - last > std::max(2, int(kEdge * border))) edges.push_back((last + 1.0) / kRings * farthest);
  }
  constexpr size_t kLeastSectors = 8;  // two at each corner
  if (edges.size() < kLeastSectors) return 0;
  const double radius = order_statistic_of(std::span(edges), edges.size() / 2);
  const auto agree = std::ranges::count_if(edges, [&](double e) { return std::abs(e - radius) <= kEdge * radius; });
  if (double(agree) < kAgreeing * double(edges.size()) || radius < kLeastRadius * std::min(width_, height_)) return 0;
  return radius - std::max(kSoftEdge_px, kSoftEdge * radius);
}

bool shows_lens_circle(const ImageF& photo) {
  if (photo.channels() != 3) return false;
  LensCircle circle(photo.width(), photo.height(), {0.5 * photo.width(), 0.5 * photo.height()});
  circle.add(bytes_of(photo));
  return circle.radius() > 0;
}

}  // namespace vitrine
