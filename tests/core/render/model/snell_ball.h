// A ball of solid glass in a room whose walls have many colours, of which everything is known: where a ray leaves the ball by
// Snell's law in closed form, and what colour the wall has there.
#pragma once

#include <optional>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/render/model/image_options.h"
#include "core/scene/surfels/splat_scene.h"
#include "core/render/trace/tracer.h"
#include "tests/support/spheres.h"

namespace vitrine::test {

struct BallPassage {
  double entry_distance = 0, offset = 0;  // offset: of the ray from the centre, in radii
  Vec3d exit, direction;
};

// nullopt: passes beside it. In the plane of ray and centre the ray turns by i - r where it enters and again where it leaves;
// a ray that got in always gets out.
inline std::optional<BallPassage> through_ball(const Vec3d& eye, const Vec3d& d, const Vec3d& centre, double radius, double ior) {
  const Vec3d o = eye - centre;
  const double b = dot(o, d), root = b * b - dot(o, o) + radius * radius;
  if (!(root > 0 && b < 0)) return std::nullopt;
  const Vec3d nearest = o - b * d;
  BallPassage p{.entry_distance = -b - std::sqrt(root), .offset = length(nearest) / radius, .exit = {}, .direction = {}};
  const double i = std::asin(p.offset), r = std::asin(p.offset / ior);
  const Vec3d side = p.offset > 1e-9 ? nearest / length(nearest) : normalized(cross(d, Vec3d{0.3, 0.5, 0.8}));
  const auto in_plane = [&](double angle) { return std::cos(angle) * d + std::sin(angle) * side; };
  // Seen from the centre the entry stands at angle pi - i from d; the chord spans pi - 2 r.
  p.exit = centre + radius * in_plane(2 * r - i);
  p.direction = in_plane(-2 * (i - r));
  return p;
}

// A ball of glass in the middle of a painted ball-shaped room.
struct GlassBallScene {
  static constexpr double kBall = 0.4, kRoom = 2.0;
  static constexpr double kIor = 1.5;
  SplatScene scene;
  SplatLayer wall;

  GlassBallScene() : wall(painted_room()) {
    SplatLayer& diffuse = scene.diffuse = sphere_layer(kBall);
    std::ranges::fill(diffuse.values(Attribute::Transmission), 6.f);
    const size_t glass = diffuse.size();
    diffuse.resize(glass + wall.size());
    for (size_t i = 0; i < wall.size(); ++i)
      for (const AttributeRow& row : kAttributes)
        std::copy_n(wall.at(row.id, i), wall.width(row.id), diffuse.at(row.id, glass + i));
    std::ranges::fill(diffuse.values(Attribute::SpecularWeight), -6.f);
    // Glass shows something while there is a layer; this is a grain of dust on the wall.
    SplatLayer& dust = scene.transmittance = SplatLayer(LayerKind::Transmittance, 0, 1);
    for (size_t c = 0; c < 2; ++c) dust.at(Attribute::LogScale, 0)[c] = -5;
    dust.at(Attribute::Rotation, 0)[0] = 1;
    dust.at(Attribute::Mean, 0)[2] = float(0.95 * kRoom);
  }

  static ImageOptions image() {
    ImageOptions options;
    options.transmission.glass = Glass::Thin;
    options.diffuse.sh_degree = options.transmission.sh_degree = 0;
    return options;
  }
  static View view(double azimuth_rad, double height = 0.2) {
    View v;
    v.intrinsics = {64, 48, 70, 70, 32, 24};
    v.cam_from_world = looking_at({std::cos(azimuth_rad), std::sin(azimuth_rad), height}, {});
    return v;
  }
  static Vec3d direction(const View& v, size_t pixel) {
    const auto width = size_t(v.intrinsics.width);
    return transposed_times(v.cam_from_world.rotation,
                            normalized(v.intrinsics.ray(double(pixel % width) + 0.5, double(pixel / width) + 0.5)));
  }
  static std::optional<BallPassage> through(const View& v, size_t pixel) {
    return through_ball(v.centre_in_world(), direction(v, pixel), {}, kBall, kIor);
  }

  // [h,w,3] radiance times gain, as a camera would take it of a ball of solid glass; reflections are left out, as the scene has
  // none.
  ImageF photo(const View& v) const {
    ImageF out(v.intrinsics.width, v.intrinsics.height, 3);
    std::vector<Vec3f> origins, directions;
    for (size_t i = 0; i < out.pixel_count(); ++i) {
      const auto bent = through(v, i);
      origins.push_back(cast<float>(bent ? bent->exit : v.centre_in_world()));
      directions.push_back(cast<float>(bent ? bent->direction : direction(v, i)));
    }
    const std::vector<Vec3f> colors = wall_colors(origins, directions);
    for (size_t i = 0; i < colors.size(); ++i)
      for (size_t c = 0; c < 3; ++c) out.data()[3 * i + c] = float(v.gain[c]) * colors[i][c];
    return out;
  }
  std::vector<Vec3f> wall_colors(std::span<const Vec3f> origins, std::span<const Vec3f> directions) const {
    const auto tracer = make_tracer();
    tracer->build(wall);
    RayValues values;
    tracer->forward({.origins = origins, .directions = directions}, {.sh_degree = 0}, values, nullptr);
    return values.color;
  }

 private:
  static SplatLayer painted_room() {
    SplatLayer layer = sphere_layer(kRoom, 4000);
    for (size_t i = 0; i < layer.size(); ++i) {
      const float* p = layer.at(Attribute::Mean, i);
      for (size_t c = 0; c < 3; ++c)
        layer.at(Attribute::ShDc, i)[c] = 0.4f / kShDc * std::sin(2.5f * p[c] + 1.5f * p[(c + 1) % 3] + float(c));
    }
    std::ranges::fill(layer.values(Attribute::Transmission), -6.f);
    return layer;
  }
};

}  // namespace vitrine::test
