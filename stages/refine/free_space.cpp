#include "stages/refine/glass_views.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/scene/mesh/mesh_distance.h"

namespace vitrine {

namespace {

constexpr size_t kVoteGrain = 256;
constexpr uint32_t kLeastEmpty = 2;   // a surfel is removed if at least this many photos show empty space there,
constexpr double kEmptyShare = 0.25;  // and at least this share of the photos that see its position
constexpr double kInsideShare = 0.5;  // share of the rays through closed glass that pass a surfel inside or behind the glass
constexpr float kMarginVoxels = 3, kMargin_rel = 0.01f;  // the larger of both
constexpr float kReach = 2;                              // extent of a surfel in scales

void vote(const Vec3d& point, float reach, const GlassView& v, float voxel, SurfelVotes& votes) {
  const auto p = image_point(point, *v.view);
  if (!p) return;
  const size_t i = static_cast<size_t>(p->y) * static_cast<size_t>(v.view->intrinsics.width) + static_cast<size_t>(p->x);
  const float surface = v.zdepth[i], z = float(p->z), margin = reach + std::max(kMarginVoxels * voxel, kMargin_rel * surface);
  if (!(surface > 0)) return;
  if (v.opaque[i]) {
    if (z < surface - margin)
      ++votes.empty;
    else if (z < surface + margin)
      ++votes.seen;
    return;
  }
  if (!(v.glass[i] > 0.5f)) return;  // edge pixel, partly glass
  const float t = float(length(v.view->cam_from_world * point));
  const bool split = v.split(i);
  // Without a matching mesh, the G-buffer alone does not show that the space in front of glass is empty.
  if (split && t < v.segments.front[i] - margin) {
    ++votes.empty;
    return;
  }
  ++votes.seen;
  if (split && v.segments.kind[i] == SegmentKind::Closed) ++(t <= v.segments.back[i] + margin ? votes.inside : votes.beyond);
}

}  // namespace

std::vector<SurfelVotes> surfel_votes(const SplatLayer& layer, std::span<const GlassView> views, const GlassMesh& mesh) {
  std::vector<SurfelVotes> votes(layer.size());
  const MeshDistance panes(mesh.glass);
  parallel_chunks(votes.size(), kVoteGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const float *p = layer.at(Attribute::Mean, i), *scale = layer.at(Attribute::LogScale, i);
      const float reach = kReach * std::exp(std::max(scale[0], scale[1]));
      for (const GlassView& v : views) vote({p[0], p[1], p[2]}, reach, v, mesh.voxel, votes[i]);
      const float margin = reach + kMarginVoxels * mesh.voxel;
      votes[i].on_pane = !panes.empty() && panes.closest({p[0], p[1], p[2]}).distance < margin;
    }
  });
  return votes;
}

bool stands_in_empty_space(const SurfelVotes& v) {
  return !v.on_pane && v.empty >= kLeastEmpty && double(v.empty) >= kEmptyShare * double(v.empty + v.seen);
}

bool stands_beyond(const SurfelVotes& v) { return v.beyond > 0 && double(v.inside) < kInsideShare * double(v.inside + v.beyond); }

}  // namespace vitrine
