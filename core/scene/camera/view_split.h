// Training split, optimize/views.json: training views, held-out views, image size in training.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

struct ViewSplit {
  int holdout_every = 0;
  int max_side = 0;                    // longest side in training, pixels; 0 = full size
  std::vector<size_t> train, heldout;  // indices into the views
  bool object_alone = false;           // trained inside the object masks only: the scene contains the object alone
};
// Throws Error{Input} if the file is invalid or names a view that is not in the capture.
ViewSplit read_view_split(const std::filesystem::path& path, const std::vector<View>& views);
// Selected `views` at their training size.
std::vector<View> at_trained_size(const std::vector<View>& views, const std::vector<size_t>& indices, const ViewSplit& split);

}  // namespace vitrine
