// vitrine doctor: reports the resources and programs of this machine, and what is missing.
#include <fstream>
#include <iostream>
#include <thread>

#include "core/foundation/base/error.h"
#include "core/foundation/base/graphics_card.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/config/cli.h"
#include "core/scene/image/camera_codecs.h"
#include "pipeline/commands.h"
#include "pipeline/settings.h"

namespace vitrine {

namespace {

// A field of /proc/meminfo in bytes.
size_t meminfo(const std::string& field) {
  std::ifstream in("/proc/meminfo");
  for (std::string name, unit; in >> name;) {
    size_t kib = 0;
    in >> kib;
    std::getline(in, unit);
    if (name == field + ":") return kib * 1024;
  }
  return 0;
}

// 0 = no limit.
size_t cgroup_memory_limit() {
  for (const char* path : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream in(path);
    size_t bytes = 0;
    if (in >> bytes && bytes < (size_t{1} << 60)) return bytes;
  }
  return 0;
}

std::string instruction_set() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) return "AVX-512";
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "AVX2";
  return "no AVX2";
}

struct Colmap {
  std::string path, version;
};

std::optional<Colmap> find_colmap() {
  const char* chosen = std::getenv("VITRINE_COLMAP");
  const auto program = find_program(chosen != nullptr && *chosen != 0 ? chosen : "colmap");
  if (!program) return std::nullopt;
  Colmap colmap{program->string(), "unknown version"};
  // `colmap version` exists only in recent versions; all versions print "COLMAP x.y" at the top of their help.
  run_process({.arguments = {program->string(), "help"}, .on_line = [&](std::string_view line) {
                 const size_t at = line.find("COLMAP ");
                 if (colmap.version != "unknown version" || at == std::string_view::npos) return;
                 const std::string_view rest = line.substr(at + 7);
                 if (!rest.empty() && rest[0] >= '0' && rest[0] <= '9')
                   colmap.version = std::string(rest.substr(0, rest.find_first_of(" -")));
               }});
  return colmap;
}

// Never missing: nothing needs a card.
void print_graphics_card() {
  bool kernels = false;
  try {
    kernels = has_device_kernels(load_graph(stage_folder()));
  } catch (const Error&) {  // reported with the stages
  }
  const char* of_build = kernels ? "" : "; this build has no kernels for it (there was no nvcc)";
  const GraphicsCardSearch found = find_graphics_card();
  if (const auto& card = found.card)
    fmt::print("  GPU     {}, {}, compute capability {}.{}, driver for CUDA {}.{}{}\n", card->name,
               bytes_text(card->memory_bytes), card->capability / 10, card->capability % 10, card->driver / 1000,
               card->driver % 1000 / 10, kernels ? ": --device cuda" : of_build);
  else
    fmt::print("  GPU     none: {}{}\n", found.why_not, of_build);
}

// ffmpeg and ffprobe, which decode films.
void print_films(std::vector<std::string>& missing) {
  const auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg || !find_program("ffprobe")) {
    fmt::print("  films   {} missing\n", ffmpeg ? "ffprobe" : "ffmpeg");
    missing.push_back("ffmpeg with ffprobe: apt install ffmpeg (needed for films, not for photos)");
    return;
  }
  std::string version = "of unknown version";  // first line: "ffmpeg version 5.1.6-0+deb12u1 Copyright (c) ..."
  run_process({.arguments = {ffmpeg->string(), "-version"}, .on_line = [&](std::string_view line) {
                 constexpr std::string_view kStart = "ffmpeg version ";
                 if (line.starts_with(kStart))
                   version = line.substr(kStart.size(), line.find(' ', kStart.size()) - kStart.size());
               }});
  fmt::print("  films   ffmpeg {} at {}\n", version, ffmpeg->string());
}

// Decoders of photos that a build may lack.
void print_photo_formats(std::vector<std::string>& missing) {
  try {
    fmt::print("  photos  JPEG, PNG, TIFF, EXR\n");
    fmt::print("          HEIC, AVIF: {}\n", camera_codecs().heif_version());
    fmt::print("          raw: {}\n", camera_codecs().raw_version());
  } catch (const Error& e) {
    fmt::print("          HEIC, AVIF, raw: {}\n", e.message());
    missing.push_back(fmt::format("{}: {}", e.message(), e.detail().why));
  }
}

}  // namespace

int doctor_command(const Words& words) {
  bool help = false;
  CommandLine cli("vitrine doctor", "", "What this machine has for vitrine, and what is missing.");
  cli.flag("help", 'h', help, "Print this text.");
  cli.parse(words, 0);
  if (help) {
    std::cout << cli.help();
    return 0;
  }
  std::vector<std::string> missing;
  const std::string isa = instruction_set();
  if (isa == "no AVX2") missing.push_back("a CPU with AVX2 (any since 2015)");
  fmt::print("vitrine {}  linux  {}\n", VITRINE_VERSION, isa);
  fmt::print("  CPU     {} threads usable of {}\n", hardware_threads(), std::thread::hardware_concurrency());
  const size_t limit = cgroup_memory_limit();
  fmt::print("  RAM     {} free of {}{}\n", bytes_text(meminfo("MemAvailable")), bytes_text(meminfo("MemTotal")),
             limit != 0 ? fmt::format("  (cgroup limit {})", bytes_text(limit)) : std::string());
  print_graphics_card();
  if (const auto colmap = find_colmap()) {
    fmt::print("  colmap  {} at {}\n", colmap->version, colmap->path);
  } else {
    fmt::print("  colmap  missing\n");
    missing.push_back("colmap: apt install colmap, or set VITRINE_COLMAP (not needed with --poses that bring sparse points)");
  }
  print_photo_formats(missing);
  print_films(missing);
  fmt::print("  disk    {} free in {}\n", bytes_text(free_disk_bytes(fs::current_path())), fs::current_path().string());
  std::vector<std::string> names;
  try {
    for (const StageNode& node : load_graph(stage_folder()).nodes) names.push_back(node.name);
    fmt::print("  stages  {}\n", fmt::join(names, " "));
  } catch (const Error& e) {
    fmt::print("  stages  {}\n", e.message());
    missing.push_back(e.message());
  }
  try {
    fmt::print("  presets {} in {}\n", fmt::join(preset_names(), " "), config_folder().string());
  } catch (const Error& e) {
    fmt::print("  presets missing\n");
    missing.push_back(e.message());
  }
  for (const std::string& what : missing) fmt::print("missing: {}\n", what);
  if (missing.empty()) fmt::print("ready: vitrine run PHOTOS -o DIR\n");
  return missing.empty() ? 0 : exit_code(ErrorKind::Dependency);
}

}  // namespace vitrine
