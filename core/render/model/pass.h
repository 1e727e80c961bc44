// Interface of one step of the image formation. ImageModel runs its list of passes in order, and for gradients in reverse order.
//
// A pass declares the parts of the frame that it reads, writes and adds to (after the filter graph of Intel's Open Image
// Denoise). The model rejects a list in which a part is read before it is written, or changed after it was read. A backward
// pass changes no values; it reads the values of its parts and reads and changes their gradients: the passes that wrote them
// run later. Other parts read or changed in backward have separate lists. tests/core/render/model/pass_access_test.cpp checks
// both directions.
#pragma once

#include <string_view>
#include <vector>

#include "core/render/model/frame.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

enum class FramePart : unsigned char {
  DiffuseChannels,       // Frame::diffuse
  Linear,                // Frame::linear
  ShownShapes,           // Frame::silhouette.shapes
  Coats,                 // Frame::coats
  Silhouettes,           // the rest of Frame::silhouette
  Sheets,                // Frame::sheets
  Surfaces,              // Frame::shaded, except the two parts below
  ReflectionRequests,    // ShadedPixels::requests
  TransmissionRequests,  // likewise
  OpenedScene,           // Frame::opened
  BehindGlass,           // Frame::behind, except picture_weight
  Panes,                 // Frame::panes
  ReflectedRadiance,     // Frame::reflection, except picture_weight
  TransmittedRadiance,   // Frame::transmission, except picture_weight
  PictureWeights,        // picture_weight of these three
  LayerImages,           // Frame::layers
  Clear,                 // Frame::clear
  Srgb,                  // Frame::srgb
  // Backward only.
  ErrorImage,               // Frame::error_image
  DiffuseStatistics,        // Frame::statistics
  ReflectionStatistics,     // statistics and took_part of Frame::reflection
  TransmittanceStatistics,  // likewise
};
inline constexpr size_t kFrameParts = static_cast<size_t>(FramePart::TransmittanceStatistics) + 1;
std::string_view name(FramePart part);  // "diffuse channels"

struct PassAccess {
  std::vector<FramePart> reads = {};   // final values
  std::vector<FramePart> writes = {};  // as the first writer
  std::vector<FramePart> adds = {};    // reads and changes
  // In backward, in addition to the values and gradients of the above.
  std::vector<FramePart> reverse_reads = {};
  std::vector<FramePart> reverse_adds = {};
};

class Pass {
 public:
  virtual ~Pass() = default;
  virtual std::string_view name() const = 0;
  virtual PassAccess access() const = 0;
  // Reads its options from frame.options.
  virtual void forward(const SplatScene& scene, Frame& frame) = 0;
  // Propagates the gradients of later passes and losses in the frame one step back; adds to `grad` and to the frame's layer
  // statistics, which ImageModel::backward() zeroes before.
  virtual void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) = 0;
};

}  // namespace vitrine
