#include "sample_data/generate/content.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/foundation/base/file.h"
#include "core/render/volume/kernels/cells.h"
#include "sample_data/generate/scene.h"

namespace vitrine::generate {
namespace {

constexpr size_t kCells = 48;  // of equal length on a ray through the body

// Share of a Gaussian before `t`.
float share_before(const RayProfile<float>& p, float t) { return normal_cdf((t - p.at) / p.width).below; }

std::string row(std::initializer_list<float> values) { return fmt::format("[{}]", fmt::join(values, ", ")); }
std::string row(const Vec3f& v) { return row({v.x, v.y, v.z}); }

std::string cloud_row(const GlassContent::Cloud& c) {
  const Gaussian3f& g = c.gaussian;
  const Quatf q = normalized(g.rotation);
  return fmt::format("{{\"mean\": {}, \"deviations\": {}, \"rotation\": {}, \"density_per_m\": {}, \"color\": {}}}", row(g.mean),
                     row({std::exp(g.log_scale.x), std::exp(g.log_scale.y), std::exp(g.log_scale.z)}), row({q.w, q.x, q.y, q.z}),
                     std::exp(g.log_density), row(c.color));
}

}  // namespace

GlassContent::GlassContent(float density, const Vec3f& color, std::vector<Cloud> clouds)
    : density_(density), color_(color), clouds_(std::move(clouds)) {
  for (const Cloud& c : clouds_) whitened_.push_back(whitened(c.gaussian));
}

GlassContent GlassContent::moved(const Vec3f& by, float turn, float scale) const {
  const float c = std::cos(turn), s = std::sin(turn);
  const Mat3f turned{{c, s, 0}, {-s, c, 0}, {0, 0, 1}};
  std::vector<Cloud> clouds = clouds_;
  for (auto& [g, color] : clouds) {
    g.mean = scale * (turned * g.mean) + by;
    g.rotation = quaternion(turned * rotation_matrix(normalized(g.rotation)));
    for (size_t axis = 0; axis < 3; ++axis) g.log_scale[axis] += std::log(scale);
    g.log_density -= std::log(scale);
  }
  return {density_ / scale, color_, std::move(clouds)};
}

VolumeLightf GlassContent::light(const Vec3f& origin, const Vec3f& direction, float distance) const {
  constexpr float kLeastDepth = 1e-6f, kReach = 5;
  const float length = distance / float(kCells), everywhere = density_ * length;
  std::array<RayCell<float>, kCells> cells;
  cells.fill({everywhere, everywhere * color_});
  for (size_t i = 0; i < clouds_.size(); ++i) {
    const Gaussian3f& g = clouds_[i].gaussian;
    const RayProfile<float> p = ray_profile(whitened_[i], whitened_line(whitened_[i], g.mean, origin, direction));
    if (p.depth < kLeastDepth) continue;
    const auto cell_at = [&](float t) { return static_cast<size_t>(std::clamp(t / length, 0.f, float(kCells - 1))); };
    const size_t last = cell_at(p.at + kReach * p.width);
    size_t k = cell_at(p.at - kReach * p.width);
    for (float before = share_before(p, length * float(k)); k <= last; ++k) {
      const float now = share_before(p, length * float(k + 1)), part = p.depth * (now - before);
      cells[k].depth += part;
      cells[k].emission += part * clouds_[i].color;
      before = now;
    }
  }
  VolumeLightf sum{{}, 1};
  for (const RayCell<float>& cell : cells) add_cell(cell, std::exp(-cell.depth), sum);
  return sum;
}

float GlassContent::transmittance(const Vec3f& origin, const Vec3f& direction, float distance) const {
  float depth = density_ * distance;
  for (size_t i = 0; i < clouds_.size(); ++i) {
    const RayProfile<float> p =
        ray_profile(whitened_[i], whitened_line(whitened_[i], clouds_[i].gaussian.mean, origin, direction));
    depth += p.depth * (share_before(p, distance) - share_before(p, 0));
  }
  return std::exp(-depth);
}

void write_content(const std::filesystem::path& path, const Scene& scene) {
  std::string rows;
  for (const Part& part : scene.parts) {
    if (!part.material.content) continue;
    const GlassContent& content = *part.material.content;
    std::string clouds;
    for (const GlassContent::Cloud& c : content.clouds()) clouds += (clouds.empty() ? "\n    " : ",\n    ") + cloud_row(c);
    Bounds3 bounds;
    for (const Vec3f& p : part.shape.mesh.positions) bounds.extend(cast<double>(p));
    rows += fmt::format(
        "{}  {{\"part\": \"{}\", \"bounds\": [{}, {}], \"index_of_refraction\": {}, \"density_per_m\": {}, \"color\": {}, "
        "\"clouds\": [{}]}}",
        rows.empty() ? "" : ",\n", part.name, row(cast<float>(bounds.low)), row(cast<float>(bounds.high)),
        part.material.kind == MaterialKind::SolidGlass ? part.material.index_of_refraction : 1.0f, content.density(),
        row(content.color()), clouds);
  }
  if (!rows.empty()) write_file(path, "[\n" + rows + "\n]\n");
}

}  // namespace vitrine::generate
