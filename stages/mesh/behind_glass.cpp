#include "stages/mesh/fusion.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/render/model/glass_segments.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_hits.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/tsdf_volume.h"

namespace vitrine {

namespace {

constexpr double kLeastCase = 0.05;   // of the glass faces: smaller parts are specks
constexpr double kMarginVoxels = 2;   // margin around a case, which includes its base
constexpr double kLeastPiece = 0.02;  // of the faces behind glass: smaller components are remains of panes and their edges
constexpr float kSameVoxels = 2.5f;   // along the normal: the same surface
constexpr size_t kFaceGrain = 1024;

// Bounding boxes of the larger glass components, with `margin` on each side.
std::vector<Bounds3> cases(const TriMesh& glass, const Vec3d& margin) {
  const FaceComponents pieces = face_components(glass);
  std::vector<Bounds3> boxes(pieces.faces.size());
  for (size_t f = 0; f < glass.faces.size(); ++f)
    for (uint32_t v : glass.faces[f]) boxes[pieces.label[f]].extend(cast<double>(glass.positions[v]));
  std::vector<Bounds3> out;
  for (size_t i = 0; i < boxes.size(); ++i)
    if (double(pieces.faces[i]) >= kLeastCase * double(glass.faces.size()))
      out.push_back({boxes[i].low - margin, boxes[i].high + margin});
  return out;
}

// Faces inside the boxes that are not in `known` (opaque faces of the mesh).
TriMesh only_new(const TriMesh& found, const std::vector<Bounds3>& boxes, const MeshHits& known, float voxel) {
  std::vector<uint8_t> keep(found.faces.size(), 0);
  parallel_chunks(keep.size(), kFaceGrain, [&](size_t, size_t first, size_t last) {
    for (size_t f = first; f < last; ++f) {
      const auto& v = found.faces[f];
      const Vec3f a = found.positions[v[0]], b = found.positions[v[1]], c = found.positions[v[2]];
      const Vec3f centre = (1.f / 3.f) * (a + b + c), across = cross(b - a, c - a);
      if (!(squared_length(across) > 0)) continue;
      if (std::ranges::none_of(boxes, [&](const Bounds3& box) { return box.contains(centre); })) continue;
      const Vec3f n = normalized(across);
      keep[f] = !known.occluded(centre + kSameVoxels * voxel * n, -n, 0.f, 2 * kSameVoxels * voxel);
    }
  });
  return submesh(found, keep);
}

}  // namespace

TriMesh behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress) {
  std::vector<uint8_t> is_glass = glass_faces(desc.mesh, desc.diffuse, float(desc.voxel)), is_opaque(is_glass.size());
  std::transform(is_glass.begin(), is_glass.end(), is_opaque.begin(), [](uint8_t g) { return !g; });
  const double margin = kMarginVoxels * desc.voxel;
  const std::vector<Bounds3> boxes = cases(submesh(desc.mesh, is_glass), {margin, margin, margin});
  if (boxes.empty()) return {};
  Bounds3 bounds;
  for (const Bounds3& box : boxes) bounds.extend(box.low), bounds.extend(box.high);

  std::vector<std::vector<uint8_t>> shows_glass(desc.views);
  FusionDesc fusion = desc.fusion;
  fusion.volume.bounds = bounds;
  fusion.volume.voxel = desc.voxel;
  fusion.min_valid_fraction = 0;  // a view without glass contributes nothing and does no harm
  FusionReport report;
  TriMesh found;
  try {
    const TsdfVolume volume = fuse_views(
        desc.views,
        [&](size_t i, double voxel) {
          if (shows_glass[i].empty()) shows_glass[i] = desc.glass_of(i);
          RgbdFrame frame = desc.depth_of(i, voxel);
          VITRINE_CHECK(shows_glass[i].size() == frame.zdepth.size(), "a pixel of glass for every pixel of depth");
          for (size_t p = 0; p < frame.zdepth.size(); ++p)
            if (!shows_glass[i][p]) frame.zdepth[p] = frame.weight[p] = 0;
          return frame;
        },
        fusion, [&](double f) { progress(0.8 * f); }, report);
    found = iso_surface(volume);
  } catch (const Error& e) {
    if (e.detail().code != "NO_SURFACE") throw;
  }
  found = without_small_components(found, {.min_fraction = desc.min_component});
  taubin_smooth(found, {.iterations = desc.smooth_iterations});
  if (found.faces.size() > desc.faces) found = decimated(found, {.target_faces = desc.faces});
  progress(0.9);
  TriMesh content = without_small_components(only_new(found, boxes, MeshHits(submesh(desc.mesh, is_opaque)), float(desc.voxel)),
                                             {.min_fraction = kLeastPiece});
  content.normals = vertex_normals(content);
  log_info("mesh: {} faces stand behind glass, in {} place{}", content.faces.size(), boxes.size(), boxes.size() == 1 ? "" : "s");
  return content;
}

}  // namespace vitrine
