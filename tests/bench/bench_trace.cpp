// The ray tracer: forward, backward, building, and beside them Embree's bare ordered-hit loop on the same surfels and rays, which
// finds hits of their quads sixteen at a time and does nothing with them.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/trace/tracer.h"
#include "core/scene/mesh/embree_version.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {
namespace {

constexpr size_t kRays = 20000;

struct TraceBench {
  SplatLayer layer{LayerKind::Reflection, 3, 0};
  std::vector<Vec3f> origins, directions;
  RayBatch rays() const { return {origins, directions}; }
};

// Surfels of any orientation anywhere in [-1,1]^3, of a size that a ray blends about thirty; rays from anywhere to anywhere
// (`random`), or fanning out of one point in the order of pixels (`coherent`).
TraceBench volume(size_t count, bool coherent) {
  TraceBench b;
  b.layer.resize(count);
  Rng rng(1);
  const double size = 0.0152 * std::sqrt(1e5 / double(count));
  for (size_t i = 0; i < count; ++i) {
    for (size_t c = 0; c < 3; ++c) b.layer.at(Attribute::Mean, i)[c] = 2 * rng.uniform() - 1;
    for (size_t c = 0; c < 4; ++c) b.layer.at(Attribute::Rotation, i)[c] = rng.normal();
    for (size_t c = 0; c < 2; ++c)
      b.layer.at(Attribute::LogScale, i)[c] = static_cast<float>(std::log(size * (0.5 + rng.uniform_double())));
    *b.layer.at(Attribute::Opacity, i) = logit(0.05f + 0.35f * rng.uniform());
    for (Attribute a : {Attribute::ShDc, Attribute::ShRest})
      for (size_t c = 0; c < b.layer.width(a); ++c) b.layer.at(a, i)[c] = 0.3f * rng.normal();
  }
  const size_t side = static_cast<size_t>(std::sqrt(double(kRays)));
  for (size_t i = 0; i < kRays; ++i) {
    if (coherent) {
      b.origins.push_back({0, 0, -1});
      b.directions.push_back(normalized(Vec3f{float(i % side) / float(side) - 0.5f, float(i / side) / float(side) - 0.5f, 1.f}));
    } else {
      b.origins.push_back({2 * rng.uniform() - 1, 2 * rng.uniform() - 1, 2 * rng.uniform() - 1});
      b.directions.push_back(normalized(Vec3f{rng.normal(), rng.normal(), rng.normal()}));
    }
  }
  return b;
}

// Empty when the tracer agrees with the reference on a few of the rays.
std::string disagreement(const TraceBench& b) {
  TraceBench few;
  few.layer = b.layer;
  few.origins.assign(b.origins.begin(), b.origins.begin() + 5);
  few.directions.assign(b.directions.begin(), b.directions.begin() + 5);
  RayValues a, e;
  for (const auto& [backend, out] : {std::pair{TracerBackend::Embree, &a}, {TracerBackend::Reference, &e}}) {
    const auto tracer = make_tracer(backend);
    tracer->build(few.layer);
    tracer->forward(few.rays(), {}, *out, nullptr);
  }
  for (size_t i = 0; i < few.origins.size(); ++i)
    if (!(length(a.color[i] - e.color[i]) < 1e-4f)) return "the colour of a ray differs from the reference";
  return "";
}

enum class Work { Forward, Backward };

void trace(benchmark::State& state, size_t count, bool coherent, Work work, int threads) {
  const TraceBench b = volume(count, coherent);
  if (const std::string problem = disagreement(b); !problem.empty()) return state.SkipWithError(problem.c_str());
  set_thread_limit(threads);
  const auto tracer = make_tracer(TracerBackend::Embree);
  tracer->build(b.layer);
  RayValues values, upstream;
  HitLists hits;
  tracer->forward(b.rays(), {}, values, &hits);
  upstream.resize(kRays);
  Rng rng(2);
  for (size_t i = 0; i < kRays; ++i) {
    upstream.color[i] = {rng.normal(), rng.normal(), rng.normal()};
    upstream.transmittance[i] = rng.normal();
    upstream.distance[i] = rng.normal();
  }
  SplatLayer grad = b.layer.zeros_like();
  RayGradients ray_gradients;
  SurfelStatistics statistics;
  for (auto _ : state) {
    if (work == Work::Forward)
      tracer->forward(b.rays(), {}, values, &hits);
    else
      tracer->backward(b.rays(), {}, hits, {.gradients = &upstream}, grad, &ray_gradients, &statistics);
  }
  set_thread_limit(0);
  state.counters["hits/ray"] = double(hits.size()) / double(kRays);
  // Rates divide by the CPU time of the whole process: per core, whatever else runs on the machine.
  state.counters["rays/s/core"] = benchmark::Counter(double(kRays) * double(state.iterations()), benchmark::Counter::kIsRate);
}

void build(benchmark::State& state, size_t count) {
  const TraceBench b = volume(count, false);
  set_thread_limit(1);
  const auto tracer = make_tracer(TracerBackend::Embree);
  for (auto _ : state) tracer->build(b.layer);
  set_thread_limit(0);
  RayValues values;
  tracer->forward(b.rays(), {}, values, nullptr);
  if (!(values.transmittance[0] < 1.f)) state.SkipWithError("the first ray meets nothing");
}

// The yardstick.
struct BareLoop : embree::RayContext {
  static constexpr int kNearest = 16;
  struct Key {
    float t;
    uint32_t id;
    bool operator<(const Key& b) const { return t < b.t || (t == b.t && id < b.id); }
  };
  Key after{};
  int count = 0;
  Key nearest[kNearest];

  static void keep_nearest(const RTCFilterFunctionNArguments* args) {
    auto& loop = *static_cast<BareLoop*>(args->context);
    const Key key{RTCRayN_tfar(args->ray, 1, 0), RTCHitN_primID(args->hit, 1, 0)};
    args->valid[0] = 0;  // goes on
    if (!(loop.after < key)) return;
    if (loop.count == kNearest && !(key < loop.nearest[kNearest - 1])) return;
    int at = loop.count < kNearest ? loop.count++ : kNearest - 1;
    for (; at > 0 && key < loop.nearest[at - 1]; --at) loop.nearest[at] = loop.nearest[at - 1];
    loop.nearest[at] = key;
    if (loop.count < kNearest) return;
    RTCRayN_tfar(args->ray, 1, 0) = loop.nearest[kNearest - 1].t;
    args->valid[0] = -1;
  }
};

RTCScene quads_of(RTCDevice device, const SplatLayer& layer) {
  RTCScene scene = rtcNewScene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  auto* corners = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * layer.size()));
  auto* quads = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(uint32_t), layer.size()));
  for (size_t i = 0; i < layer.size(); ++i) {
    const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i), *s = layer.at(Attribute::LogScale, i);
    const Mat3f frame = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]}));
    const float cut = std::sqrt(2.f * std::log(255.f * sigmoid(*layer.at(Attribute::Opacity, i))));
    for (size_t k = 0; k < 4; ++k) {
      const float a = k == 1 || k == 2 ? cut : -cut, b = k >= 2 ? cut : -cut;
      const Vec3f p = Vec3f{m[0], m[1], m[2]} + (a * std::exp(s[0])) * frame.c0 + (b * std::exp(s[1])) * frame.c1;
      for (size_t c = 0; c < 3; ++c) corners[12 * i + 3 * k + c] = p[c];
      quads[4 * i + k] = static_cast<uint32_t>(4 * i + k);
    }
  }
  rtcSetGeometryIntersectFilterFunction(geometry, BareLoop::keep_nearest);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

// As many ordered hits for each ray as the tracer blends.
void bare_embree(benchmark::State& state, size_t count, bool coherent) {
  const TraceBench b = volume(count, coherent);
  const auto tracer = make_tracer(TracerBackend::Embree);
  tracer->build(b.layer);
  RayValues values;
  HitLists hits;
  tracer->forward(b.rays(), {}, values, &hits);
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = quads_of(device, b.layer);
  size_t found = 0;
  for (auto _ : state) {
    found = 0;
    for (size_t i = 0; i < kRays; ++i) {
      const size_t wanted = hits.of(i).size();
      BareLoop loop;
      loop.after = {0.f, 0};
      for (size_t got = 0; got < wanted;) {
        loop.count = 0;
        RTCRayHit r{};
        r.ray.org_x = b.origins[i].x, r.ray.org_y = b.origins[i].y, r.ray.org_z = b.origins[i].z;
        r.ray.dir_x = b.directions[i].x, r.ray.dir_y = b.directions[i].y, r.ray.dir_z = b.directions[i].z;
        r.ray.tnear = loop.after.t;
        r.ray.tfar = std::numeric_limits<float>::infinity();
        r.ray.mask = 0xffffffffu;
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        embree::intersect(scene, loop, r);
        got += static_cast<size_t>(loop.count);
        found += static_cast<size_t>(loop.count);
        if (loop.count < BareLoop::kNearest) break;
        loop.after = loop.nearest[BareLoop::kNearest - 1];
      }
    }
  }
  rtcReleaseScene(scene);
  rtcReleaseDevice(device);
  if (found < hits.size()) state.SkipWithError("the bare loop found fewer hits than the tracer");
  state.counters["hits/ray"] = double(found) / double(kRays);
  state.counters["rays/s/core"] = benchmark::Counter(double(kRays) * double(state.iterations()), benchmark::Counter::kIsRate);
}

const bool trace_registered = [] {
  const auto row = [](const std::string& name, auto... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), arguments...)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
  };
  for (const bool coherent : {false, true}) {
    const std::string rays = coherent ? "/coherent" : "/random";
    for (const size_t count : {15000, 100000}) {
      const std::string scene = std::to_string(count / 1000) + "k" + rays;
      for (const int threads : {1, 2}) {
        row("trace/forward/" + scene + "/threads:" + std::to_string(threads), trace, count, coherent, Work::Forward, threads);
        row("trace/backward/" + scene + "/threads:" + std::to_string(threads), trace, count, coherent, Work::Backward, threads);
      }
      row("trace/bare_embree/" + scene, bare_embree, count, coherent);
    }
  }
  for (const size_t count : {15000, 100000}) row("trace/build/" + std::to_string(count / 1000) + "k", build, count);
  return true;
}();

}  // namespace
}  // namespace vitrine
