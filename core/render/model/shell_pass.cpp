#include "core/render/model/shell_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/kernels/ggx.h"

namespace vitrine {

namespace {

constexpr size_t kShellGrain = 256;
constexpr double kAtWall_rel = 0.4;    // of the glass tolerance: surfels within this distance of a wall belong to it
constexpr double kOneWall_rel = 1e-4;  // of the distance to the glass: a ray that leaves within it has passed one wall, not two
constexpr float kDimRay = 0.02f;       // transmittance at which a ray ends: thin glass reflects a tenth
constexpr double kBeyond_rel = 1.01;   // of the distance to the end of a shape's bounds

// Distance along the ray to behind the whole box.
double way_past(const Bounds3& box, const Ray& ray) {
  double way = 0;
  for (const double x : {box.low.x, box.high.x})
    for (const double y : {box.low.y, box.high.y})
      for (const double z : {box.low.z, box.high.z}) way = std::max(way, dot(Vec3d{x, y, z} - ray.origin, ray.direction));
  return kBeyond_rel * way / dot(ray.direction, ray.direction);
}

}  // namespace

ShellPass::Wall ShellPass::far_wall(const Frame& frame, uint32_t pixel) const {
  const ShapeSet::Entry& entry = frame.options.shape.set->entries[frame.sheets.entry[pixel] - 1];
  if (entry.role == ShapeRole::Solid) return {};
  const GBuffer g(frame);
  const Vec3d eye = frame.view->centre_in_world(), per_z = cast<double>(g.ray(pixel).direction_per_z);
  const double entered = double(g.zdepth[pixel]) / double(g.alpha[pixel]);
  const double beyond = way_past(shell_[frame.sheets.entry[pixel] - 1], {eye, per_z});
  const auto back = intersect(entry.shape, {eye + beyond * per_z, -per_z});
  if (!back || !(beyond - back->t > (1 + kOneWall_rel) * entered)) return {};
  const double left = beyond - back->t, rise = dot(back->normal, per_z);
  if (!(rise > 0)) return {};
  const bool past = (double(frame.behind.median_z[pixel]) - left) * length(per_z) > kAtWall_rel * entry.tolerance ||
                    frame.behind.inner_transmittance[pixel] > 0.5f;
  return {eye + left * per_z, back->normal, static_cast<float>(rise / length(per_z)), true, past};
}

// Rays of the chosen pixels; if any pixel of a group sees the outside, also for the far wall.
void ShellPass::emit(const Frame& frame) {
  const ShadedPixels& s = frame.shaded;
  const PaneImages& panes = frame.panes;
  mirrored_.clear(), origins_.clear(), directions_.clear();
  for (size_t g = 0; g < s.groups(); ++g) {
    const uint32_t pixel = s.chosen_pixel(g), entry = frame.sheets.entry[pixel];
    if (entry == 0 || shell_[entry - 1].empty() || !panes.shown[pixel]) continue;
    const SurfacePoint<float>& p = s.points[g];
    mirrored_.push_back({static_cast<uint32_t>(g), false});
    origins_.push_back(p.position);
    directions_.push_back(reflected(s.rays[g].view, p.normal));
    bool out = false;
    for (uint32_t i = s.begin[g]; i < s.begin[g + 1]; ++i) out |= panes.far_share[s.pixels[i]] > 0;
    if (!out) continue;
    const Wall wall = far_wall(frame, pixel);
    if (!wall.met) continue;
    mirrored_.push_back({static_cast<uint32_t>(g), true});
    origins_.push_back(cast<float>(wall.position));
    directions_.push_back(reflected(s.rays[g].view, cast<float>(-wall.normal)));
  }
  near_.assign(origins_.size(), frame.options.reflection.near);
}

void ShellPass::spread_to_groups(Frame& frame) const {
  const ShadedPixels& s = frame.shaded;
  const size_t pixels = frame.pixel_count();
  for (size_t k = 0; k < mirrored_.size(); ++k) {
    const auto& [g, far] = mirrored_[k];
    std::vector<float>& color = far ? frame.panes.far_color : frame.panes.near_color;
    std::vector<float>& open = far ? frame.panes.far_open : frame.panes.near_open;
    for (uint32_t i = s.begin[g]; i < s.begin[g + 1]; ++i) {
      const uint32_t pixel = s.pixels[i], entry = frame.sheets.entry[pixel];
      if (entry == 0 || shell_[entry - 1].empty() || !frame.panes.shown[pixel]) continue;
      for (size_t c = 0; c < 3; ++c) color[c * pixels + pixel] = values_.color[k][c];
      open[pixel] = values_.transmittance[k];
    }
  }
}

void ShellPass::forward(const SplatScene&, Frame& frame) {
  if (frame.sheets.empty() || frame.behind.radiance.empty()) return;
  shell_.clear();
  for (const ShapeSet::Entry& e : frame.options.shape.set->entries)
    shell_.push_back(is_glass(e.role) && facets(e.shape).empty() ? bounds(e.shape) : Bounds3{});
  if (std::ranges::all_of(shell_, &Bounds3::empty)) return;
  ShadedPixels& s = frame.shaded;
  const auto shows_shell = [&](size_t i) {
    const uint32_t entry = frame.sheets.entry[s.pixels[i]];
    return s.requests[i].transmission && entry != 0 && !shell_[entry - 1].empty();
  };
  PaneImages& out = frame.panes;
  if (out.empty()) out.start(frame.pixel_count());
  parallel_chunks(s.pixels.size(), kShellGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!shows_shell(i)) continue;
      out.shown[s.pixels[i]] = 1;
      s.requests[i].reflection = true;
      const Wall wall = far_wall(frame, s.pixels[i]);
      if (!wall.open) continue;
      out.far_share[s.pixels[i]] = 1;
      out.far_cosine[s.pixels[i]] = wall.cosine;
    }
  });
  emit(frame);
  if (origins_.empty()) return;
  tracer_->build(frame.opened.surfels);
  tracer_->forward({.origins = origins_, .directions = directions_, .near = near_, .far = {}},
                   {.sh_degree = frame.opened.surfels.sh_degree(), .min_transmittance = kDimRay}, values_, nullptr);
  spread_to_groups(frame);
}

}  // namespace vitrine
