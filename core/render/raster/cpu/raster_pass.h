// Interface between the renderer and its SIMD passes: plain data and a table of functions, one table per instruction set. The
// passes are compiled from the same source (pass.inc) in two translation units with different flags; only plain structs and raw
// pointers are shared, so that no inline function of a shared header can be emitted with AVX-512 instructions and linked into
// the AVX2 path.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "core/render/raster/kernels/screen_bounds.h"
#include "core/render/raster/kernels/splat_weight.h"

namespace vitrine::cpu {

inline constexpr int kTileSide = 16, kBlockSide = 4, kBlocks = 16;  // a SIMD vector is a block of 4x4 pixels
inline constexpr int kLanes = 16;
inline constexpr size_t kMaxFeatureSlots = 12;
inline constexpr size_t kMaxChannels = kMaxFeatureSlots + 5;
inline constexpr size_t kRecordFloats = 32;
inline constexpr uint32_t kSpareSlots = 8;
// Lists are aligned to multiples of a vector.
inline constexpr uint32_t list_capacity(uint32_t count) { return (count + kLanes - 1) / kLanes * kLanes; }

// Per-surfel data of the inner loops. Two cache lines.
struct alignas(64) RasterSplat {
  SplatConstants<float> constants;
  float features[kMaxFeatureSlots];
  uint32_t id;  // index in the layer
  uint32_t unused[7];
};
static_assert(sizeof(RasterSplat) == 128);

struct LayerPointers {  // raw values or gradients; material pointers are null where the layer has none
  float *mean, *rotation, *log_scale, *opacity, *sh_dc, *sh_rest;
  float* material[4];
  int sh_rest_width;
};

struct PassView {
  float fx, fy, cx, cy;
  float rotation[9], translation[3], eye[3];  // columns of cam_from_world
  float near_z, far_z, low_pass;
  float background[3];
  int width, height, sh_degree, features;
  bool distortion;
  // Number of floats per pixel kept by the forward pass for the backward pass: median_z and, with distortion, alpha, sum w q,
  // sum w q^2, pivot.
  int kept_channels() const { return distortion ? 5 : 1; }
};

struct TileTask {
  int x0, y0;
  const uint32_t* instances;  // [count], indices into splats and bounds
  uint32_t count;
  const RasterSplat* splats;
  const SplatBounds* bounds;
  float* kept;             // [kBlocks][kept_channels][kLanes], written by forward, read by backward
  const uint16_t* wanted;  // [kBlocks] bits of the wanted pixels; null: all
  uint16_t wanted_blocks;  // bits of the blocks with a wanted pixel
  // Scratch memory of the calling thread.
  float* pixels;       // [kMaxChannels][kBlocks][kLanes], channels in the order of TileImages
  RasterSplat* local;  // [count]
  // Lists of the blocks, list b starts at list_offset[b]. Forward: first unsorted, with the smallest z of each surfel in the
  // block; then `list` contains, in order, the blended surfels. Backward reads these. Indices are within the tile.
  uint32_t* list;
  float* z_min;
  uint32_t* list_offset;  // [kBlocks + 1]
  uint32_t* list_size;    // [kBlocks]
  uint32_t* sorted;       // one list
  float* sorted_z;
  unsigned char* slots;  // [count + kSpareSlots] of the pass's own slot type
  uint32_t* fragments;   // [2] out: fragments, vectors evaluated
};

// Output images of forward; input gradients of backward, where null means zero. The first channels of a tile's pixels are the
// features, then the others in this order.
template <class Plane>
struct TilePlanes {
  Plane features[kMaxFeatureSlots];
  Plane zdepth, alpha, median_z, distortion;
};
using TileImages = TilePlanes<float*>;
struct TileGradients : TilePlanes<const float*> {
  const float* error;  // the error image, an additional channel
  float* records;      // [count][kRecordFloats]
};

struct GradientTask {
  const LayerPointers* values;
  const LayerPointers* grad;
  const RasterSplat* splats;
  const uint32_t* batch;         // splats of this batch, [count <= kLanes], in the order of the layer
  uint32_t count, available;     // `available`: splats from batch[0] to the end of the layer
  const uint32_t* rank;          // of a splat in the sorted order
  const uint32_t* record_begin;  // by rank, into record_index
  const uint32_t* record_index;
  const float* records;
  float *screen_gradient, *weight, *error;  // null: no statistics
};

struct PassTable {
  const char* tag;
  size_t forward_slot_bytes, backward_slot_bytes;
  // Projects surfels [first, first + count) of the layer; writes the visible ones contiguously and returns their number.
  uint32_t (*project)(const LayerPointers& layer, const PassView& view, uint32_t first, uint32_t count, RasterSplat* splats,
                      SplatBounds* bounds);
  void (*forward_tile)(const PassView& view, const TileTask& task, const TileImages& images);
  void (*backward_tile)(const PassView& view, const TileTask& task, const TileGradients& gradients);
  void (*gradients)(const PassView& view, const GradientTask& task);
};

const PassTable& avx2_passes();
const PassTable& avx512_passes();

}  // namespace vitrine::cpu
