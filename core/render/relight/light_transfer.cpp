#include "core/render/relight/light_transfer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/kernels/mirror.h"
#include "core/render/relight/sample_points.h"
#include "core/scene/light/environment.h"

namespace vitrine {

namespace {

constexpr size_t kTransferTask = 64;    // vertices or surfels
constexpr float kTransferReach = 3;     // in grains: distance up to which a surfel belongs to the mesh
constexpr float kTransferLift = 2.5f;   // in grains: offset of rays above the mesh (README 4)
constexpr float kWallReach_rel = 0.2f;  // distance of a surfel to its wall, relative to its distance from the centre
constexpr float kSameSide = 0.3f;       // minimum cosine between the normals of surfel and mesh; below it the mesh normal is used
constexpr float kFromAllSides = 0.25f;  // pi over the sphere's 4 pi
constexpr float kMostlyOpen = 0.5f;     // minimum share of a ray through panes
constexpr uint64_t kVertexStream = 0x21, kSurfelStream = 0x22;

void add(Transfer& sum, const Vec3f& direction, float share) {
  float basis[kTransferSize];
  sh_basis(kTransferDegree, direction, basis);
  for (size_t k = 0; k < kTransferSize; ++k) sum[k] += Vec3f{share * basis[k], share * basis[k], share * basis[k]};
}

}  // namespace

LightHarmonics light_harmonics(const Environment& environment) {
  const ImageF& map = environment.map();
  const int w = map.width(), h = map.height();
  std::array<Vec3d, kTransferSize> sum{};
  for (int y = 0; y < h; ++y) {
    const double solid_angle = texel_solid_angle(y, w, h);
    for (int x = 0; x < w; ++x) {
      const Vec3f d =
          environment.world_from_map() * lat_long_direction((float(x) + 0.5f) / float(w), (float(y) + 0.5f) / float(h));
      double basis[kTransferSize];
      sh_basis(kTransferDegree, cast<double>(d), basis);
      const float* rgb = map.pixel(x, y);
      for (size_t k = 0; k < kTransferSize; ++k)
        sum[k] += (solid_angle * basis[k]) * Vec3d{double(rgb[0]), double(rgb[1]), double(rgb[2])};
    }
  }
  LightHarmonics out;
  for (size_t k = 0; k < kTransferSize; ++k) out[k] = cast<float>(sum[k]);
  return out;
}

CellLight cell_light(const Environment& environment) {
  const ImageF& map = environment.map();
  const int w = map.width(), h = map.height();
  std::array<Vec3d, kCells> flux{}, direction{}, middle{};
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const Vec3f d =
          environment.world_from_map() * lat_long_direction((float(x) + 0.5f) / float(w), (float(y) + 0.5f) / float(h));
      const Vec2f p = octahedral_place(d);
      const auto at = [](float v) { return std::clamp(static_cast<int>((0.5f * v + 0.5f) * kCellSide), 0, kCellSide - 1); };
      const size_t cell = static_cast<size_t>(at(p.y) * kCellSide + at(p.x));
      const double angle = texel_solid_angle(y, w, h);
      const float* rgb = map.pixel(x, y);
      const Vec3d light = angle * Vec3d{double(rgb[0]), double(rgb[1]), double(rgb[2])};
      flux[cell] += light;
      direction[cell] += (light.x + light.y + light.z) * cast<double>(d);
      middle[cell] += angle * cast<double>(d);
    }
  CellLight out;
  for (size_t c = 0; c < kCells; ++c) {
    out.flux[c] = cast<float>(flux[c]);
    const Vec3d& d = squared_length(direction[c]) > 0 ? direction[c] : middle[c];
    if (squared_length(d) > 0) out.direction[c] = cast<float>(normalized(d));
  }
  return out;
}

Vec3f irradiance(const ReceivedLight& received, const CellLight& cells, const LightHarmonics& harmonics) {
  const bool all_sides = squared_length(received.normal) == 0;
  Vec3f sum{};
  for (size_t c = 0; c < kCells; ++c) {
    if ((received.open[c / 32] >> (c % 32) & 1) == 0) continue;
    sum += (all_sides ? kFromAllSides : std::max(dot(received.normal, cells.direction[c]), 0.f)) * cells.flux[c];
  }
  for (size_t k = 0; k < kTransferSize; ++k) sum += hadamard(received.bounced[k], harmonics[k]);
  return {std::max(sum.x, 0.f), std::max(sum.y, 0.f), std::max(sum.z, 0.f)};
}

LightTransfer::LightTransfer(const SceneSurface& surface, const TransferDesc& desc) : surface_(&surface), desc_(desc) {
  const TriMesh& mesh = surface.mesh();
  const float lift = kTransferLift * surface.grain();
  for (int bounce = 0; bounce < desc.bounces; ++bounce) {
    std::vector<Transfer> next(mesh.positions.size());
    parallel_for(next.size(), kTransferTask, [&](size_t v) {
      throw_if_interrupted();
      next[v] =
          gathered({mesh.positions[v] + lift * mesh.normals[v], mesh.normals[v]}, mix64(kVertexStream, v), true, bounce > 0);
    });
    vertices_ = std::move(next);
  }
}

// Cosine-weighted gathering: T_k = pi/n times the sum over the rays. `direct`: light from outside; `bounced`: light from the
// mesh.
Transfer LightTransfer::gathered(const Place& place, uint64_t stream, bool direct, bool bounced) const {
  Vec3f t0, t1;
  tangents(place.normal, t0, t1);
  const SamplePoints points(desc_.seed, stream);
  const float each = std::numbers::pi_v<float> / float(desc_.rays);
  Transfer sum{};
  for (uint32_t i = 0; i < static_cast<uint32_t>(desc_.rays); ++i) {
    const Vec2f u = points.point(0, i);
    const float r = std::sqrt(u.x), phi = 2 * std::numbers::pi_v<float> * u.y;
    const Vec3f d = (r * std::cos(phi)) * t0 + (r * std::sin(phi)) * t1 + std::sqrt(std::max(1 - u.x, 0.f)) * place.normal;
    const float outside = surface_->follow(place.origin, d, [&](const SceneSurface::Meeting& m) {
      if (bounced && m.front) add_sent(sum, m.place, each * m.share);
    });
    if (direct && outside > 0) add(sum, d, each * outside);
  }
  return sum;
}

void LightTransfer::add_sent(Transfer& sum, const SurfacePlace& place, float share) const {
  const Vec3f sent = (share / std::numbers::pi_v<float>)*surface_->at(surface_->reflectance(), place);
  const auto& face = surface_->mesh().faces[place.face];
  for (size_t c = 0; c < 3; ++c)
    for (size_t k = 0; k < kTransferSize; ++k) sum[k] += place.weights[c] * hadamard(sent, vertices_[face[c]][k]);
}

LightTransfer::Arrival LightTransfer::arriving(const Vec3f& origin, const Vec3f& direction) const {
  Arrival a;
  float most = 0;
  a.from_outside = surface_->follow(origin, direction, [&](const SceneSurface::Meeting& m) {
    if (m.front && !vertices_.empty()) add_sent(a.from_scene, m.place, m.share);
    if (m.share > most) most = m.share, a.distance = length(surface_->at(surface_->mesh().positions, m.place) - origin);
  });
  if (most < a.from_outside) a.distance = 0;
  return a;
}

ReceivedLight LightTransfer::received(const Place& place, uint64_t stream) const {
  ReceivedLight out{.normal = place.normal};
  const bool all_sides = squared_length(place.normal) == 0, bounced = !vertices_.empty();
  if (all_sides) {
    const Transfer up = gathered({place.origin, {0, 0, 1}}, stream, false, bounced),
                   down = gathered({place.origin, {0, 0, -1}}, stream, false, bounced);
    for (size_t k = 0; k < kTransferSize; ++k) out.bounced[k] = 0.5f * (up[k] + down[k]);
  } else {
    out.bounced = gathered(place, stream, false, bounced);
  }
  const SamplePoints points(desc_.seed, stream);
  for (size_t c = 0; c < kCells; ++c) {
    const Vec2f u = points.point(1, static_cast<uint32_t>(c));
    const Vec3f d =
        octahedral_direction(2 * (float(c % kCellSide) + u.x) / kCellSide - 1, 2 * (float(c / kCellSide) + u.y) / kCellSide - 1);
    if (!all_sides && !(dot(place.normal, d) > 0)) continue;
    if (surface_->visibility(place.origin, d) > kMostlyOpen) out.open[c / 32] |= 1u << (c % 32);
  }
  return out;
}

// Mesh position of a surfel: along its normal, or the wall in front of which the cameras see it. Walls are coarse: a surfel
// behind one gets the light on its front, as in relit pictures (README 4).
std::optional<LightTransfer::Place> LightTransfer::place_of(const Vec3f& mean, const Vec3f& normal) const {
  const float grain = surface_->grain(), reach = kTransferReach * grain, lift = kTransferLift * grain;
  for (const Vec3f& n : {normal, -normal}) {
    const auto place = surface_->front_near(mean + reach * n, -n, 2 * reach);
    if (!place) continue;
    const Vec3f on_mesh = surface_->at(surface_->mesh().positions, *place),
                outwards = normalized(surface_->at(surface_->mesh().normals, *place));
    // In concavities of the mesh the surfel lies in front of it, and its own normal is better.
    const float above = std::max(dot(mean - on_mesh, outwards), 0.f);
    const Vec3f facing = dot(normal, outwards) < 0 ? -normal : normal;
    return Place{on_mesh + (above + lift) * outwards, dot(facing, outwards) > kSameSide ? facing : outwards};
  }
  // The cameras surround the origin.
  const float distance = length(mean);
  if (!(distance > 0)) return std::nullopt;
  const Vec3f away = mean / distance;
  const auto hit = surface_->first_hit({}, away);
  if (!hit || hit->from_inside || !surface_->surrounding(hit->face) || hit->t > (1 + kWallReach_rel) * distance)
    return std::nullopt;
  const Vec3f facing = dot(normal, away) > 0 ? -normal : normal, outwards = normalized(facing + hit->normal);
  return Place{std::min(hit->t, distance) * away + lift * outwards, dot(facing, hit->normal) > kSameSide ? facing : hit->normal};
}

ReceivedLight LightTransfer::of_surfel(const SplatLayer& layer, size_t i) const {
  const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i);
  const Vec3f mean{m[0], m[1], m[2]};
  const auto place = place_of(mean, rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2);
  return received(place.value_or(Place{mean, {}}), mix64(kSurfelStream, i));
}

std::vector<ReceivedLight> LightTransfer::of_surfels(const SplatLayer& layer) const {
  std::vector<ReceivedLight> out(layer.size());
  parallel_for(out.size(), kTransferTask, [&](size_t i) {
    throw_if_interrupted();
    out[i] = of_surfel(layer, i);
  });
  return out;
}

}  // namespace vitrine
