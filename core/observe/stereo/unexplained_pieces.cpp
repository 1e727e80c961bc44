#include "core/observe/stereo/unexplained_pieces.h"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>

#include "core/scene/camera/projection.h"
#include "core/foundation/math/voxel_grid.h"

namespace vitrine {

namespace {

constexpr int kVoxels = 128;  // along an edge of the cube
constexpr double kHalfCube = 1.2;
constexpr float kErrors[] = {1.7f, 1.4f, 1.1f};         // minimum error of an unexplained pixel
constexpr float kContradictions[] = {0.08f, 0.2f};      // maximum share of contradicting photos
constexpr size_t kFewestVoxels = 200;                   // smaller pieces are parts of objects or too small to matter
constexpr double kSeenBy = 0.35, kUnexplainedBy = 0.3;  // minimum shares of all photos
constexpr double kPastBy = 0.02;                        // of the depth
constexpr double kNearestCamera = 0.02;                 // minimum camera distance of a visible point
constexpr double kSamePiece = 0.6;                      // IoU

using Contradictions = std::array<VoxelGrid<float>, std::size(kErrors)>;

// For each error threshold, the share of contradicting photos; 1 where too few photos see the voxel.
Contradictions contradictions(std::span<const View> views, std::span<const Explanation> explained) {
  VoxelGrid<float> cube;
  cube.origin = {-kHalfCube, -kHalfCube, -kHalfCube};
  cube.cell = 2 * kHalfCube / kVoxels;
  cube.size = {kVoxels, kVoxels, kVoxels};
  cube.values.assign(cube.count(), 1.f);
  Contradictions shares;
  shares.fill(cube);
  cube.each([&](int x, int y, int z) {
    const Vec3d p = cube.centre(x, y, z);
    size_t seen = 0;
    std::array<size_t, std::size(kErrors)> unexplained{}, past{};
    for (size_t v = 0; v < views.size(); ++v) {
      const auto at = image_point(p, views[v], kNearestCamera);
      if (!at) continue;
      const size_t pixel = size_t(at->y) * size_t(views[v].intrinsics.width) + size_t(at->x);
      const float error = explained[v].around[pixel];
      if (error < 0) continue;
      ++seen;
      const bool sees_past = at->z <= (1 - kPastBy) * double(explained[v].depth[pixel]);
      for (size_t e = 0; e < std::size(kErrors); ++e) {
        unexplained[e] += error >= kErrors[e];
        past[e] += error < kErrors[e] && sees_past;
      }
    }
    if (double(seen) < kSeenBy * double(views.size())) return;
    for (size_t e = 0; e < std::size(kErrors); ++e)
      if (double(unexplained[e]) >= kUnexplainedBy * double(views.size()))
        shares[e].values[cube.index(x, y, z)] = float(past[e]) / float(past[e] + unexplained[e]);
  });
  return shares;
}

// For sorted voxels.
bool same_piece(const std::vector<size_t>& a, const std::vector<size_t>& b) {
  std::vector<size_t> both;
  std::ranges::set_intersection(a, b, std::back_inserter(both));
  return double(both.size()) > kSamePiece * double(a.size() + b.size() - both.size());
}

}  // namespace

std::vector<UnexplainedPiece> unexplained_pieces(std::span<const View> views, std::span<const Explanation> explained) {
  std::vector<std::vector<size_t>> found;
  const Contradictions shares = contradictions(views, explained);
  for (const VoxelGrid<float>& share : shares)
    for (const float most : kContradictions)
      for (std::vector<size_t>& piece : connected_components(share, [&](size_t i) { return share.values[i] <= most; }).members) {
        if (piece.size() < kFewestVoxels) continue;
        std::ranges::sort(piece);
        if (std::ranges::none_of(found, [&](const std::vector<size_t>& other) { return same_piece(piece, other); }))
          found.push_back(std::move(piece));
      }
  std::ranges::stable_sort(found, std::greater{}, [](const std::vector<size_t>& piece) { return piece.size(); });
  std::vector<UnexplainedPiece> pieces;
  for (const std::vector<size_t>& voxels : found) {
    UnexplainedPiece piece{.places = {}, .voxel = shares[0].cell};
    for (const size_t i : voxels) {
      const auto [x, y, z] = shares[0].cell_at(i);
      piece.places.push_back(shares[0].centre(x, y, z));
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

}  // namespace vitrine
