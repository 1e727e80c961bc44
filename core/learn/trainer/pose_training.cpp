#include "core/learn/trainer/pose_training.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/raster/kernels/shade.h"

namespace vitrine {

namespace {

constexpr double kPoseBeta1 = 0.7, kPoseBeta2 = 0.98;

template <class T>
Vec3d vec_of(const T* v) {
  return {double(v[0]), double(v[1]), double(v[2])};
}

// Axis times radians of a rotation by a small angle.
Vec3d turn_of(const Mat3d& rotation) {
  const Quatd q = quaternion(rotation);
  const double sign = q.w < 0 ? -2 : 2;
  return {sign * q.x, sign * q.y, sign * q.z};
}

}  // namespace

PoseGradient pose_gradient(const SplatLayer& layer, const SplatLayer& grad, const Rigid& cam_from_world, int sh_degree) {
  const Vec3d eye = inverse(cam_from_world).translation;
  const size_t rest = layer.width(Attribute::ShRest);
  Vec3d turn{}, shift{};
  for (size_t i = 0; i < layer.size(); ++i) {
    const Vec3d g = vec_of(grad.at(Attribute::Mean, i)), mean = vec_of(layer.at(Attribute::Mean, i)), offset = mean - eye;
    const float *q = layer.at(Attribute::Rotation, i), *h = grad.at(Attribute::Rotation, i);
    const double w = q[0], x = q[1], y = q[2], z = q[3], gw = h[0], gx = h[1], gy = h[2], gz = h[3];
    Vec3d torque = cross(offset, g) + 0.5 * Vec3d{-x * gw + w * gx - z * gy + y * gz, -y * gw + z * gx + w * gy - x * gz,
                                                  -z * gw - y * gx + x * gy + w * gz};
    if (sh_degree > 0 && rest > 0) {
      double coefficients[3 * kMaxShCoefficients]{}, unused[3 * kMaxShCoefficients];
      for (size_t c = 0; c < 3; ++c) coefficients[c] = layer.at(Attribute::ShDc, i)[c];
      for (size_t c = 0; c < rest; ++c) coefficients[3 + c] = layer.at(Attribute::ShRest, i)[c];
      const ShColour<double> colour = sh_colour(sh_degree, mean, eye, coefficients);
      const Vec3d of_value = (1 / double(kShDc)) * vec_of(grad.at(Attribute::ShDc, i));
      torque = torque - cross(offset, sh_colour_vjp(sh_degree, colour, coefficients, of_value, unused));
    }
    const double check = dot(torque, torque) + dot(g, g);
    if (!std::isfinite(check)) continue;
    turn = turn + torque;
    shift = shift + g;
  }
  return {cam_from_world.rotation * turn, cam_from_world.rotation * shift};
}

Rigid moved_pose(const Rigid& cam_from_world, const Vec3d& turn, const Vec3d& shift) {
  const Rigid motion{rotation_matrix(normalized(Quatd{1, 0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z})), shift};
  return motion * cam_from_world;
}

PoseTraining::PoseTraining(std::vector<View> photos) : given_(std::move(photos)), now_(given_), moments_(given_.size()) {}

void PoseTraining::descend(size_t photo, const PoseGradient& g, const PoseRates& rates) {
  const double turn = dot(g.turn, g.turn) / 3, shift = dot(g.shift, g.shift) / 3;
  if (!std::isfinite(turn + shift) || !(turn > 0) || !(shift > 0)) return;
  ++steps_;
  turn_square_ = kPoseBeta2 * turn_square_ + (1 - kPoseBeta2) * turn;
  shift_square_ = kPoseBeta2 * shift_square_ + (1 - kPoseBeta2) * shift;
  Moment& m = moments_[photo];
  ++m.steps;
  m.mean.turn = kPoseBeta1 * m.mean.turn + (1 - kPoseBeta1) * g.turn;
  m.mean.shift = kPoseBeta1 * m.mean.shift + (1 - kPoseBeta1) * g.shift;
  const double c1 = 1 / (1 - std::pow(kPoseBeta1, double(m.steps))), c2 = 1 / (1 - std::pow(kPoseBeta2, double(steps_)));
  set(photo, moved_pose(pose(photo), (-rates.turn * c1 / std::sqrt(c2 * turn_square_)) * m.mean.turn,
                        (-rates.shift * c1 / std::sqrt(c2 * shift_square_)) * m.mean.shift));
}

void PoseTraining::hold_mean(std::span<const uint32_t> photos) {
  if (photos.empty()) return;
  Vec3d turn{}, shift{}, centre{};
  for (const uint32_t photo : photos) {
    turn = turn + turn_of(transposed(pose(photo).rotation) * given_[photo].cam_from_world.rotation);
    centre = centre + given_[photo].centre_in_world();
    shift = shift + (now_[photo].centre_in_world() - given_[photo].centre_in_world());
  }
  const double part = 1 / double(photos.size());
  // The world moves before all cameras, x -> R (x - at) + at + shift, which takes the mean motion of the cameras back.
  const Mat3d R = rotation_matrix(normalized(Quatd{1, 0.5 * part * turn.x, 0.5 * part * turn.y, 0.5 * part * turn.z}));
  const Vec3d at = part * centre;
  const Rigid back{R, at + part * shift - R * at};
  for (View& view : now_) view.cam_from_world = view.cam_from_world * back;
}

void PoseTraining::restart() {
  moments_.assign(moments_.size(), {});
  turn_square_ = shift_square_ = 0;
  steps_ = 0;
}

PoseDistance PoseTraining::moved(std::span<const uint32_t> photos) const {
  PoseDistance d;
  if (photos.empty()) return d;
  for (const uint32_t photo : photos) {
    const double turn = length(turn_of(transposed(pose(photo).rotation) * given_[photo].cam_from_world.rotation));
    const double shift = length(now_[photo].centre_in_world() - given_[photo].centre_in_world());
    d.turn_rad += turn * turn / double(photos.size()), d.shift += shift * shift / double(photos.size());
    d.largest_turn_rad = std::max(d.largest_turn_rad, turn), d.largest_shift = std::max(d.largest_shift, shift);
  }
  d.turn_rad = std::sqrt(d.turn_rad), d.shift = std::sqrt(d.shift);
  return d;
}

void PoseTraining::transfer(Archive& archive) {
  const size_t photos = given_.size();
  std::vector<Rigid> poses;
  for (const View& view : now_) poses.push_back(view.cam_from_world);
  archive.array(poses);
  archive.array(moments_);
  archive.value(turn_square_);
  archive.value(shift_square_);
  archive.value(steps_);
  if (poses.size() != photos || moments_.size() != photos) archive.fail("it has other photos");
  for (size_t i = 0; i < photos; ++i) set(i, poses[i]);
}

}  // namespace vitrine
