#include "tests/captures/turned_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/ldr.h"
#include "core/foundation/math/color.h"
#include "sample_data/generate/ray_scene.h"

namespace vitrine::test {

namespace {

using namespace generate;

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr Intrinsics kCamera{560, 420, 520, 520, 280, 210};
constexpr Vec3f kBackdrop{0.30f, 0.31f, 0.33f};
constexpr int kJpegQuality = 95;

// ---- the object: one unit long, every side has another form

float box_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& half) {
  const Vec3f d = p - centre;
  const Vec3f q{std::abs(d.x) - half.x, std::abs(d.y) - half.y, std::abs(d.z) - half.z};
  const Vec3f outside{std::max(q.x, 0.0f), std::max(q.y, 0.0f), std::max(q.z, 0.0f)};
  return length(outside) + std::min(std::max({q.x, q.y, q.z}), 0.0f);
}

float object_distance(const Vec3f& p) {
  constexpr float kJoint = 0.06f;
  float d = ellipsoid_distance(p, {0, 0, 0}, {0.46f, 0.33f, 0.25f});
  d = smooth_union(d, box_distance(p, {0.22f, 0.10f, 0.12f}, {0.16f, 0.12f, 0.20f}) - 0.02f, kJoint);
  d = smooth_union(d, ellipsoid_distance(p, {-0.28f, -0.16f, 0.16f}, {0.16f, 0.20f, 0.17f}), kJoint);
  d = smooth_union(d, capsule_distance(p, {-0.10f, 0.20f, -0.05f}, {-0.38f, 0.34f, -0.16f}, 0.12f, 0.07f), kJoint);
  d = smooth_union(d, box_distance(p, {0.10f, -0.18f, -0.18f}, {0.20f, 0.12f, 0.10f}) - 0.02f, kJoint);
  return d;
}

// Cells of three sizes, bright and dark, each with a little colour. Nothing repeats: marks that look alike give false matches.
Vec3f object_albedo(const SurfacePoint& s) {
  constexpr std::array<float, 3> kCells{6, 13, 29}, kContrast{1.0f, 1.3f, 0.9f};
  Vec3f c{0.36f, 0.32f, 0.28f};
  for (size_t scale = 0; scale < kCells.size(); ++scale) {
    const CellNoise cell = cell_noise(kCells[scale] * s.position, uint32_t(scale) + 5);
    const auto random = [&](int k) { return unit_float(lattice_hash(int(cell.cell >> 8), k, 0, 7)) - 0.5f; };
    const float bright = 1 + kContrast[scale] * random(0);
    const Vec3f inside = bright * Vec3f{1 + 0.5f * random(1), 1 + 0.5f * random(2), 1 + 0.5f * random(3)};
    const Vec3f between{0.6f, 0.6f, 0.6f};  // the same on both sides of an edge: a step would alias
    const Vec3f factor = mixed(between, inside, smooth_step(0, 0.14f, cell.second - cell.nearest));
    for (size_t k = 0; k < 3; ++k) c[k] *= factor[k];
  }
  for (size_t k = 0; k < 3; ++k) c[k] = std::clamp(1.2f * c[k], 0.02f, 0.8f);
  return c;
}

// ---- what the object lies on

constexpr float kChartWidth = 0.42f, kChartHeight = 0.28f;

// Patches of grey and of colour in black frames; a scale bar and a resolution target along the long sides.
Vec3f chart_albedo(const SurfacePoint& s) {
  constexpr float kPatch = 0.07f, kFrame = 0.01f, kStrip = 0.035f;
  const float x = s.uv.x, y = s.uv.y;
  if (y < kStrip) {  // scale bar
    const bool odd = int(x / 0.02f) % 2 == 1, lower = y < kStrip / 2;
    return odd == lower ? Vec3f{0.03f, 0.03f, 0.03f} : Vec3f{0.85f, 0.85f, 0.85f};
  }
  if (y > kChartHeight - kStrip) {
    const CellNoise cell = cell_noise({65 * x, 65 * y, 0.5f}, 3);
    const float v = cell.cell & 0x100u ? 0.8f : 0.05f;
    return {v, v, v};
  }
  const float u = std::fmod(x, kPatch), v = std::fmod(y - kStrip, kPatch);
  if (u < kFrame || u > kPatch - kFrame || v < kFrame || v > kPatch - kFrame) return {0.02f, 0.02f, 0.02f};
  const int column = int(x / kPatch), row = int((y - kStrip) / kPatch);
  if (row == 0) {
    constexpr std::array<float, 6> kGreys{0.90f, 0.59f, 0.36f, 0.19f, 0.09f, 0.03f};
    const float grey = kGreys[size_t(column)];
    return {grey, grey, grey};
  }
  const auto channel = [&](int k) { return 0.05f + 0.75f * unit_float(lattice_hash(column, row, k, 11)); };
  return {channel(0), channel(1), channel(2)};
}

// A ring of printed marks around the object, black on the plate's white.
bool printed(const Vec3f& p, float angle) {
  constexpr float kInner = 0.56f, kOuter = 0.78f, kCells = 22;
  const float radius = std::hypot(p.x, p.y);
  if (radius < kInner || radius > kOuter) return false;
  const Vec3f turned{std::cos(angle) * p.x + std::sin(angle) * p.y, std::cos(angle) * p.y - std::sin(angle) * p.x, 0.5f};
  const CellNoise cell = cell_noise({kCells * turned.x, kCells * turned.y, turned.z}, 17);
  return (cell.cell & 0x300u) == 0 && cell.second - cell.nearest > 0.05f;
}

Part part(Shape shape, Texture albedo) {
  return {.name = "part", .shape = std::move(shape), .material = {.albedo = std::move(albedo)}};
}

Scene plate_and_chart(const PassDesc& desc, const Vec3f& chart_centre, float chart_angle) {
  constexpr float kTable = 8, kPlateRadius = 1.25f, kThickness = 0.004f;
  Scene scene;
  scene.parts.push_back(part(rectangle({-kTable, -kTable, 0}, {2 * kTable, 0, 0}, {0, 2 * kTable, 0}, 2 * kTable),
                             [desc, chart_angle](const SurfacePoint& s) {
                               if (std::hypot(s.position.x, s.position.y) > kPlateRadius) return kBackdrop;
                               if (desc.marks && printed(s.position, chart_angle)) return Vec3f{0.03f, 0.03f, 0.03f};
                               return Vec3f{desc.plate, desc.plate, desc.plate};
                             }));
  const Vec3f along{std::cos(chart_angle), std::sin(chart_angle), 0}, across{-along.y, along.x, 0};
  const Vec3f width = kChartWidth * along, height = kChartHeight * across;
  scene.parts.push_back(
      part(rectangle(chart_centre + Vec3f{0, 0, kThickness} - 0.5f * (width + height), width, height, 1), chart_albedo));
  return scene;
}

Scene room() {
  constexpr float kHalf = 2.5f, kHeight = 3;
  const Texture speckles = [](const SurfacePoint& s) {
    const CellNoise cell = cell_noise(11.0f * s.position, 21);
    const float v = unit_float(cell.cell), w = unit_float(cell.cell * 0x9e3779b1u);
    return Vec3f{0.1f + 0.8f * v, 0.1f + 0.8f * w, 0.4f};
  };
  const Vec3f a{-kHalf, -kHalf, 0}, b{kHalf, -kHalf, 0}, d{-kHalf, kHalf, 0}, up{0, 0, kHeight};
  Scene scene;
  scene.parts.push_back(part(rectangle(a, b - a, d - a, 1), speckles));
  scene.parts.push_back(part(rectangle(a, d - a, up, 1), speckles));
  scene.parts.push_back(part(rectangle(b, a - b, up, 1), speckles));
  return scene;
}

// ---- pictures

struct Rest {
  Rigid world_from_object;
  double height = 0;
};

// The object in its own frame, and how it lies in the frame of the plate.
class Object {
 public:
  Object() {
    constexpr float kCell = 0.02f;
    scene_.parts.push_back(part(meshed(object_distance, {{-0.7, -0.7, -0.6}, {0.7, 0.7, 0.6}}, kCell), object_albedo));
    rays_ = std::make_unique<RayScene>(scene_);
    for (const Vec3f& p : scene_.parts[0].shape.mesh.positions) radius_ = std::max(radius_, length(p));
  }
  std::optional<Hit> first_hit(const Vec3f& origin, const Vec3f& direction) const {
    return may_meet(origin, direction) ? rays_->first_hit(origin, direction) : std::nullopt;
  }
  bool blocks(const Vec3f& origin, const Vec3f& direction) const {
    constexpr float kFar = 100;
    return may_meet(origin, direction) && rays_->transmittance(origin, direction, kFar) == 0;
  }
  // Turned by `rotation`, its lowest point on the plate.
  Rest resting(const Mat3d& rotation) const {
    Bounds3 bounds;
    for (const Vec3f& p : scene_.parts[0].shape.mesh.positions) bounds.extend(rotation * cast<double>(p));
    return {{rotation, {0, 0, -bounds.low.z}}, bounds.high.z - bounds.low.z};
  }

 private:
  // Most rays miss the sphere around the object: no tree is asked then.
  bool may_meet(const Vec3f& origin, const Vec3f& direction) const {
    return squared_length(origin - dot(origin, direction) * direction) <= radius_ * radius_;
  }

  Scene scene_;
  std::unique_ptr<RayScene> rays_;
  float radius_ = 0;
};

struct Placement {
  Rigid cam_from_world, world_from_object;
};

class ObjectStudio {
 public:
  ObjectStudio(const Object& object, Scene surroundings)
      : object_(object), surroundings_(std::move(surroundings)), rays_(surroundings_) {}

  TakenPhoto taken(const Placement& photo) const {
    constexpr int kSide = 2, kSamples = kSide * kSide;
    TakenPhoto out{.linear = ImageF(kCamera.width, kCamera.height, 3, 0.0f),
                   .object = Image8(kCamera.width, kCamera.height, 1, uint8_t{0}),
                   .cam_from_object = photo.cam_from_world * photo.world_from_object};
    const Rigid world_from_cam = inverse(photo.cam_from_world);
    parallel_for(size_t(kCamera.height), 4, [&](size_t row) {
      for (int x = 0; x < kCamera.width; ++x) {
        int on_object = 0;
        for (int s = 0; s < kSamples; ++s) {
          const double px = x + (s % kSide + 0.5) / kSide, py = double(row) + (s / kSide + 0.5) / kSide;
          const Seen seen = seen_along(photo.world_from_object, world_from_cam.translation,
                                       normalized(world_from_cam.rotation * kCamera.ray(px, py)));
          on_object += seen.object;
          for (size_t k = 0; k < 3; ++k) out.linear.at(x, int(row), int(k)) += seen.radiance[k] / kSamples;
        }
        out.object.at(x, int(row)) = 2 * on_object >= kSamples ? 255 : 0;
      }
    });
    return out;
  }

 private:
  struct Seen {
    Vec3f radiance;
    bool object = false;
  };

  Seen seen_along(const Rigid& world_from_object, const Vec3d& origin, const Vec3d& direction) const {
    constexpr float kAmbient = 0.65f;
    const Vec3d light = normalized(Vec3d{0.35, 0.5, 1.0});
    const Rigid object_from_world = inverse(world_from_object);
    const auto in_object = [&](const Vec3d& p) { return cast<float>(object_from_world * p); };
    const auto turned_to_object = [&](const Vec3d& d) { return cast<float>(object_from_world.rotation * d); };
    const auto around = rays_.first_hit(cast<float>(origin), cast<float>(direction));
    const auto hit = object_.first_hit(in_object(origin), turned_to_object(direction));
    const bool object = hit && (!around || hit->distance < around->distance);
    if (!object && !around) return {kBackdrop};
    const Hit& h = object ? *hit : *around;
    const Vec3f towards_light = object ? turned_to_object(light) : cast<float>(light);
    // Shadows fall from the object alone.
    const Vec3f start = offset_origin(h, towards_light);
    const Vec3f start_in_object = object ? start : in_object(cast<double>(start));
    const float lit = object_.blocks(start_in_object, turned_to_object(light)) ? 0.0f : 1.0f;
    const float shade = kAmbient + (1 - kAmbient) * lit * std::max(0.0f, dot(h.normal, towards_light));
    return {shade * h.part->material.albedo({h.position, h.normal, h.uv}), object};
  }

  const Object& object_;
  Scene surroundings_;
  RayScene rays_;
};

// ---- captures

Mat3d turned_about(const Vec3d& axis, double angle) {
  const Vec3d a = std::sin(angle / 2) * normalized(axis);
  return rotation_matrix(Quatd{std::cos(angle / 2), a.x, a.y, a.z});
}

// By hand: never by exactly half a turn.
Mat3d orientation(Lying lying) {
  const Vec3d up{0, 0, 1};
  switch (lying) {
    case Lying::AsItIs:
      return Mat3d::identity();
    case Lying::TurnedOver:
      return turned_about(up, 0.8) * turned_about({1, 0.1, 0}, 3.05);
    case Lying::OnItsSide:
      return turned_about(up, -0.5) * turned_about({0.1, 1, 0}, 1.5);
  }
  return {};
}

// Unevenly spaced and now higher, now lower; no two passes have the same cameras.
Rigid camera(PassCameras kind, size_t pass, size_t i, size_t count, double middle) {
  const double azimuth = 0.3 * double(pass) + kFullTurn * (double(i) + 0.1 * std::sin(3.0 * double(i + pass))) / double(count);
  const double wave = std::sin(2 * azimuth + double(pass));
  const double elevation_deg = kind == PassCameras::Around ? 32 + 10 * wave : 76 + 6 * wave;
  const double elevation = elevation_deg * std::numbers::pi / 180;
  const double distance = 1.45 + 0.08 * std::cos(1.7 * double(i + pass));
  const Vec3d target{0.08 * std::cos(2.3 * double(i)), 0.08 * std::sin(1.9 * double(i)), middle};
  const Vec3d eye = Vec3d{0, 0, middle} + distance * Vec3d{std::cos(elevation) * std::cos(azimuth),
                                                           std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
  return looking_at(eye, target, {0, 0, 1});
}

const Object& the_object() {
  static const Object object;
  return object;
}

}  // namespace

std::vector<View> ObjectCapture::views() const {
  std::vector<View> out;
  for (const CapturedPhoto& p : truth)
    out.push_back({.name = p.name, .intrinsics = intrinsics, .cam_from_world = p.cam_from_object, .gain = p.gain});
  return out;
}

std::vector<std::vector<std::string>> ObjectCapture::passes() const {
  std::vector<std::vector<std::string>> out;
  for (const CapturedPhoto& p : truth) {
    if (out.size() <= p.pass) out.resize(p.pass + 1);
    out[p.pass].push_back(p.name);
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

TakenPhotos photos_of_pass(const PassDesc& desc) {
  struct Place {
    Vec3f centre;
    float angle;
  };
  constexpr std::array<Place, 3> kPlaces{
      Place{{0.70f, -0.25f, 0}, 1.3f}, {{-0.35f, 0.66f, 0}, -2.4f}, {{-0.20f, -0.72f, 0}, -0.2f}};
  const Place& chart = kPlaces.at(desc.chart_place);
  const Object& object = the_object();
  const ObjectStudio studio(object, plate_and_chart(desc, chart.centre, chart.angle));
  const Rest rest = object.resting(orientation(desc.lying));
  TakenPhotos out;
  for (size_t i = 0; i < desc.photos; ++i)
    out.push_back(
        studio.taken({camera(desc.cameras, size_t(desc.lying), i, desc.photos, rest.height / 2), rest.world_from_object}));
  return out;
}

TakenPhotos photos_on_turntable(size_t count) {
  const Object& object = the_object();
  const ObjectStudio studio(object, room());
  const Rigid cam_from_world = looking_at({1.05, 0.7, 0.95}, {0, 0, 0.25}, {0, 0, 1});
  TakenPhotos out;
  for (size_t i = 0; i < count; ++i)
    out.push_back(studio.taken(
        {cam_from_world, object.resting(turned_about({0, 0, 1}, kFullTurn * double(i) / double(count))).world_from_object}));
  return out;
}

ObjectCapture write_capture(const fs::path& folder, std::span<const TakenPhotos* const> passes, const DevelopDesc& desc) {
  constexpr std::array<int, 7> kThirds{0, 2, -1, 1, -2, 0, -1};
  ObjectCapture out{.photos = folder / "photos", .masks = folder / "masks", .intrinsics = kCamera, .truth = {}};
  make_folders(out.photos);
  make_folders(out.masks / "object");
  for (size_t pass = 0; pass < passes.size(); ++pass)
    for (const TakenPhoto& photo : *passes[pass]) {
      const size_t n = out.truth.size();
      const double exposure = desc.exposure_varies ? std::exp2(kThirds[n % kThirds.size()] / 3.0) : 1;
      const Vec3d gain{exposure, exposure, exposure * (pass == 1 ? desc.blue_gain : 1)};
      ImageF linear = photo.linear;
      for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] *= float(gain[i % 3]);
      const std::string stem = fmt::format("photo_{:03}", n);
      write_ldr(out.photos / (stem + ".jpg"), srgb8_from_linear(linear), kJpegQuality);
      write_ldr(out.masks / "object" / (stem + ".png"), photo.object);
      out.truth.push_back({.name = stem + ".jpg", .pass = pass, .cam_from_object = photo.cam_from_object, .gain = gain});
    }
  return out;
}

}  // namespace vitrine::test
