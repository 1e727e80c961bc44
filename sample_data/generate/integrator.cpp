#include "sample_data/generate/integrator.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/foundation/base/parallel.h"
#include "core/render/model/kernels/mirror.h"
#include "sample_data/generate/content.h"

namespace vitrine::generate {
namespace {

constexpr float kFar = 1e5f;
constexpr int kMostEvents = 20;  // mirrors, metal, coats and glass on one path; a bottle alone is four walls
constexpr int kSplitPanes = 2;   // panes and coats whose two branches are both followed
constexpr float kLeastWeight = 1e-3f;

float power_heuristic(float a, float b) { return a * a / (a * a + b * b); }
float largest(const Vec3f& v) { return std::max({v.x, v.y, v.z}); }
Vec3f mirrored(const Vec3f& d, const Vec3f& n) { return d - 2.0f * dot(d, n) * n; }

// The faces around each vertex, as one list with borders.
struct VertexFaces {
  std::vector<uint32_t> begin, faces;
  explicit VertexFaces(const TriMesh& mesh) : begin(mesh.positions.size() + 1) {
    for (const auto& f : mesh.faces)
      for (const uint32_t v : f) ++begin[v + 1];
    for (size_t v = 0; v + 1 < begin.size(); ++v) begin[v + 1] += begin[v];
    faces.resize(begin.back());
    std::vector<uint32_t> filled(begin.begin(), begin.end() - 1);
    for (uint32_t f = 0; f < mesh.faces.size(); ++f)
      for (const uint32_t v : mesh.faces[f]) faces[filled[v]++] = f;
  }
};

// Vertices that lie inside another body, e.g. on a table under a box, know nothing of the light around them: they take the
// mean of their neighbours, ring by ring, so that interpolation does not draw a dark seam around the body.
void fill_hidden(const TriMesh& mesh, std::vector<uint8_t>& known, std::vector<Vec3f>& value) {
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<Vec3f> sum(value.size());
    std::vector<float> count(value.size());
    for (const auto& f : mesh.faces)
      for (size_t c = 0; c < 3; ++c)
        for (const uint32_t other : {f[(c + 1) % 3], f[(c + 2) % 3]})
          if (!known[f[c]] && known[other]) {
            sum[f[c]] += value[other];
            count[f[c]] += 1;
          }
    for (size_t v = 0; v < value.size(); ++v)
      if (count[v] > 0) {
        value[v] = sum[v] / count[v];
        known[v] = 1;
        changed = true;
      }
  }
}

}  // namespace

IrradianceCache::IrradianceCache(const Scene& scene) {
  for (const Part& part : scene.parts) {
    direct_.emplace_back(part.shape.mesh.positions.size());
    indirect_.emplace_back(part.shape.mesh.positions.size());
  }
}

Integrator::LightSample Integrator::sky_sample(const Hit& hit, const Vec3f& side, Sampler& sampler) const {
  const Vec2f u = sampler.pair();
  if (light_.environment.black()) return {};
  const auto [direction, pdf] = light_.environment.sample(u);
  if (dot(direction, side) <= 0 || dot(direction, hit.geometric) * dot(side, hit.geometric) <= 0 || pdf <= 0) return {};
  const float passed = rays_.transmittance(offset_origin(hit, direction), direction, kFar, light_.glass);
  if (passed == 0) return {};
  return {direction, passed * light_.environment.radiance(direction), pdf};
}

float Integrator::lamp_pdf(size_t lamp, const Vec3f& direction, float distance) const {
  const Lamp& l = light_.lamps[lamp];
  const Vec3f area = cross(l.edge_u, l.edge_v);
  const float projected = -dot(direction, area);  // area times cosine
  return projected <= 0 ? 0 : distance * distance / (projected * static_cast<float>(light_.lamps.size()));
}

Integrator::LightSample Integrator::lamp_sample(const Hit& hit, const Vec3f& side, Sampler& sampler) const {
  if (light_.lamps.empty()) return {};
  const Vec2f u = sampler.pair();
  size_t chosen = 0;
  if (light_.lamps.size() > 1)
    chosen = std::min(static_cast<size_t>(sampler.single() * static_cast<float>(light_.lamps.size())), light_.lamps.size() - 1);
  const Lamp& lamp = light_.lamps[chosen];
  const Vec3f to = lamp.corner + u.x * lamp.edge_u + u.y * lamp.edge_v - hit.position;
  const float distance = length(to);
  const Vec3f direction = to / distance;
  const float pdf = lamp_pdf(chosen, direction, distance);
  if (pdf <= 0 || dot(direction, side) <= 0 || dot(direction, hit.geometric) * dot(side, hit.geometric) <= 0) return {};
  const float passed = rays_.transmittance(offset_origin(hit, direction), direction, 0.999f * distance, light_.glass);
  return {direction, passed * lamp.radiance, passed > 0 ? pdf : 0};
}

// Irradiance from lamps and sky, one shadow ray each, on the outer side.
Vec3f Integrator::direct_irradiance(const Hit& hit, Sampler& sampler) const {
  Vec3f sum{};
  for (const LightSample& s : {sky_sample(hit, hit.normal, sampler), lamp_sample(hit, hit.normal, sampler)})
    if (s.pdf > 0) sum += (dot(s.direction, hit.normal) / s.pdf) * s.radiance;
  return sum;
}

Vec3f Integrator::lobe_direct(const Hit& hit, const Frame& frame, const Vec3f& wo, Sampler& sampler) const {
  Vec3f sum{};
  for (const LightSample& s : {sky_sample(hit, frame.n, sampler), lamp_sample(hit, frame.n, sampler)}) {
    if (s.pdf <= 0) continue;
    const Vec3f wi = frame.local(s.direction);
    const float lobe = lobe_pdf(hit.part->material, wo, wi);
    sum += (wi.z * power_heuristic(s.pdf, lobe) / s.pdf) * hadamard(lobe_brdf(hit.part->material, wo, wi), s.radiance);
  }
  return sum;
}

// Turns the path into the lobe of a metal or a rough coat, after the light that comes straight into that lobe.
bool Integrator::follow_lobe(const Hit& hit, Branch& path, Vec3f& sum, Sampler& sampler) const {
  const Frame frame(hit.normal);
  const Vec3f wo = frame.local(-path.direction);
  if (wo.z <= 1e-4f) return false;
  if (path.lights) sum += hadamard(path.weight, lobe_direct(hit, frame, wo, sampler));
  const LobeSample next = sample_lobe(hit.part->material, wo, sampler.pair());
  path.weight = hadamard(path.weight, next.weight);
  path.direction = frame.world(next.wi);
  path.origin = offset_origin(hit, path.direction);
  path.lobe_pdf = next.pdf;
  return true;
}

bool Integrator::follow_coat(const Hit& hit, Branch& path, Vec3f& sum, Sampler& sampler) const {
  const Material& coat = hit.part->material;
  if (coat.roughness > 0) return follow_lobe(hit, path, sum, sampler);
  const float cosine = dot(hit.normal, path.direction);
  if (cosine >= 0) return false;  // at an outline the interpolated normal may look away
  path.weight *= interface_reflectance(coat.index_of_refraction, cosine);
  path.direction = mirrored(path.direction, hit.normal);
  path.origin = offset_origin(hit, path.direction);
  path.lobe_pdf = -1;
  return true;
}

Vec3f Integrator::radiance(const Vec3f& origin, const Vec3f& direction, const IrradianceCache* cache, Sampler& sampler) const {
  const Vec3f in_air = traced({.origin = origin, .direction = direction}, cache, sampler);
  if (light_.medium == nullptr) return in_air;
  const std::optional<Hit> first = rays_.first_hit(origin, direction, light_.glass);
  return light_.medium->seen(in_air, first ? first->distance : std::numeric_limits<float>::infinity());
}

Vec3f Integrator::traced(const Branch& start, const IrradianceCache* cache, Sampler& sampler, bool* inside) const {
  std::array<Branch, kSplitPanes + 1> pending;
  size_t waiting = 0;
  pending[waiting++] = start;
  int splits = start.lights ? 0 : kSplitPanes;  // how many panes were split already
  Vec3f sum{};
  while (waiting > 0) {
    Branch path = pending[--waiting];
    int bounces = 0;
    for (; path.depth < kMostEvents && largest(path.weight) > kLeastWeight; ++path.depth) {
      const std::optional<Hit> hit = rays_.first_hit(path.origin, path.direction, light_.glass);
      if (!hit) {
        if (!path.lights) break;
        const float mis = path.lobe_pdf > 0 ? power_heuristic(path.lobe_pdf, light_.environment.pdf(path.direction)) : 1;
        sum += mis * hadamard(path.weight, light_.environment.radiance(path.direction));
        break;
      }
      if (path.within) {
        const VolumeLightf light = path.within->light(path.origin, path.direction, hit->distance);
        sum += hadamard(path.weight, light.color);
        path.weight *= light.transmittance;
      }
      const Material& material = hit->part->material;
      const bool outer = dot(hit->geometric, path.direction) < 0;
      if (material.kind == MaterialKind::Emitter) {
        if (!path.lights || light_.lamps.empty() || !outer) break;
        const size_t lamp = static_cast<size_t>(hit->part->lamp);
        const float mis = path.lobe_pdf > 0 ? power_heuristic(path.lobe_pdf, lamp_pdf(lamp, path.direction, hit->distance)) : 1;
        sum += mis * hadamard(path.weight, light_.lamps[lamp].radiance);
        break;
      }
      if (material.glass()) {
        const bool thin = material.kind == MaterialKind::ThinGlass;
        // At an outline the interpolated normal may look to the other side than the face.
        const bool smooth = (dot(hit->normal, path.direction) < 0) == outer;
        const Vec3f normal = smooth ? hit->normal : hit->geometric;
        const float index = outer || thin ? material.index_of_refraction : 1.0f / material.index_of_refraction;
        const float cosine = dot(normal, path.direction);
        const float r = thin ? sheet_reflectance(index, cosine) : interface_reflectance(index, cosine);
        Branch back = path;
        back.direction = mirrored(path.direction, normal);
        back.origin = offset_origin(*hit, back.direction);
        if (!thin && !refract(path.direction, outer ? normal : -normal, 1.0f / index, path.direction)) {
          path = back;
          continue;
        }
        path.origin = offset_origin(*hit, path.direction);
        path.within = outer ? material.content.get() : nullptr;
        if (splits < kSplitPanes) {
          ++splits;
          back.weight *= r;
          path.weight *= 1.0f - r;
          back.depth = path.depth + 1;
          pending[waiting++] = back;
        } else if (sampler.single() < r) {
          path = back;
        }
        continue;
      }
      if (!outer) {  // opaque parts have one side; the scenes show no other
        if (inside) *inside = true;
        break;
      }
      if (material.kind == MaterialKind::Mirror) {
        path.weight = hadamard(path.weight, schlick_fresnel(material.reflectance, -dot(hit->normal, path.direction)));
        path.direction = mirrored(path.direction, hit->normal);
        path.origin = offset_origin(*hit, path.direction);
        path.lobe_pdf = -1;
        continue;
      }
      if (material.kind == MaterialKind::Metal) {
        if (!follow_lobe(*hit, path, sum, sampler)) break;
        continue;
      }
      if (material.kind == MaterialKind::Coat) {
        const float r = interface_reflectance(material.index_of_refraction, dot(hit->normal, path.direction));
        Branch gloss = path;
        if (splits < kSplitPanes) {
          ++splits;
          if (follow_coat(*hit, gloss, sum, sampler)) {
            ++gloss.depth;
            pending[waiting++] = gloss;
          }
          path.weight *= 1.0f - r;
        } else if (sampler.single() < r) {
          gloss.weight *= 1.0f / r;
          if (!follow_coat(*hit, gloss, sum, sampler)) break;
          path = gloss;
          continue;
        }
      }
      const SurfacePoint point{hit->position, hit->normal, hit->uv};
      const Vec3f reflected = hadamard(path.weight, (1.0f / kPi) * material.albedo(point));
      if (cache) {
        sum += hadamard(reflected, cache->irradiance(*hit));
        break;
      }
      sum += hadamard(reflected, direct_irradiance(*hit, sampler));
      if (++bounces > kBounces) break;
      path.weight = kPi * reflected;
      path.direction = Frame(hit->normal).world(cosine_direction(sampler.pair()));
      path.origin = offset_origin(*hit, path.direction);
      path.lights = false;
    }
  }
  return sum;
}

void Integrator::gather_part(size_t part_index, int pass, const CacheDesc& desc, const IrradianceCache& last,
                             std::vector<Vec3f>& next) const {
  // Vertices sit where surfaces meet; a point a little way into one of the vertex's own faces sees what that face sees.
  constexpr float kIntoFace = 0.12f;
  constexpr uint32_t kInsideRays = 32;  // rays of the direct pass that look whether the vertex is inside something
  constexpr float kMostInside = 0.25f;  // share of rays that may end on inner sides
  constexpr float kOffGround = 1e-3f;   // metres, where the content around a vertex is looked up
  const Part& part = rays_.scene().parts[part_index];
  const TriMesh& mesh = part.shape.mesh;
  const VertexFaces around(mesh);
  std::vector<uint8_t> known(mesh.positions.size(), 1);
  parallel_for(mesh.positions.size(), 32, [&](size_t v) {
    const uint32_t faces = around.begin[v + 1] - around.begin[v];
    if (faces == 0) return;
    const Frame frame(mesh.normals[v]);
    const uint64_t key = mix64(mix64(static_cast<uint64_t>(pass), part_index), v);
    const uint32_t samples = pass == 0 ? desc.direct_samples : desc.gather_samples;
    const GlassContent* within = light_.glass ? rays_.content_at(mesh.positions[v] + kOffGround * mesh.normals[v]) : nullptr;
    Vec3f sum{};
    uint32_t inside_count = 0;
    for (uint32_t s = 0; s < samples; ++s) {
      Sampler sampler(key, s);
      const auto& [a, b, c] = mesh.faces[around.faces[around.begin[v] + s % faces]];
      const Vec3f& pa = mesh.positions[a];
      const Vec3f &pb = mesh.positions[b], &pc = mesh.positions[c];
      Hit at;
      at.part = &part;
      at.position = mixed(mesh.positions[v], (1.0f / 3.0f) * (pa + pb + pc), kIntoFace);
      at.geometric = normalized(cross(pb - pa, pc - pa));
      at.normal = frame.n;
      const Vec3f d = frame.world(cosine_direction(sampler.pair()));
      if (pass == 0) {
        sum += direct_irradiance(at, sampler);
        if (s >= kInsideRays) continue;
      }
      if (dot(d, at.geometric) <= 0) continue;
      bool inside = false;
      const Vec3f gathered =
          traced({.origin = offset_origin(at, d), .direction = d, .lights = false, .within = within}, &last, sampler, &inside);
      inside_count += inside;
      if (pass > 0) sum += kPi * gathered;
    }
    next[v] = sum / static_cast<float>(samples);
    known[v] = static_cast<float>(inside_count) <=
               kMostInside * static_cast<float>(pass == 0 ? std::min(samples, kInsideRays) : samples);
  });
  fill_hidden(mesh, known, next);
}

void Integrator::solve_irradiance(IrradianceCache& cache, const CacheDesc& desc) const {
  const Scene& scene = rays_.scene();
  for (int pass = 0; pass <= desc.passes; ++pass) {
    IrradianceCache::Field next(scene.parts.size());
    for (size_t p = 0; p < scene.parts.size(); ++p) {
      next[p].resize(scene.parts[p].shape.mesh.positions.size());
      if (scene.parts[p].material.painted()) gather_part(p, pass, desc, cache, next[p]);
    }
    (pass == 0 ? cache.direct_ : cache.indirect_) = std::move(next);
  }
}

}  // namespace vitrine::generate
