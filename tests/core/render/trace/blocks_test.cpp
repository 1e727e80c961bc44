// Tracer "blocks" (the kernels for a GPU, run as loops): its hits against every surfel tested by the same arithmetic, the same
// bytes in any order of blocks and threads, its place behind make_tracer(), and the errors of a device that is too
// small.
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <thread>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/parallel.h"
#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/device.h"
#include "core/render/trace/blocks/trace_pass.h"
#include "tests/core/render/trace/ray_scenes.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using blocks::build_surfel_bvh, blocks::BlockLoops, blocks::ExecutorTrace, blocks::F32, blocks::SurfelBvh;

// All values of a forward and a reverse pass.
std::vector<std::vector<float>> passes(Tracer& tracer, const RayScene& scene) {
  const TracePass p = run(tracer, scene);
  std::vector<std::vector<float>> all{flat(p.values.color), p.values.transmittance, p.values.distance, p.values.first_hit,
                                      flat(p.values.normal)};
  for (const AttributeRow& r : kAttributes) all.emplace_back(p.grad.values(r.id).begin(), p.grad.values(r.id).end());
  for (const auto* v : {&p.statistics.screen_gradient, &p.statistics.weight, &p.statistics.error}) all.push_back(*v);
  all.push_back(flat(p.rays.origins));
  all.push_back(flat(p.rays.directions));
  all.emplace_back();
  for (size_t i = 0; i < scene.origins.size(); ++i)
    for (const TraceHit& h : p.hits.of(i))
      all.back().insert(all.back().end(), {float(h.surfel), h.t, h.alpha, h.color.x, h.color.y, h.color.z});
  return all;
}

// More surfels in one plane than a traversal keeps, in an order of indices that is not that of the tree.
RayScene coplanar_scene(size_t count) {
  RayScene s;
  s.name = "coplanar";
  Rng rng(6);
  for (uint64_t i = 0; i < count; ++i) {
    add_surfel(s, {.mean = {0.3 * rng.normal(), 0.3 * rng.normal(), 1}, .su = 0.3, .sv = 0.4, .opacity = 0.1}, i);
    if (i > 0) std::copy_n(s.layer.at(Attribute::Rotation, 0), 4, s.layer.at(Attribute::Rotation, i));
  }
  for (int i = 0; i < 40; ++i) s.add_ray({0.02 * i - 0.4, 0.1, 0}, {0.1 * rng.normal(), 0.1 * rng.normal(), 1});
  s.desc.min_transmittance = 1e-5f;
  return s;
}

// Thin and long surfels nearly parallel to many of the rays.
RayScene edge_on_scene() {
  RayScene s;
  s.name = "edge_on";
  Rng rng(8);
  for (uint64_t i = 0; i < 400; ++i)
    add_surfel(s,
               {.mean = {0.2 * rng.normal(), 0.2 * rng.normal(), double(rng.uniform())},
                .normal = {1, 0.3 * rng.normal(), 0.003 * rng.normal()},
                .su = 0.5,
                .sv = 0.01,
                .opacity = 0.4},
               i);
  for (int i = 0; i < 200; ++i) s.add_ray({0.2 * rng.normal(), 0.2 * rng.normal(), -3}, {0.002 * rng.normal(), 0, 1});
  for (int i = 0; i < 20; ++i) s.add_ray({0.01 * i - 0.1, 0, -3}, {0, 0, 1});  // two coordinates of the direction are 0
  return s;
}

RayScene moved(RayScene s, const std::string& name, const Vec3f& by, const Vec3f& rays_by) {
  s.name = name;
  for (size_t i = 0; i < s.layer.size(); ++i)
    for (size_t c = 0; c < 3; ++c) s.layer.at(Attribute::Mean, i)[c] += by[c];
  for (Vec3f& o : s.origins) o += by + rays_by;
  return s;
}

std::vector<RayScene> crowded_scenes() {
  std::vector<RayScene> all{ray_cloud("cloud", 3000, 400, 0.06, 0.7, 51), ray_cloud("large", 600, 200, 0.5, 0.2, 52),
                            ray_cloud("opaque", 2000, 300, 0.1, 0.99, 53), coplanar_scene(60), edge_on_scene()};
  all.push_back(moved(all[0], "far_from_zero", {300, -500, 200}, {}));
  all.push_back(moved(ray_cloud("cloud", 2000, 1, 0.06, 0.7, 54), "far_rays", {}, {}));
  RayScene& far = all.back();
  Rng rng(9);
  for (int i = 0; i < 300; ++i) {
    const Vec3d direction = normalized(random_vector(rng));
    far.add_ray(0.5 * random_in_cube(rng) - 400.0 * direction, direction);
  }
  // Rounding in t is more than the thickness of the boxes.
  all.push_back(coplanar_scene(60));
  all.back().name = "plane_seen_from_afar";
  for (size_t i = 0; i < all.back().origins.size(); ++i) all.back().origins[i] -= 700.f * all.back().directions[i];
  all.push_back(all[0]);
  all.back().name = "near_and_far";
  for (size_t i = 0; i < all.back().origins.size(); ++i) {
    all.back().near.push_back(0.5f * rng.uniform());
    all.back().far.push_back(0.2f + rng.uniform());
  }
  return all;
}

// (surfel, t) of the blended hits of a ray: every surfel tested, none by a tree.
std::vector<std::pair<uint32_t, float>> tested_one_by_one(const SurfelBvh& bvh, const RayScene& scene, size_t i) {
  const TraceRay<F32> ray{cast<F32>(scene.origins[i]), cast<F32>(scene.directions[i]), scene.near.empty() ? 0.f : scene.near[i],
                          scene.far.empty() ? std::numeric_limits<float>::infinity() : scene.far[i]};
  struct Hit {
    float t;
    uint32_t surfel;
    F32 alpha;
  };
  std::vector<Hit> hits;
  for (size_t place = 0; place < bvh.shapes.size(); ++place) {
    const RayHit<F32> hit = ray_splat<F32>(bvh.shapes[place], ray);
    if (hit.counts) hits.push_back({hit.t.v, bvh.surfel_at[place], hit.alpha});
  }
  std::sort(hits.begin(), hits.end(),
            [](const Hit& a, const Hit& b) { return std::pair(a.t, a.surfel) < std::pair(b.t, b.surfel); });
  std::vector<std::pair<uint32_t, float>> blended;
  F32 transmittance = 1.f;
  for (const Hit& h : hits) {
    if (transmittance < F32(scene.desc.min_transmittance)) break;
    blended.emplace_back(h.surfel, h.t);
    transmittance *= F32(1.f) - h.alpha;
  }
  return blended;
}

TEST(BlocksTracer, FindsTheHitsOfEverySurfelTestedOneByOne) {
  size_t hits = 0, longest = 0;
  for (const auto& scenes : {ray_scenes(), crowded_scenes()})
    for (const RayScene& scene : scenes) {
      SCOPED_TRACE(scene.name);
      const SurfelBvh bvh = build_surfel_bvh(scene.layer);
      const auto tracer = make_tracer(TracerBackend::Blocks);
      tracer->build(scene.layer);
      RayValues values;
      HitLists lists;
      tracer->forward(scene.rays(), scene.desc, values, &lists);
      for (size_t i = 0; i < scene.origins.size(); ++i) {
        std::vector<std::pair<uint32_t, float>> found;
        for (const TraceHit& h : lists.of(i)) found.emplace_back(h.surfel, h.t);
        ASSERT_EQ(found, tested_one_by_one(bvh, scene, i)) << "ray " << i;
        hits += found.size();
        longest = std::max(longest, found.size());
      }
    }
  EXPECT_GT(hits, 20000u);
  EXPECT_GT(longest, 2 * size_t(blocks::TraceKernel<3>::kNearest));  // more traversals than two
}

// A hit may lie so close to a cut or to another hit that rounding decides, which the seeds avoid.
TEST(BlocksTracer, FindsTheHitsOfTheOtherTracers) {
  const RayScene cloud = ray_cloud("cloud", 500, 100, 0.12, 0.7, 51);
  for (const RayScene& scene : {cloud, ray_cloud("opaque", 400, 100, 0.2, 0.99, 53), coplanar_scene(60)}) {
    SCOPED_TRACE(scene.name);
    const TracePass b = run(*make_tracer(TracerBackend::Blocks), scene);
    for (const TracerBackend other : {TracerBackend::Embree, TracerBackend::Reference}) {
      const TracePass o = run(*make_tracer(other), scene);
      ASSERT_EQ(b.hits.size(), o.hits.size());
      for (size_t i = 0; i < scene.origins.size(); ++i)
        for (size_t h = 0; h < b.hits.of(i).size(); ++h) {
          EXPECT_EQ(b.hits.of(i)[h].surfel, o.hits.of(i)[h].surfel);
          EXPECT_NEAR(b.hits.of(i)[h].alpha, o.hits.of(i)[h].alpha, 2e-5);
        }
    }
  }
}

// A hit exactly at `near` does not count, one at `far` does.
TEST(BlocksTracer, LimitsOfARayAreExact) {
  RayScene s;
  for (int i = 1; i <= 4; ++i) {
    add_surfel(s, {.mean = {0, 0, 1.0 * i}, .su = 0.3, .sv = 0.3, .opacity = 0.3}, 1);
    s.add_ray({0, 0, 0}, {0, 0, 1});
  }
  s.near = {0, 1, 2, 3};
  s.far = {2, 3, 3, 3};
  const TracePass p = run(*make_tracer(TracerBackend::Blocks), s);
  std::vector<std::vector<uint32_t>> found(4);
  for (size_t i = 0; i < 4; ++i)
    for (const TraceHit& h : p.hits.of(i)) found[i].push_back(h.surfel);
  EXPECT_EQ(found, (std::vector<std::vector<uint32_t>>{{0, 1}, {1, 2}, {2}, {}}));
}

TEST(BlocksTracer, GivesTheSameBytesInAnyOrderOfBlocksAndThreads) {
  for (const RayScene& scene : {ray_cloud("cloud", 300, 200, 0.15, 0.8, 31), coplanar_scene(50)}) {
    SCOPED_TRACE(scene.name);
    const auto expected = passes(*make_blocks_tracer(), scene);
    for (const uint64_t seed : {1, 2, 3}) EXPECT_EQ(passes(*make_blocks_tracer(seed), scene), expected) << "seed " << seed;
  }
}

// Runs the threads of a block at the same time, with barriers between phases, as a device does. Under ThreadSanitizer it finds
// values that one thread of a phase reads or writes while another writes them.
struct BlockThreads : BlockLoops {
  template <class Kernel>
  void launch(const Kernel& kernel, uint32_t blocks) {
    std::vector<typename Kernel::Shared> shared(blocks);
    std::barrier barrier(Kernel::kThreads);
    std::vector<std::jthread> threads;
    for (uint32_t t = 0; t < Kernel::kThreads; ++t)
      threads.emplace_back([&, t] {
        for (uint32_t block = 0; block < blocks; ++block) {
          typename Kernel::Thread own;
          for (uint32_t phase = 0; kernel.has_phase(phase, shared[block]); ++phase) {
            kernel.run(phase, {block, t}, own, shared[block]);
            barrier.arrive_and_wait();
          }
        }
      });
  }
};

TEST(BlocksTracer, GivesTheSameBytesWithThreadsAndBarriers) {
  const RayScene scene = ray_cloud("cloud", 60, 50, 0.3, 0.6, 33);
  EXPECT_EQ(passes(*make_blocks_tracer(std::make_unique<ExecutorTrace<BlockThreads>>(BlockThreads())), scene),
            passes(*make_blocks_tracer(1), scene));
}

// Hits of a few rays at a time: the lists are the same, sums differ by their rounding.
TEST(BlocksTracer, TakesItsHitsInBatches) {
  const RayScene scene = ray_cloud("cloud", 400, 500, 0.2, 0.5, 34);
  const auto loops = [] { return std::make_unique<ExecutorTrace<BlockLoops>>(BlockLoops()); };
  const auto whole = passes(*make_blocks_tracer(loops()), scene), parts = passes(*make_blocks_tracer(loops(), 1000), scene);
  ASSERT_EQ(whole.size(), parts.size());
  EXPECT_EQ(whole.back(), parts.back());
  EXPECT_GT(whole.back().size() / 6, 3000u);  // hits
  for (size_t p = 0; p < whole.size(); ++p) {
    double norm = 0, difference = 0;
    for (size_t i = 0; i < whole[p].size(); ++i) {
      norm += std::pow(double(whole[p][i]), 2);
      difference += std::pow(double(whole[p][i]) - double(parts[p][i]), 2);
    }
    EXPECT_LE(std::sqrt(difference), 2e-6 * std::sqrt(norm)) << p;
  }
}

// Values that need no function of a library.
RayScene arithmetic_scene() {
  RayScene s;
  s.layer.resize(400);
  Rng rng(5);
  const auto fill = [&](Attribute a, float from, float factor) {
    for (float& v : s.layer.values(a)) v = (rng.uniform() - from) * factor;
  };
  fill(Attribute::Mean, 0.5f, 2);
  fill(Attribute::Rotation, 0.5f, 2);
  fill(Attribute::LogScale, 3, 0.8f);
  fill(Attribute::Opacity, 0.3f, 4);
  fill(Attribute::ShDc, 0.5f, 2);
  fill(Attribute::ShRest, 0.5f, 0.5f);
  for (int i = 0; i < 500; ++i) {
    s.origins.push_back({rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f});
    const Vec3<F32> d{rng.uniform() - 0.5f, rng.uniform() - 0.5f, rng.uniform() - 0.5f};
    const Vec3<F32> unit = normalized(d);
    s.directions.push_back({unit.x.v, unit.y.v, unit.z.v});
  }
  return s;
}

// The bytes are those of every compiler and device. Other kernels on purpose: another digest, and another numerics_tag.
TEST(BlocksTracer, GivesTheBytesOfItsTag) {
  const RayScene scene = arithmetic_scene();
  const auto tracer = make_tracer(TracerBackend::Blocks);
  tracer->build(scene.layer);
  RayValues values;
  HitLists hits;
  tracer->forward(scene.rays(), scene.desc, values, &hits);
  EXPECT_GT(hits.size(), 8000u);
  RayValues upstream = values;  // needs no random numbers of a library
  SplatLayer grad = scene.layer.zeros_like();
  RayGradients rays;
  SurfelStatistics statistics;
  tracer->backward(scene.rays(), scene.desc, hits, {.gradients = &upstream, .error = values.distance}, grad, &rays, &statistics);
  Hasher forward, reverse;
  for (const auto& v : {flat(values.color), values.transmittance, values.distance, values.first_hit, flat(values.normal)})
    forward.add(std::as_bytes(std::span(v)));
  for (const AttributeRow& r : kAttributes) reverse.add(std::as_bytes(std::as_const(grad).values(r.id)));
  for (const auto& v :
       {statistics.screen_gradient, statistics.weight, statistics.error, flat(rays.origins), flat(rays.directions)})
    reverse.add(std::as_bytes(std::span(v)));
  EXPECT_EQ(forward.digest().short_hex(), "6e5e8feb2d45");
  EXPECT_EQ(reverse.digest().short_hex(), "d05394995239");
}

class TracersOfADevice : public testing::Test {
 protected:
  ~TracersOfADevice() override {
    provide_device(device_before_);
    provide_device_tracer(tracer_before_);
    use_device(Device::Cpu);
  }
  DevicePassMaker device_before_ = provide_device(
      []() -> std::unique_ptr<blocks::BlockPass> { return std::make_unique<blocks::ExecutorPass<BlockLoops>>(BlockLoops()); });
  DeviceTraceMaker tracer_before_ = provide_device_tracer(
      []() -> std::unique_ptr<blocks::TracePass> { return std::make_unique<ExecutorTrace<BlockLoops>>(BlockLoops()); });
};

TEST_F(TracersOfADevice, AreMadeWhereADeviceIsChosen) {
  EXPECT_EQ(make_tracer()->name(), "embree") << "before one is chosen";
  use_device(Device::Cuda);
  EXPECT_EQ(make_tracer()->name(), "blocks");
  EXPECT_EQ(make_tracer(TracerBackend::Reference)->name(), "reference");
  const RayScene scene = ray_cloud("cloud", 80, 60, 0.25, 0.9, 9);
  EXPECT_EQ(passes(*make_tracer(), scene), passes(*make_tracer(TracerBackend::Blocks), scene));
  use_device(Device::Cpu);
  EXPECT_EQ(make_tracer()->name(), "embree");
}

TEST_F(TracersOfADevice, AreThoseOfTheCpuWithoutKernelsForThem) {
  provide_device_tracer(nullptr);
  use_device(Device::Cuda);
  EXPECT_EQ(make_tracer()->name(), "embree");
}

// A device with 64 KiB.
struct SmallLoops : BlockLoops {
  template <class T>
  class Array : public std::vector<T> {
   public:
    void resize(size_t size) {
      constexpr size_t kAll = 1 << 16;
      static size_t held = 0;  // by arrays of this type
      if (held + size * sizeof(T) > kAll) throw blocks::ExecutorMemory(size * sizeof(T), held, kAll - held);
      held += (size - this->size()) * sizeof(T);
      std::vector<T>::resize(size);
    }
  };
};

TEST(TracersOfASmallDevice, TooLittleMemoryIsAnErrorWithWhatMayFit) {
  const auto small = [] { return make_blocks_tracer(std::make_unique<ExecutorTrace<SmallLoops>>(SmallLoops())); };
  const RayScene scene = ray_cloud("cloud", 100, 4000, 0.1, 0.5, 3);
  const auto tracer = small();
  tracer->build(scene.layer);
  RayValues values;
  const Error of_rays = error_of([&] { tracer->forward(scene.rays(), scene.desc, values, nullptr); });
  EXPECT_EQ(exit_code(of_rays.kind()), 6);
  EXPECT_EQ(of_rays.detail().code, "DEVICE_MEMORY");
  EXPECT_EQ(of_rays.detail().where, "100 surfels, 4000 rays");
  EXPECT_NE(of_rays.detail().hint.find(" rays, may fit; or --device cpu"), std::string::npos);
  const RayScene many = ray_cloud("many", 3000, 1, 0.1, 0.5, 3);
  EXPECT_EQ(error_of([&] { small()->build(many.layer); }).detail().where, "3000 surfels, 0 rays");
}

// A device whose scans find more than 32 bits count.
struct CrowdedLoops : BlockLoops {
  template <class T>
  T read(const T*) const {
    return T(-1);
  }
};

TEST(TracersOfASmallDevice, MoreHitsThan32BitsCountAreAnError) {
  const RayScene scene = ray_cloud("cloud", 30, 20, 0.3, 0.8, 22);
  const auto tracer = make_blocks_tracer(std::make_unique<ExecutorTrace<CrowdedLoops>>(CrowdedLoops()));
  tracer->build(scene.layer);
  RayValues values;
  HitLists hits;
  const Error e = error_of([&] { tracer->forward(scene.rays(), scene.desc, values, &hits); });
  EXPECT_EQ(exit_code(e.kind()), 6);
  EXPECT_EQ(e.detail().code, "DEVICE_OVERFLOW");
  EXPECT_TRUE(std::string(e.what()).starts_with("the batch of rays is too large for the device"));
}

}  // namespace
}  // namespace vitrine
