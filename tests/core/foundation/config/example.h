// The configuration that the tests of core/foundation/config read and write.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/config/describe.h"

namespace vitrine::example {

struct Fusion {
  double weight_cap = 64;
  bool carve = false;
};
inline void describe(Describer& d, Fusion& c) {
  d.option("weight_cap", c.weight_cap, "Largest weight of a voxel.").range(1, 1000);
  d.option("carve", c.carve, "Whether empty space is carved.");
}

enum class Renderer { Cpu, Reference };

struct Config {
  float voxel = 0.004f;
  int iterations = 12000;
  Renderer backend = Renderer::Cpu;
  std::vector<double> schedule = {0.25, 0.5};
  std::vector<std::string> formats = {"ply", "obj"};
  int threads = 0;
  Fusion fusion;
  std::string note;
};
inline void describe(Describer& d, Config& c) {
  d.option("voxel", c.voxel, "Edge of a voxel, relative to the scene radius.").range(1e-4, 0.1);
  d.option("iterations", c.iterations, "Steps of the optimisation.").range(1, 100000);
  d.choice("backend", c.backend, {"cpu", "reference"}, "Renderer.");
  d.option("schedule", c.schedule, "Resolution of each level.").range(0, 1);
  d.option("formats", c.formats, "What is written.").choices({"ply", "obj", "glb"});
  d.option("threads", c.threads, "Threads; 0 = all.").range(0, 1024).affects_output(false);
  d.group("fusion", c.fusion, "How depth maps are fused.");
  d.option("note", c.note, "Free text kept in the manifest.");
}

}  // namespace vitrine::example
