// One step of the image formation. ImageModel runs its list of passes in order and, for gradients, the same list backwards.
//
// A pass says which parts of the frame it reads, writes and adds to (after the graph of filters of Intel's Open Image Denoise).
// The model refuses a list in which a part is read before it is written, or changed after it has been read. In reverse a pass
// changes no values; it reads those of its parts, and reads and changes their gradients: the passes that wrote them come later.
// What else it reads or changes in reverse has lists of its own. tests/core/render/model/pass_access_test.cpp checks both directions.
#pragma once

#include <string_view>
#include <vector>

#include "core/render/model/frame.h"
#include "core/scene/surfels/splat_scene.h"

namespace vitrine {

enum class FramePart : unsigned char {
  DiffuseChannels,      // Frame::diffuse
  Linear,               // Frame::linear
  ShownShapes,          // Frame::silhouette.shapes
  Coats,                // Frame::coats
  Silhouettes,          // the rest of Frame::silhouette
  Sheets,               // Frame::sheets
  Surfaces,             // Frame::shaded, but for the two below
  ReflectionAskers,     // ShadedPixels::asks
  TransmissionAskers,   // likewise
  OpenedScene,          // Frame::opened
  BehindGlass,          // Frame::behind, but for picture_weight
  Panes,                // Frame::panes
  ReflectedRadiance,    // Frame::reflection, likewise
  TransmittedRadiance,  // Frame::transmission, likewise
  PictureWeights,       // picture_weight of these three
  LayerImages,          // Frame::layers
  Srgb,                 // Frame::srgb
  // Of the reverse alone.
  ErrorImage,               // Frame::error_image
  DiffuseStatistics,        // Frame::statistics
  ReflectionStatistics,     // statistics and took_part of Frame::reflection
  TransmittanceStatistics,  // likewise
};
inline constexpr size_t kFrameParts = static_cast<size_t>(FramePart::TransmittanceStatistics) + 1;
std::string_view name(FramePart part);  // "diffuse channels"

struct PassAccess {
  std::vector<FramePart> reads = {};   // as it will stay
  std::vector<FramePart> writes = {};  // as the first
  std::vector<FramePart> adds = {};    // reads and changes
  // In reverse, beside the values and gradients of the above.
  std::vector<FramePart> reverse_reads = {};
  std::vector<FramePart> reverse_adds = {};
};

class Pass {
 public:
  virtual ~Pass() = default;
  virtual std::string_view name() const = 0;
  virtual PassAccess access() const = 0;
  // Finds its options in frame.options.
  virtual void forward(const SplatScene& scene, Frame& frame) = 0;
  // Takes the gradients that later passes and the losses left in the frame one step back; adds to `grad`, and to the frame's
  // statistics of the layers, whose sums of zero ImageModel::backward() sets before.
  virtual void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) = 0;
};

}  // namespace vitrine
