// Training steps of one opaque layer in the memory of a device, as the training on the host uses them: plain numbers and arrays
// of the host. Includes neither the table of a layer nor messages of errors, which nvcc does not compile; TrainingState is
// between it and the training. step_blocks.h is it over any executor.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/learn/loss/blocks/loss_blocks.h"

namespace vitrine::blocks {

// State of a training: values, Adam, statistics since the last densification. Arrays of the host [n, width], [n].
struct StepState {
  uint32_t surfels;
  uint32_t width[kAttributeCount];  // 0: the layer lacks it
  float *value[kAttributeCount], *m[kAttributeCount], *v[kAttributeCount];
  float *weight, *error, *screen_gradient, *share;  // SurfelAccumulator
  uint32_t *steps, *seen;
};

// A photo with its targets as they are kept, arrays of the host [h,w] or [3,h,w]; null: no data. They are copied once if the
// device has room for them, else for each step.
struct StepPhoto {
  uint32_t photo, level, pixels;
  const uint16_t* srgb;                                            // 65535 = 1
  const uint8_t *specular, *transparent, *object, *ignore, *coat;  // 255 = belongs to it
  const int16_t* normals;                                          // 32767 = 1
  const uint8_t* confidence;                                       // 255 = 1
};

struct StepDesc {
  BlockView view;
  float gain[3];
  float clipped;          // display-referred value from which a channel of the photo is a lower bound (raise_clipped)
  float specular_weight;  // of the picture losses on mirrors (StepPlan)
  bool withheld;          // the losses leave glass, mirrors and coats out
  LossFactors losses;
  float rates[kAttributeCount];
  float rarest;      // longest steps of surfels that few photos show
  uint32_t trained;  // surfels; those behind them stay
};

// What became of a step.
struct StepReport {
  double loss, l1;           // weighted sum of the losses; mean difference to the photo
  uint32_t active, skipped;  // DescentCounts
};

class StepPass {
 public:
  virtual ~StepPass() = default;
  // All throw ExecutorFailure. Replaces the state.
  virtual void put(const StepState& here) = 0;
  // Copies the state to arrays of its size.
  virtual void get(const StepState& here) = 0;
  virtual uint32_t surfels() const = 0;
  // Returns the report of the step before, unless report() gave it: that one has ended when this one has a picture, and nothing
  // waits for it.
  virtual std::optional<StepReport> step(const StepDesc& desc, const StepPhoto& photo) = 0;
  // Of the last step, once. Waits for the device.
  virtual std::optional<StepReport> report() = 0;
  struct Moved {
    uint32_t relocated, added;
  };
  // Relocation and growth (strategy `divide`); the statistics start again. Waits for the device.
  virtual Moved relocate(uint64_t seed, uint64_t step, double idle_weight, double growth, uint32_t cap) = 0;
  // Random walk of faint surfels (add_position_noise).
  virtual void walk(float strength, uint64_t seed, uint64_t step) = 0;
  // Display-referred, [3,h,w], to the host.
  virtual std::vector<float> picture(const BlockView& view, const float (&gain)[3]) = 0;
};

// On the CUDA device that CUDA chooses; as make_cuda_pass(). Only programs that link the target vitrine_cuda_steps have it.
std::unique_ptr<StepPass> make_cuda_steps(std::map<std::string, double>* kernel_ms = nullptr);

}  // namespace vitrine::blocks

namespace vitrine {

// As provide_device() of device.h, for training steps: they are used where chosen_device() is a device.
using StepPassMaker = std::unique_ptr<blocks::StepPass> (*)();
StepPassMaker provide_step_device(StepPassMaker maker);

}  // namespace vitrine
