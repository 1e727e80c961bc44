// Which photo a name means that stands in somebody's file: a pose, a mask, a mark. The one place that decides it.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>

#include "core/camera/photo_list.h"

namespace vitrine {

// Tries the strictest rule first: the photo's name as it is, its path below the photo folder, its file name, its stem. A key that
// two photos share decides nothing.
class PhotoFinder {
 public:
  explicit PhotoFinder(std::span<const Photo> photos);
  // Index of the photo; nullopt when none or more than one has that name.
  std::optional<size_t> operator()(const std::string& name) const;

 private:
  static constexpr size_t kRules = 6;
  void note(size_t rule, const std::string& key, size_t photo);
  std::map<std::string, std::optional<size_t>> keys_[kRules];
};

}  // namespace vitrine
