#include "core/render/picture/panorama_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/color.h"
#include "core/scene/camera/equirect.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

// Half the field of view of a face: 5 degrees of overlap on each side of an edge of the cube.
double half_angle() { return 50 * std::numbers::pi / 180; }

// face_from_panorama, as rows right, down, forward in the panorama's frame.
std::array<Mat3d, 6> cube_faces() {
  const auto facing = [](const Vec3d& down, const Vec3d& forward) {
    return transposed(Mat3d{cross(down, forward), down, forward});
  };
  const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {facing(y, z), facing(y, x), facing(y, -z), facing(y, -x), facing(-z, y), facing(z, -y)};
}

// Pixel of a direction in a face, and its weight there: 1 up to 40 degrees from the axis, 0 from 50 degrees on.
struct FacePixel {
  Vec2d at;
  double weight = 0;
};
FacePixel face_pixel(const Vec3d& in_face, const Intrinsics& k) {
  if (!(in_face.z > 0)) return {};
  const double widest = std::tan(half_angle()), inner = 1 / widest;
  const auto ramp = [&](double u) { return std::clamp((widest - std::abs(u)) / (widest - inner), 0.0, 1.0); };
  const ImagePoint p = projected(in_face, k);
  return {{p.x, p.y}, ramp(in_face.x / in_face.z) * ramp(in_face.y / in_face.z)};
}

// Maps of one kind of all faces, blended into a panorama.
class Faces {
 public:
  Faces(int width, int side) : width_(width), faces_(cube_faces()) {
    const double focal = 0.5 * side / std::tan(half_angle());
    intrinsics_ = {side, side, focal, focal, 0.5 * side, 0.5 * side};
  }
  const Intrinsics& intrinsics() const { return intrinsics_; }
  View view(const View& panorama, size_t face) const {
    View v = panorama;
    v.intrinsics = intrinsics_;
    v.cam_from_world = Rigid{faces_[face], {}} * panorama.cam_from_world;
    return v;
  }

  ImageF blended(const std::array<const ImageF*, 6>& maps) const {
    ImageF out(width_, width_ / 2, maps[0]->channels());
    for_each_pixel(out, [&](const Vec3d& direction, float* pixel) {
      std::array<float, 4> sample{};
      double total = 0;
      for (size_t f = 0; f < 6; ++f) {
        const FacePixel p = face_pixel(faces_[f] * direction, intrinsics_);
        if (p.weight <= 0) continue;
        sample_bilinear(*maps[f], p.at.x, p.at.y, sample.data());
        for (int c = 0; c < out.channels(); ++c) pixel[c] += float(p.weight) * sample[size_t(c)];
        total += p.weight;
      }
      for (int c = 0; c < out.channels(); ++c) pixel[c] /= float(total);
    });
    return out;
  }
  // Distances from z-depths: of the nearest pixel of the nearest face, since a mean of two surfaces lies on none.
  ImageF distances(const std::array<const ImageF*, 6>& zdepths) const {
    ImageF out(width_, width_ / 2, 1);
    for_each_pixel(out, [&](const Vec3d& direction, float* pixel) {
      size_t nearest = 0;
      for (size_t f = 1; f < 6; ++f)
        if ((faces_[f] * direction).z > (faces_[nearest] * direction).z) nearest = f;
      const Vec3d in_face = faces_[nearest] * direction;
      const ImagePoint p = projected(in_face, intrinsics_);
      *pixel = zdepths[nearest]->at(int(p.x), int(p.y)) / float(in_face.z);
    });
    return out;
  }

 private:
  template <class Body>
  void for_each_pixel(ImageF& out, const Body& body) const {
    parallel_for(size_t(out.height()), 4, [&](size_t row) {
      const int y = int(row);
      for (int x = 0; x < out.width(); ++x)
        body(equirect_direction(x + 0.5, y + 0.5, out.width(), out.height()), out.pixel(x, y));
    });
  }

  int width_;
  std::array<Mat3d, 6> faces_;
  Intrinsics intrinsics_;
};

// Blended normals are as long as the faces agree.
ImageF unit_length(ImageF normals) {
  for (size_t i = 0; i < normals.data().size(); i += 3) {
    float* n = &normals.data()[i];
    const float size = std::hypot(n[0], n[1], n[2]);
    for (int c = 0; c < 3; ++c) n[c] = size > 0 ? n[c] / size : 0;
  }
  return normals;
}

}  // namespace

View upright_panorama(const View& view) {
  const Mat3d& r = view.cam_from_world.rotation;
  const Vec3d forward = transposed_times(r, Vec3d{0, 0, 1}), top = transposed_times(r, Vec3d{0, -1, 0});
  constexpr double kLevel = 0.1;  // of the forward axis that must be horizontal
  const auto level = [](const Vec3d& v) { return Vec3d{v.x, v.y, 0}; };
  const Vec3d heading = normalized(length(level(forward)) > kLevel ? level(forward) : level(top));
  const Vec3d down{0, 0, -1};
  View out = view;
  out.cam_from_world.rotation = transposed(Mat3d{cross(down, heading), down, heading});
  out.cam_from_world.translation = -(out.cam_from_world.rotation * view.centre_in_world());
  return out;
}

int panorama_width(const Intrinsics& k) { return std::max(4 * int(std::lround(0.5 * std::numbers::pi * k.fx)), 8); }

ViewPicture panorama_picture(ScenePainter& painter, const View& view, int width) {
  const double focal = width / (2 * std::numbers::pi);
  const Faces faces(width, std::max(int(std::ceil(2 * focal * std::tan(half_angle()))), 4));
  std::array<ViewPicture, 6> pictures;
  for (size_t f = 0; f < 6; ++f) {
    throw_if_interrupted();
    pictures[f] = painter.picture(faces.view(view, f));
  }
  const auto of_all = [&](const auto& member) {
    std::array<const ImageF*, 6> maps{};
    for (size_t f = 0; f < 6; ++f) maps[f] = &member(pictures[f]);
    return maps;
  };
  ViewPicture out;
  out.intrinsics = {width, width / 2, focal, focal, 0.5 * width, 0.25 * width};
  out.linear = faces.blended(of_all([](const ViewPicture& p) -> const ImageF& { return p.linear; }));
  out.srgb = displayed(out.linear, view.gain);
  out.zdepth = faces.distances(of_all([](const ViewPicture& p) -> const ImageF& { return p.zdepth; }));
  out.normal_in_world =
      unit_length(faces.blended(of_all([](const ViewPicture& p) -> const ImageF& { return p.normal_in_world; })));
  for (size_t l = 0; l < pictures[0].layers.size(); ++l) {
    PictureLayer layer = pictures[0].layers[l];
    if (layer.name == "depth")
      layer.map.pixels = out.zdepth;
    else if (layer.name == "normal")
      layer.map.pixels = out.normal_in_world;
    else
      layer.map.pixels = faces.blended(of_all([l](const ViewPicture& p) -> const ImageF& { return p.layers[l].map.pixels; }));
    out.layers.push_back(std::move(layer));
  }
  return out;
}

}  // namespace vitrine
