#include "core/scene/mesh/tsdf_volume.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr int kBlockSide = TsdfBlock::kSide;
constexpr double kMaxTableSlots = 1 << 27;  // 512 MiB of block numbers
constexpr int kTile = 16;                   // pixels per side of a depth-range tile

// Maximum valid depth per tile, 0 if none: integrate() skips blocks behind all surfaces.
class FarTiles {
 public:
  explicit FarTiles(const DepthView& view)
      : width_((view.intrinsics.width + kTile - 1) / kTile),
        height_((view.intrinsics.height + kTile - 1) / kTile),
        far_(size_t(width_) * size_t(height_), 0.f) {
    const int w = view.intrinsics.width, h = view.intrinsics.height;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        float& f = far_[size_t(y / kTile) * size_t(width_) + size_t(x / kTile)];
        f = std::max(f, view.zdepth[size_t(y) * size_t(w) + size_t(x)]);
      }
  }
  // Maximum over the tiles that overlap the pixel rectangle, clipped to the image. 0: no valid depth.
  float farthest(double x0, double y0, double x1, double y1) const {
    const auto tile = [](double p, int n) { return static_cast<int>(std::clamp(std::floor(p / kTile), 0.0, double(n - 1))); };
    float f = 0;
    for (int ty = tile(y0, height_); ty <= tile(y1, height_); ++ty)
      for (int tx = tile(x0, width_); tx <= tile(x1, width_); ++tx)
        f = std::max(f, far_[size_t(ty) * size_t(width_) + size_t(tx)]);
    return f;
  }

 private:
  int width_, height_;
  std::vector<float> far_;
};

void check_view(const DepthView& v) {
  const size_t pixels = v.intrinsics.pixel_count();
  VITRINE_CHECK(v.zdepth.size() == pixels && v.weight.size() == pixels, "depth map of {} pixels for {}", v.zdepth.size(), pixels);
  VITRINE_CHECK(v.color.empty() || v.color.size() == 3 * pixels, "colour plane of {} values for {} pixels", v.color.size(),
                pixels);
}

struct FusionConstants {
  float truncation, inverse_truncation, voxel, free_weight, cap, discontinuity;
};

// Fuses one view into one block; returns the number of updated voxels. `corner_in_cam`: voxel (0,0,0) in the camera frame;
// `step`: camera-frame steps of one voxel along the grid axes.
size_t fuse_block(TsdfBlock& block, const DepthView& view, const FusionConstants& k, const Vec3f& corner_in_cam,
                  const Mat3f& step) {
  const int w = view.intrinsics.width, h = view.intrinsics.height;
  const size_t plane = size_t(w) * size_t(h);
  const float fx = float(view.intrinsics.fx), fy = float(view.intrinsics.fy);
  const float cx = float(view.intrinsics.cx), cy = float(view.intrinsics.cy);
  size_t updates = 0;
  for (int vz = 0; vz < kBlockSide; ++vz)
    for (int vy = 0; vy < kBlockSide; ++vy) {
      const Vec3f row = corner_in_cam + float(vy) * step.c1 + float(vz) * step.c2;
      float px[kBlockSide], py[kBlockSide], z[kBlockSide], raylen[kBlockSide];
      for (int i = 0; i < kBlockSide; ++i) {  // one AVX register
        const float x = row.x + float(i) * step.c0.x, y = row.y + float(i) * step.c0.y;
        z[i] = row.z + float(i) * step.c0.z;
        const float inverse_z = 1.f / z[i];
        const float rx = x * inverse_z, ry = y * inverse_z;
        px[i] = rx * fx + cx - 0.5f;  // pixel centres at integers below
        py[i] = ry * fy + cy - 0.5f;
        raylen[i] = std::sqrt(rx * rx + ry * ry + 1.f);
      }
      const int base = TsdfBlock::index(0, vy, vz);
      for (int i = 0; i < kBlockSide; ++i) {
        if (!(z[i] > 0.f) || !(px[i] >= 0.f) || !(py[i] >= 0.f) || !(px[i] < float(w - 1)) || !(py[i] < float(h - 1))) continue;
        const int x0 = int(px[i]), y0 = int(py[i]);
        const float ax = px[i] - float(x0), ay = py[i] - float(y0);
        const size_t p00 = size_t(y0) * size_t(w) + size_t(x0);
        const float d00 = view.zdepth[p00], d10 = view.zdepth[p00 + 1];
        const float d01 = view.zdepth[p00 + size_t(w)], d11 = view.zdepth[p00 + size_t(w) + 1];
        const float low = std::min(std::min(d00, d10), std::min(d01, d11));
        const float high = std::max(std::max(d00, d10), std::max(d01, d11));
        if (!(low > 0.f) || high - low > k.discontinuity) continue;
        const size_t nearest = p00 + (ax > 0.5f ? 1 : 0) + (ay > 0.5f ? size_t(w) : 0);
        const float pixel_weight = view.weight[nearest];
        if (!(pixel_weight > 0.f)) continue;
        const float d = (1 - ay) * ((1 - ax) * d00 + ax * d10) + ay * ((1 - ax) * d01 + ax * d11);
        const float sdf = (d - z[i]) * raylen[i];
        if (sdf <= -k.truncation) continue;
        float sample = sdf * k.inverse_truncation, weight = pixel_weight;
        const bool in_band = sample < 1.f;
        if (!in_band) {
          sample = 1.f;
          weight = k.free_weight / (d * d);
        } else if (sdf < -k.voxel) {
          // The weight decreases behind the surface, so that a thin object is not erased by views of its other side.
          weight *= (k.truncation + sdf) / (k.truncation - k.voxel);
        }
        const int v = base + i;
        if (!(weight > 0.f)) continue;
        const float total = block.weight[v] + weight;
        block.distance[v] += (sample - block.distance[v]) * (weight / total);
        block.weight[v] = std::min(total, k.cap);
        ++updates;
        if (in_band && !view.color.empty()) {
          const float color_total = block.color_weight[v] + weight;
          for (size_t c = 0; c < 3; ++c)
            block.color[c][v] += (view.color[c * plane + nearest] - block.color[c][v]) * (weight / color_total);
          block.color_weight[v] = std::min(color_total, k.cap);
        }
      }
    }
  return updates;
}

}  // namespace

TsdfVolume::TsdfVolume(const TsdfDesc& desc) : desc_(desc) {
  VITRINE_CHECK(desc.voxel > 0 && desc.truncation_voxels >= 1 && !desc.bounds.empty(), "a volume needs bounds and a voxel size");
  double slots = 1;
  const Vec3d side = desc.bounds.high - desc.bounds.low;
  for (size_t i = 0; i < 3; ++i) slots *= std::floor(side[i] / (desc.voxel * kBlockSide)) + 1;
  if (!(slots <= kMaxTableSlots))
    throw Error(ErrorKind::Resource, "the volume is too large for its voxels",
                {.why = fmt::format("{:.3g} blocks of 8x8x8 voxels would be needed", slots),
                 .hint = "use a larger voxel (lower mesh.resolution) or smaller bounds",
                 .code = "VOLUME_TOO_LARGE"});
  const auto blocks_along = [&](double length) { return static_cast<int>(std::floor(length / (desc.voxel * kBlockSide))) + 1; };
  dims_ = {blocks_along(side.x), blocks_along(side.y), blocks_along(side.z)};
  touched_.assign(size_t(slots), 0);
}

int32_t TsdfVolume::find_index(const BlockCoord& c) const { return inside(c) && !index_.empty() ? index_[slot(c)] : -1; }
const TsdfBlock* TsdfVolume::find(const BlockCoord& c) const {
  const int32_t i = find_index(c);
  return i < 0 ? nullptr : &blocks_[size_t(i)];
}

void TsdfVolume::touch(const DepthView& view) {
  check_view(view);
  VITRINE_CHECK(index_.empty(), "touch() comes before allocate()");
  const int w = view.intrinsics.width;
  const Rigid world_from_cam = inverse(view.cam_from_world);
  const double margin = truncation(), inverse_block = 1.0 / (desc_.voxel * kBlockSide);
  parallel_for(size_t(view.intrinsics.height), 8, [&](size_t y) {
    BlockCoord last_low{-9, -9, -9}, last_high = last_low;
    for (int x = 0; x < w; ++x) {
      const size_t p = y * size_t(w) + size_t(x);
      if (!(view.zdepth[p] > 0.f) || !(view.weight[p] > 0.f)) continue;
      const Vec3d point =
          world_from_cam * (double(view.zdepth[p]) * view.intrinsics.ray(x + 0.5, double(y) + 0.5)) - desc_.bounds.low;
      const auto block = [&](double offset, double position, int blocks) {
        return static_cast<int>(std::clamp(std::floor((position + offset) * inverse_block), -1.0, double(blocks)));
      };
      const BlockCoord low{block(-margin, point.x, dims_.x), block(-margin, point.y, dims_.y), block(-margin, point.z, dims_.z)};
      const BlockCoord high{block(margin, point.x, dims_.x), block(margin, point.y, dims_.y), block(margin, point.z, dims_.z)};
      if (low == last_low && high == last_high) continue;
      last_low = low;
      last_high = high;
      for (int bz = std::max(low.z, 0); bz <= std::min(high.z, dims_.z - 1); ++bz)
        for (int by = std::max(low.y, 0); by <= std::min(high.y, dims_.y - 1); ++by)
          for (int bx = std::max(low.x, 0); bx <= std::min(high.x, dims_.x - 1); ++bx)
            std::atomic_ref(touched_[slot({bx, by, bz})]).store(1, std::memory_order_relaxed);
    }
  });
}

void TsdfVolume::touch_all() { std::fill(touched_.begin(), touched_.end(), uint8_t{1}); }

size_t TsdfVolume::touched_count() const { return static_cast<size_t>(std::count(touched_.begin(), touched_.end(), uint8_t{1})); }

void TsdfVolume::allocate() {
  VITRINE_CHECK(index_.empty(), "allocate() once");
  index_.assign(touched_.size(), -1);
  const size_t n = touched_count();
  coords_.reserve(n);
  for (int z = 0; z < dims_.z; ++z)
    for (int y = 0; y < dims_.y; ++y)
      for (int x = 0; x < dims_.x; ++x) {
        const size_t s = slot({x, y, z});
        if (!touched_[s]) continue;
        index_[s] = static_cast<int32_t>(coords_.size());
        coords_.push_back({x, y, z});
      }
  blocks_.resize(n);
}

size_t TsdfVolume::integrate(const DepthView& view) {
  check_view(view);
  const FarTiles far_tiles(view);
  const Intrinsics& in = view.intrinsics;
  const double voxel = desc_.voxel, t = truncation();
  const FusionConstants constants{.truncation = float(t),
                                  .inverse_truncation = float(1 / t),
                                  .voxel = float(voxel),
                                  .free_weight = float(desc_.free_space_weight),
                                  .cap = float(desc_.weight_cap),
                                  .discontinuity = float(desc_.discontinuity_truncations * t)};
  const Mat3d step{voxel * view.cam_from_world.rotation.c0, voxel * view.cam_from_world.rotation.c1,
                   voxel * view.cam_from_world.rotation.c2};
  const double radius = 0.5 * (kBlockSide - 1) * voxel * std::sqrt(3.0);
  constexpr size_t kChunk = 64;
  std::vector<size_t> updates(chunk_count(blocks_.size(), kChunk), 0);
  parallel_chunks(blocks_.size(), kChunk, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t b = begin; b < end; ++b) {
      const Vec3d corner = view.cam_from_world * voxel_position(coords_[b], 0, 0, 0);
      const Vec3d centre = corner + 0.5 * (kBlockSide - 1) * (step.c0 + step.c1 + step.c2);
      const double near_z = centre.z - radius;
      if (centre.z + radius <= 0) continue;
      if (near_z > 0.1 * radius) {  // far enough to bound the sphere by a pixel rectangle
        const ImagePoint near = projected({centre.x, centre.y, near_z}, in),
                         far = projected({centre.x, centre.y, centre.z + radius}, in);
        const double rx = in.fx * radius / near_z + 1, ry = in.fy * radius / near_z + 1;
        const double x0 = std::min(near.x, far.x) - rx, x1 = std::max(near.x, far.x) + rx;
        const double y0 = std::min(near.y, far.y) - ry, y1 = std::max(near.y, far.y) + ry;
        if (x1 < 0 || y1 < 0 || x0 > in.width || y0 > in.height) continue;
        if (near_z - t > double(far_tiles.farthest(x0, y0, x1, y1))) continue;  // sdf <= -truncation everywhere
      }
      updates[chunk] += fuse_block(blocks_[b], view, constants, cast<float>(corner), cast<float>(step));
    }
  });
  size_t total = 0;
  for (size_t u : updates) total += u;
  return total;
}

}  // namespace vitrine
