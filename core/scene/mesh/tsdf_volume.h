// Truncated signed distance field (TSDF) fused from depth maps, in blocks of 8^3 voxels (Curless and Levoy 1996; README).
// Voxel (i,j,k) is the grid point origin + voxel * (i,j,k). Per voxel: D in [-1,1] = signed distance / truncation, positive in
// front of the surface; W = sum of weights, 0 = not observed; linear colour with its own weight.
// Two passes over the views: touch() marks the blocks near any surface, allocate() creates them, integrate() fuses. Every block
// therefore receives all views in any order, and the memory is fixed before fusion.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/camera/view.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct TsdfDesc {
  Bounds3 bounds;    // no voxels outside
  double voxel = 0;  // voxel edge length, scene units
  double truncation_voxels = 4;
  double free_space_weight = 0.2;  // weight of a sample in front of the truncation band, at z = 1
  double weight_cap = 64;
  double discontinuity_truncations = 3;  // depth samples with a larger difference in their 2x2 neighbourhood are rejected
};

// Depth map with per-pixel weights. Planar, row-major.
struct DepthView {
  Intrinsics intrinsics;
  Rigid cam_from_world;
  std::span<const float> zdepth;  // [h,w] camera z, 0 = no surface
  std::span<const float> weight;  // [h,w] weight of the surface sample; 0 = ignore the pixel
  std::span<const float> color;   // [3,h,w] linear, or empty
};

struct TsdfBlock {
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;
  static constexpr int index(int x, int y, int z) { return (z * kSide + y) * kSide + x; }
  alignas(32) std::array<float, kVoxels> distance{};
  alignas(32) std::array<float, kVoxels> weight{};
  alignas(32) std::array<std::array<float, kVoxels>, 3> color{};
  alignas(32) std::array<float, kVoxels> color_weight{};
};

struct BlockCoord {
  int x = 0, y = 0, z = 0;
  bool operator==(const BlockCoord&) const = default;
};

class TsdfVolume {
 public:
  // Throws Error{Resource} if the block table would be too large.
  explicit TsdfVolume(const TsdfDesc& desc);

  const TsdfDesc& desc() const { return desc_; }
  double truncation() const { return desc_.voxel * desc_.truncation_voxels; }
  Vec3d voxel_position(const BlockCoord& block, int x, int y, int z) const {
    return desc_.bounds.low + desc_.voxel * Vec3d{double(block.x * TsdfBlock::kSide + x), double(block.y * TsdfBlock::kSide + y),
                                                  double(block.z * TsdfBlock::kSide + z)};
  }

  void touch(const DepthView& view);
  void touch_all();  // all blocks of the bounds, for dense fields
  size_t touched_count() const;
  static constexpr size_t bytes_per_block() { return sizeof(TsdfBlock) + sizeof(BlockCoord) + sizeof(int32_t); }
  void allocate();  // call once, after the last touch()
  // Returns the number of updated voxels.
  size_t integrate(const DepthView& view);

  // Blocks in block grid order (z, y, x).
  size_t block_count() const { return blocks_.size(); }
  const BlockCoord& coord(size_t block) const { return coords_[block]; }
  const TsdfBlock& block(size_t block) const { return blocks_[block]; }
  TsdfBlock& block(size_t block) { return blocks_[block]; }
  // nullptr if outside or not allocated.
  const TsdfBlock* find(const BlockCoord& coord) const;
  int32_t find_index(const BlockCoord& coord) const;  // -1 when absent

 private:
  bool inside(const BlockCoord& c) const {
    return c.x >= 0 && c.y >= 0 && c.z >= 0 && c.x < dims_.x && c.y < dims_.y && c.z < dims_.z;
  }
  size_t slot(const BlockCoord& c) const { return (size_t(c.z) * size_t(dims_.y) + size_t(c.y)) * size_t(dims_.x) + size_t(c.x); }

  TsdfDesc desc_;
  BlockCoord dims_;
  std::vector<uint8_t> touched_;  // [dims]
  std::vector<int32_t> index_;    // [dims] block number or -1
  std::vector<BlockCoord> coords_;
  std::vector<TsdfBlock> blocks_;
};

// Zero level set of a TSDF as a triangle mesh: marching cubes with face-consistent cases (cell_cases.h). Vertices are shared
// per grid edge: the surface is manifold, and closed except at unobserved voxels.
struct IsoDesc {
  float min_weight = 1e-6f;  // cells with a corner below this weight produce no surface
  // Maximum difference of normalised distance between neighbours at a crossing. Larger jumps are the border of the observed
  // space, not a surface: in a truncation band of 4 voxels neighbours differ by about 1/4. 2 or more = off.
  float max_jump = 2.f;
};

// Normals = gradient of the field (towards free space), colours linear. The mesh does not depend on the number of threads.
TriMesh iso_surface(const TsdfVolume& volume, const IsoDesc& desc = {});

}  // namespace vitrine
