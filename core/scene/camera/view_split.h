// optimize/views.json: which views were trained on, which were held out, and how large they were.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

struct ViewSplit {
  int holdout_every = 0;
  int max_side = 0;                    // longest side in training, pixels; 0 = as the photos
  std::vector<size_t> train, heldout;  // indices into the views
  bool object_alone = false;           // trained inside the object's masks only: nothing else is in the scene
};
// Throws Error{Input} when the file is broken or names a view that the capture does not have.
ViewSplit read_view_split(const std::filesystem::path& path, const std::vector<View>& views);
// Those of `views`, as large as they were in training.
std::vector<View> at_trained_size(const std::vector<View>& views, const std::vector<size_t>& indices, const ViewSplit& split);

}  // namespace vitrine
