#include "pipeline/cost_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/math/median.h"

namespace vitrine {

namespace {

constexpr double kMiB = 1024.0 * 1024.0;

bool is_given(const Settings& settings, const char* input) {
  const Option* option = settings.options.table.find(input);
  return option != nullptr && !option->text().empty() && option->text() != "none";
}

// What the formulas are written in.
struct Terms {
  const Settings& settings;
  const CaptureSize& capture;
  int threads;

  double option(const char* path) const { return std::strtod(settings.text(path).c_str(), nullptr); }
  // Megapixels of one photo whose longest side is limited, by 0 = not.
  double mpx(double max_side) const {
    const double side = max_side > 0 ? std::min(max_side, capture.longest_px) : capture.longest_px;
    return side * side * capture.aspect * 1e-6;
  }
  double limited(const char* path, double below) const {
    const double own = option(path);
    return own <= 0 ? below : below <= 0 ? own : std::min(own, below);
  }
  double ingested_side() const { return option("ingest.max_side"); }
  double photos() const { return double(capture.photos); }
};

StageCost cost(double cpu_s, double parallel, double memory_mib, double disk_mib) {
  return {{}, cpu_s, parallel, size_t(std::max(memory_mib, 0.0) * kMiB), size_t(std::max(disk_mib, 0.0) * kMiB)};
}

StageCost ingest(const Terms& t) {
  const double in = t.capture.photographed_mpx, out = t.photos() * t.mpx(t.ingested_side());
  constexpr double kBytesPerPixel = 52;  // core of a decoder's working set (stages/ingest/README.md)
  const double budget_mib = 3072, each = in / t.photos() * 1e6 * kBytesPerPixel / kMiB;
  const double at_once = std::clamp(std::floor(budget_mib / std::max(each, 1.0)), 1.0, double(t.threads));
  return cost(0.02 * in + 0.255 * out, 0.86, 40 + at_once * each, 4.8 * out);
}

// Features per megapixel grow with texture; orientations make up to 1.4 of each found.
double features_of(const Terms& t, double mpx) {
  return std::min(mpx * (1500 + 23000 * t.capture.texture), 1.4 * t.option("sfm.max_features"));
}

StageCost sfm(const Terms& t) {
  const double n = t.photos(), mpx = t.mpx(t.limited("sfm.max_image_size", t.ingested_side())), f = features_of(t, mpx);
  const double out = n * t.mpx(t.ingested_side());
  const double all = n * (n - 1) / 2;
  const double some = n * (t.option("sfm.window") + t.option("sfm.retrieved") + std::log2(std::max(n, 2.0)));
  const double pairs = n <= t.option("sfm.exhaustive_limit") ? all : std::min(all, some);
  constexpr double kMatchedShare = 0.8, kVerify = 0.033, kMatch = 0.014, kMatchFeatures = 4300;
  const double extract = n * (0.90 * mpx + 54e-6 * f);
  const double match = pairs * kMatch * (f / kMatchFeatures) * (f / kMatchFeatures);
  const double verify = pairs * kMatchedShare * kVerify;
  const double map = 4 + 66e-6 * n * f;
  const double undistort = 0.27 * out;
  const double total = extract + match + verify + map + undistort;
  return cost(total, (total - map) / total, 45 + t.threads * 275 * mpx, 4.2 * out);
}

StageCost masks(const Terms& t) {
  const double out = t.photos() * t.mpx(t.ingested_side());
  if (t.capture.masks) return cost(0.25 * t.photos(), 0.9, 110 + 4 * out, 0.35 * out);
  return cost(0.7 * t.photos(), 0.9, 160 + 3 * out, 0.05 * out);
}

StageCost normals(const Terms& t) {
  const double out = t.photos() * t.mpx(t.limited("normals.max_side", t.ingested_side()));
  const double stereo = t.photos() * t.mpx(t.limited("normals.geometric.max_side", t.ingested_side()));
  return cost(0.6 * t.photos() + 22 * stereo, 0.95, 90 + 4 * out, 1.2 * out);
}

double trained_side(const Terms& t) { return t.limited("optimize.resolution.max_side", t.ingested_side()); }

// CPU seconds of a step of optimize with all its layers, of which those of gloss and glass take part in `layered` of the steps;
// a ray of them costs less than its pixel, which is shaded with all the others.
double step(const Terms& t, double layered, const char* budget_option) {
  const double mpx = t.mpx(trained_side(t)), surfels_k = t.option("optimize.max_gaussians") / 1000;
  double cpu_s = 0.33 * mpx + 0.60e-3 * surfels_k;
  if (t.capture.masks) {
    constexpr double kMaskedShare = 0.22, kRay = 5.5e-6, kLayer = 0.28;
    const double masked = kMaskedShare * mpx * 1e6, budget = t.option(budget_option);
    cpu_s += layered * (kLayer + kRay * (budget > 0 ? std::min(budget, masked) : masked));
  }
  return cpu_s;
}

double training_memory(const Terms& t) {
  const double mib = 140 + t.option("optimize.max_gaussians") / 1000 + 30 * t.photos() * t.mpx(trained_side(t));
  return t.capture.masks ? 1.65 * mib : mib;
}

StageCost optimize(const Terms& t) {
  constexpr double kLayeredPart = 0.55;
  const double steps = t.option("optimize.iterations");
  return cost(0.7 * t.photos() + steps * step(t, kLayeredPart, "optimize.shading.ray_budget"), 0.92, training_memory(t),
              0.2 * t.option("optimize.max_gaussians") / 1000 + 2);
}

// Glass alone gives it anything to do; what masks hold, and whether there will be anything to train on, is not known before: at
// most so much.
StageCost refine(const Terms& t) {
  if (!t.capture.masks) return cost(0.1, 0.5, 90, 0.1);
  return cost(0.6 * t.photos() + t.option("refine.fine_tune.iterations") * step(t, 1, "refine.fine_tune.ray_budget"), 0.92,
              1.05 * training_memory(t), 0.2 * t.option("optimize.max_gaussians") / 1000 + 2);
}

StageCost mesh(const Terms& t) {
  const double scale = std::pow(t.option("mesh.resolution") / 256, 2), hulls = t.capture.masks ? 16 : 0;
  return cost(8 + 4.5 * scale + hulls, 0.5, (t.capture.masks ? 1.5 : 1) * (100 + 150 * scale), 9e-5 * t.option("mesh.faces"));
}

StageCost relight(const Terms& t) { return cost(14 + 0.2 * t.photos(), 0.77, 350 + 4 * t.photos(), 6); }

StageCost evaluate(const Terms& t) {
  const double every = t.option("optimize.holdout_every");
  const double held = every > 0 ? std::ceil(t.photos() / every) : 0, mpx = t.mpx(trained_side(t));
  double cpu_s = 2 + 5 * held * mpx + 0.2 * t.photos() * mpx, memory = 150 + 12 * t.photos() * mpx;
  if (is_given(t.settings, "input.truth")) {
    // A true mesh is sampled and searched; so are depths and normals of all views. True pictures under other lights ask for ours.
    cpu_s += 14;
    memory += 610;
    std::error_code ec;
    if (std::filesystem::is_directory(std::filesystem::path(t.settings.text("input.truth")) / "relit", ec)) cpu_s += 12;
  }
  return cost(cpu_s, 0.65, memory, 5 * held * mpx);
}

StageCost exported(const Terms& t) {
  const double faces = t.option("mesh.faces"), surfels_k = t.option("optimize.max_gaussians") / 1000;
  return cost(9 + 0.9e-4 * faces + 0.07 * surfels_k, 0.7, 560 + 1e-3 * faces, 25 + 0.25 * surfels_k + 2e-4 * faces);
}

struct Row {
  const char* stage;
  StageCost (*cost)(const Terms&);
  std::vector<const char*> options;  // that the formula reads
};

}  // namespace

void take_typical_size(std::vector<std::pair<double, double>> sides, CaptureSize& capture) {
  const auto [shorter, longer] = upper_median(std::move(sides));
  capture.longest_px = longer;
  capture.aspect = shorter / longer;
}

bool gives_masks(const Settings& settings) { return is_given(settings, "input.masks"); }

std::optional<StageCost> stage_cost(const std::string& stage, const Settings& settings, const CaptureSize& capture, int threads) {
  static const Row kRows[] = {
      {"ingest", ingest, {"ingest.max_side"}},
      {"sfm",
       sfm,
       {"ingest.max_side", "sfm.max_image_size", "sfm.max_features", "sfm.window", "sfm.retrieved", "sfm.exhaustive_limit"}},
      {"masks", masks, {"ingest.max_side"}},
      {"normals", normals, {"ingest.max_side", "normals.max_side", "normals.geometric.max_side"}},
      {"optimize",
       optimize,
       {"ingest.max_side", "optimize.resolution.max_side", "optimize.max_gaussians", "optimize.iterations",
        "optimize.shading.ray_budget"}},
      {"mesh", mesh, {"mesh.resolution", "mesh.faces"}},
      {"refine",
       refine,
       {"ingest.max_side", "optimize.resolution.max_side", "optimize.max_gaussians", "refine.fine_tune.iterations",
        "refine.fine_tune.ray_budget"}},
      {"relight", relight, {}},
      {"evaluate", evaluate, {"ingest.max_side", "optimize.holdout_every", "optimize.resolution.max_side"}},
      {"export", exported, {"mesh.faces", "optimize.max_gaussians"}}};
  const auto row = std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& r) { return stage == r.stage; });
  if (row == std::end(kRows) || capture.photos == 0) return std::nullopt;
  for (const char* path : row->options)
    if (settings.options.table.find(path) == nullptr) return std::nullopt;
  StageCost c = row->cost({settings, capture, std::max(threads, 1)});
  c.name = stage;
  return c;
}

}  // namespace vitrine
