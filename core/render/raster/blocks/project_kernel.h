// Projection, a thread for each surfel: raw values to the record that pixels read, bounds on the screen, and the number of tiles
// that it touches (0: not visible).
#pragma once

#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"
#include "core/render/raster/kernels/screen_bounds.h"
#include "core/render/raster/kernels/shade.h"
#include "core/render/raster/kernels/splat_weight.h"
#include "core/scene/surfels/activation.h"

namespace vitrine::blocks {

struct SurfelArrays {  // raw values, one array for each attribute (SplatLayer); materials are null where they are not blended
  const float *mean, *rotation, *log_scale, *opacity, *sh_dc, *sh_rest;
  const float* material[4];
  uint32_t sh_rest_width, count;
};

VITRINE_HD inline SurfelGeometry<F32> geometry_of(const SurfelArrays& surfels, uint32_t i) {
  const float *m = surfels.mean + size_t{3} * i, *q = surfels.rotation + size_t{4} * i, *s = surfels.log_scale + size_t{2} * i;
  return {{m[0], m[1], m[2]}, {q[0], q[1], q[2], q[3]}, s[0], s[1]};
}
// The first kCount coefficients of spherical harmonics, channel after channel of each.
template <size_t kCount>
VITRINE_HD void coefficients_of(const SurfelArrays& surfels, uint32_t i, F32* h) {
  for (size_t k = 0; k < 3; ++k) h[k] = surfels.sh_dc[size_t{3} * i + k];
  for (size_t k = 3; k < kCount; ++k) h[k] = surfels.sh_rest[size_t{surfels.sh_rest_width} * i + k - 3];
}

struct BlockView {
  static constexpr int kTileSide = 16;
  Camera<F32> camera;
  float near_z, far_z, low_pass;
  float background[3];
  int width, height, tiles_x, tiles_y, sh_degree;
  VITRINE_HD uint32_t tiles() const { return static_cast<uint32_t>(tiles_x * tiles_y); }
};

struct alignas(16) SurfelRecord {
  SplatConstants<float> constants;
  float features[kMaxFeatures];
};
static_assert(sizeof(SplatConstants<float>) == 12 * sizeof(float) && sizeof(SurfelRecord) == 96);

// visit(tile, smallest depth of the surfel there) for each tile that it touches, row by row.
template <class Visit>
VITRINE_HD void for_each_tile(const SplatBounds& b, const BlockView& view, Visit visit) {
  constexpr int kSide = BlockView::kTileSide;
  for (int ty = b.y_first / kSide; ty <= b.y_last / kSide; ++ty)
    for (int tx = b.x_first / kSide; tx <= b.x_last / kSide; ++tx) {
      const F32 left(static_cast<float>(tx * kSide) + 0.5f), top(static_cast<float>(ty * kSide) + 0.5f);
      const RectangleTest<F32> t = test_rectangle(b, left, top, static_cast<float>(kSide - 1));
      if (t.hit) visit(static_cast<uint32_t>(ty * view.tiles_x + tx), t.z_min.v);
    }
}

struct ProjectKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  SurfelArrays surfels;
  BlockView view;
  SurfelRecord* records;
  SplatBounds* bounds;
  uint32_t* tiles;  // number of tiles of each surfel

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i < surfels.count) tiles[i] = project_surfel(i);
  }

  VITRINE_HD uint32_t project_surfel(uint32_t i) const {
    const SurfelGeometry<F32> geometry = geometry_of(surfels, i);
    const Projection<F32> p = project(geometry, view.camera);
    const F32 opacity = sigmoid(F32(surfels.opacity[i]));
    if (!is_visible(p, opacity, F32(view.near_z))) return 0;
    const SplatBounds box = screen_bounds(p, opacity);
    if (box.x_first > box.x_last || box.y_first > box.y_last) return 0;
    uint32_t count = 0;
    for_each_tile(box, view, [&](uint32_t, float) { ++count; });
    if (count == 0) return 0;
    bounds[i] = box;
    SurfelRecord& to = records[i];
    const ScreenMap<F32>& map = p.map;
    to.constants = {{map.cx.v, map.cy.v, map.z0.v, map.m00.v, map.m01.v, map.m10.v, map.m11.v, map.h0.v, map.h1.v},
                    opacity.v,
                    (F32(view.near_z) / map.z0).v,
                    view.low_pass};
    const Vec3<F32> colour = colour_of(i, geometry.mean);
    for (size_t c = 0; c < 3; ++c) {
      to.features[kColourAt + c] = colour[c].v;
      to.features[kNormalAt + c] = p.normal[c].v;
    }
    if (surfels.material[0] == nullptr) return count;
    for (size_t c = 0; c < 3; ++c) to.features[kMaterialAt + c] = sigmoid(F32(surfels.material[0][size_t{3} * i + c])).v;
    for (size_t c = 1; c < 4; ++c) to.features[kMaterialAt + 2 + c] = sigmoid(F32(surfels.material[c][i])).v;
    return count;
  }

  VITRINE_HD SplatBounds screen_bounds(const Projection<F32>& p, F32 opacity) const {
    const bool low_pass = view.low_pass < static_cast<float>(kNoLowPass);
    const EllipseBounds<F32> e = ellipse_bounds(p, opacity, F32(view.near_z), low_pass);
    SplatBounds b{};  // zeros: a surfel that crosses the near plane is found in every tile of its box
    b.disc_r2 = e.disc_r2.v;
    b.z_low = e.z_low.v;
    b.z_high = e.z_high.v;
    b.cx = p.map.cx.v;
    b.cy = p.map.cy.v;
    b.z0 = p.map.z0.v;
    b.h0 = p.map.h0.v;
    b.h1 = p.map.h1.v;
    ScreenBox<F32> box;
    if (e.is_ellipse) {
      b.ex = e.ex.v;
      b.ey = e.ey.v;
      b.inv_yy = e.inv_yy.v;
      b.inv_xx = e.inv_xx.v;
      b.shear_xy = e.shear_xy.v;
      b.shear_yx = e.shear_yx.v;
      box = {e.ex - e.half_x, e.ex + e.half_x, e.ey - e.half_y, e.ey + e.half_y};
    } else {
      const ScreenColumns<F32> columns{p.Au, p.Av, p.Bu, p.Bv, p.a_u.z, p.a_v.z, p.map.cx, p.map.cy, p.map.z0};
      box = clipped_box(columns, sqrt(e.cut), F32(view.near_z));
    }
    if (low_pass) {
      const F32 r = sqrt(e.disc_r2);
      box.add(p.map.cx - r, p.map.cy - r);
      box.add(p.map.cx + r, p.map.cy + r);
    }
    pixel_range(box.x_lo.v, box.x_hi.v, view.width, b.x_first, b.x_last);
    pixel_range(box.y_lo.v, box.y_hi.v, view.height, b.y_first, b.y_last);
    return b;
  }

  // The degree is a constant of each copy: the coefficients then stay in registers.
  VITRINE_HD Vec3<F32> colour_of(uint32_t i, const Vec3<F32>& mean) const {
    switch (view.sh_degree) {
      case 0:
        return colour_of_degree<0>(i, mean);
      case 1:
        return colour_of_degree<1>(i, mean);
      case 2:
        return colour_of_degree<2>(i, mean);
      default:
        return colour_of_degree<3>(i, mean);
    }
  }
  template <int kDegree>
  VITRINE_HD Vec3<F32> colour_of_degree(uint32_t i, const Vec3<F32>& mean) const {
    constexpr size_t kCount = 3 * sh_coefficient_count(kDegree);
    F32 h[kCount];
    coefficients_of<kCount>(surfels, i, h);
    return sh_colour(kDegree, mean, view.camera.eye, h).value;
  }
};

}  // namespace vitrine::blocks
