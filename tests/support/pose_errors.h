// Errors of camera poses against true ones after the similarity between the two frames was taken out.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine::test {

// Similarity that takes `from` to `to` best (Umeyama 1991), by Horn's quaternion through power iteration on the 4x4 matrix.
inline Similarity aligned(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  const double n = double(from.size());
  Vec3d mf{}, mt{};
  for (size_t i = 0; i < from.size(); ++i) mf += from[i] / n, mt += to[i] / n;
  double s[3][3] = {}, ff = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Vec3d a = from[i] - mf, b = to[i] - mt;
    ff += squared_length(a);
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 3; ++c) s[r][c] += a[r] * b[c];
  }
  const double m[4][4] = {{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
                          {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
                          {s[2][0] - s[0][2], s[0][1] + s[1][0], -s[0][0] + s[1][1] - s[2][2], s[1][2] + s[2][1]},
                          {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], -s[0][0] - s[1][1] + s[2][2]}};
  double shift = 0;  // makes the wanted eigenvalue the largest in size
  for (const auto& row : m)
    for (double v : row) shift += std::abs(v);
  double q[4] = {0.5, 0.5, 0.5, 0.5};
  for (int step = 0; step < 20000; ++step) {
    double next[4], norm = 0;
    for (int r = 0; r < 4; ++r) {
      next[r] = shift * q[r];
      for (int c = 0; c < 4; ++c) next[r] += m[r][c] * q[c];
      norm += next[r] * next[r];
    }
    for (int r = 0; r < 4; ++r) q[r] = next[r] / std::sqrt(norm);
  }
  Similarity out;
  out.rotation = rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]}));
  double ft = 0;
  for (size_t i = 0; i < from.size(); ++i) ft += dot(out.rotation * (from[i] - mf), to[i] - mt);
  out.scale = ft / ff;
  out.translation = mt - out.scale * (out.rotation * mf);
  return out;
}

struct PoseErrors {
  double rotation_deg = 0, centre_rel = 0, up_deg = 0;  // worst over the views; centre_rel in units of the frame of `got`
};

inline PoseErrors pose_errors(const std::vector<View>& got, const std::vector<View>& truth) {
  std::vector<Vec3d> from, to;
  std::vector<std::pair<const View*, const View*>> pairs;
  for (const View& g : got)
    for (const View& t : truth)
      if (std::filesystem::path(g.name).stem() == std::filesystem::path(t.name).stem()) {
        pairs.push_back({&g, &t});
        from.push_back(t.centre_in_world());
        to.push_back(g.centre_in_world());
      }
  const Similarity got_from_truth = aligned(from, to);
  PoseErrors e;
  for (const auto& [g, t] : pairs) {
    const Mat3d difference = g->cam_from_world.rotation * got_from_truth.rotation * transposed(t->cam_from_world.rotation);
    const double cosine = 0.5 * (difference(0, 0) + difference(1, 1) + difference(2, 2) - 1);
    e.rotation_deg = std::max(e.rotation_deg, std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
    e.centre_rel = std::max(e.centre_rel, length(g->centre_in_world() - got_from_truth * t->centre_in_world()));
  }
  e.up_deg = std::acos(std::clamp(got_from_truth.rotation.c2.z, -1.0, 1.0)) * 180 / std::numbers::pi;
  return e;
}

}  // namespace vitrine::test
