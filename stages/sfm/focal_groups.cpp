#include "stages/sfm/focal_groups.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr size_t kSmallestGroup = 3;  // photos
constexpr double kApart = 1.15, kWithin = 1.10, kGroupedShare = 0.75;

}  // namespace

std::vector<FocalGroup> focal_groups(std::span<const double> focals) {
  std::vector<size_t> order;
  for (size_t i = 0; i < focals.size(); ++i)
    if (focals[i] > 0) order.push_back(i);
  std::ranges::stable_sort(order, {}, [&](size_t i) { return focals[i]; });
  // Runs without a gap of half the distance between groups.
  std::vector<FocalGroup> groups;
  const double gap = std::sqrt(kApart);
  for (size_t first = 0, i = 0; i < order.size(); ++i) {
    if (i + 1 < order.size() && focals[order[i + 1]] <= gap * focals[order[i]]) continue;
    if (i + 1 - first >= kSmallestGroup)
      groups.push_back({focals[order[(first + i + 1) / 2]], {order.begin() + long(first), order.begin() + long(i) + 1}});
    first = i + 1;
  }
  size_t grouped = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (g > 0 && groups[g].focal < kApart * groups[g - 1].focal) return {};
    const auto far = std::ranges::count_if(groups[g].members, [&](size_t i) {
      return focals[i] > kWithin * groups[g].focal || kWithin * focals[i] < groups[g].focal;
    });
    if (4 * size_t(far) > groups[g].members.size()) return {};
    grouped += groups[g].members.size();
  }
  if (groups.size() < 2 || double(grouped) < kGroupedShare * double(order.size())) return {};
  for (const size_t i : order) {
    const auto distance = [&](const FocalGroup& g) { return std::abs(std::log(focals[i] / g.focal)); };
    const bool in_one = std::ranges::any_of(groups, [&](const FocalGroup& g) { return std::ranges::count(g.members, i) > 0; });
    if (!in_one) std::ranges::min_element(groups, {}, distance)->members.push_back(i);
  }
  for (FocalGroup& g : groups) std::ranges::sort(g.members);
  return groups;
}

}  // namespace vitrine
