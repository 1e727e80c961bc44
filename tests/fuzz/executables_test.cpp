// Damaged files of every kind through the real programs: they end with a documented code, and say "error:" unless it is 0. How
// many: VITRINE_MUTATED_FILES (34); which: VITRINE_FUZZ_SEED (1). A defect leaves its file in the folder that the message names.
#include <set>

#include "core/scene/light/environment.h"
#include "tests/e2e/tiny_room.h"
#include "tests/fuzz/mutate.h"

namespace vitrine {
namespace {

// One way to give a file to a program.
struct Road {
  const char* format;               // whose words are mixed in
  std::vector<std::string> corpus;  // valid files
  std::string file;                 // where the damaged one goes, below the folder of the test
  std::vector<std::string> words;   // the command
};

// Number of processes of this machine that have `word` in their command line.
size_t processes_with(const std::string& word) {
  size_t count = 0;
  std::error_code ec;
  for (fs::directory_iterator at("/proc", ec), end; at != end; at.increment(ec)) {
    std::ifstream in(at->path() / "cmdline", std::ios::binary);
    const std::string line{std::istreambuf_iterator<char>(in), {}};
    count += line.find(word) != line.npos;
  }
  return count;
}

class Executables : public TinyRoom {
 protected:
  static uint64_t number_from(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
  }
  static std::string program(const std::string& name) { return std::string(VITRINE_BIN_DIR) + "/" + name; }
  std::string at(const std::string& path) const { return (folder.path() / path).string(); }
  // A copy of an output folder without its store, to damage files in.
  void copy_outputs(const std::string& to, const std::vector<std::string>& parts) const {
    for (const std::string& part : parts) {
      fs::create_directories((folder.path() / to / part).parent_path());
      fs::copy(out() / part, folder.path() / to / part, fs::copy_options::recursive);
    }
  }
  std::vector<Road> roads() const {
    const std::string o = out().string();
    const std::string result = at("result");
    copy_outputs("surfels", {"gaussians", "optimize", "scene.json"});
    copy_outputs("surface", {"mesh"});
    copy_outputs("model", {"sparse/0"});
    fs::copy(photos(), folder.path() / "few photos");
    write_environment(folder.path() / "sky.exr", axis_probe(16));
    const auto bytes = [&](const fs::path& p) { return read_file(p); };
    const auto sfm = [&](const std::string& poses) {
      return std::vector<std::string>{program("vitrine-sfm"), "-i", "ingest=" + o, "-i",
                                      "poses=" + at(poses),   "-o", result,        "-q"};
    };
    return {
        {"photo",
         fuzz_format("photo").corpus(),
         "few photos/img_0001.png",
         {program("vitrine-ingest"), "-i", "photos=" + at("few photos"), "-o", result, "-q"}},
        {"exr",
         {bytes(out() / "linear/img_0001.exr")},
         "few photos/img_0002.exr",
         {program("vitrine-ingest"), "-i", "photos=" + at("few photos"), "-o", result, "-q"}},
        {"film",
         fuzz_format("film").corpus(),
         "clip.mp4",
         {program("vitrine-ingest"), "-i", "photos=" + at("clip.mp4"), "-o", result, "-q"}},
        {"yaml",
         {"max_side: 64\n"},
         "c.yaml",
         {program("vitrine-ingest"), "-i", "photos=" + photos().string(), "-c", at("c.yaml"), "-o", result, "-q"}},
        {"yaml",
         {"ingest:\n  max_side: 64\nmesh: {resolution: 32}\n"},
         "v.yaml",
         {program("vitrine"), "run", photos().string(), "-o", at("dry"), "--config", at("v.yaml"), "--dry-run"}},
        {"transforms", {bytes(true_poses())}, "poses.json", sfm("poses.json")},
        {"colmap_binary", {bytes(out() / "sparse/0/cameras.bin")}, "model/sparse/0/cameras.bin", sfm("model")},
        {"colmap_binary", {bytes(out() / "sparse/0/images.bin")}, "model/sparse/0/images.bin", sfm("model")},
        {"colmap_binary", {bytes(out() / "sparse/0/points3D.bin")}, "model/sparse/0/points3D.bin", sfm("model")},
        {"surfel_ply",
         {bytes(out() / "gaussians/diffuse.ply")},
         "surfels/gaussians/diffuse.ply",
         {program("vitrine-mesh"), "-i", "sfm=" + o, "-i", "optimize=" + at("surfels"), "-o", result, "-q", "--set",
          "resolution=16"}},
        {"records",
         {bytes(out() / "optimize/views.json")},
         "surfels/optimize/views.json",
         {program("vitrine-mesh"), "-i", "sfm=" + o, "-i", "optimize=" + at("surfels"), "-o", result, "-q", "--set",
          "resolution=16"}},
        {"mesh_ply",
         {bytes(out() / "mesh/mesh.ply")},
         "surface/mesh/mesh.ply",
         {program("vitrine-export"), "-i", "sfm=" + o, "-i", "optimize=" + o, "-i", "mesh=" + at("surface"), "-o", result, "-q"}},
        {"exr", {bytes(folder.path() / "sky.exr")}, "sky.exr", relight("--env", "sky.exr")},
        {"hdr", fuzz_format("hdr").corpus(), "sky.hdr", relight("--env", "sky.hdr")},
        {"lights", fuzz_format("lights").corpus(), "lamps.yaml", relight("--lights", "lamps.yaml")},
        {"edits",
         {"edits:\n  - select: {box: [-1, -1, -1, 1, 1, 1]}\n    set: {tint: 0.5}\n"},
         "edits.yaml",
         {program("vitrine"), "edit", o, at("edits.yaml")}},
        {"marks",
         {"size: [96, 64]\nmarks:\n  - {photo: img_0001.png, class: object, box: [20, 10, 80, 60]}\n"
          "  - {photo: img_0002.png, class: object, polygon: [[20, 10], [80, 12], [78, 60], [22, 58]]}\n"},
         "marks.yaml",
         {program("vitrine-masks"), "-i", "sfm=" + o, "-i", "masks=" + at("marks.yaml"), "-o", result, "-q"}},
        {"onnx",
         {fuzz_format("onnx").corpus().front()},
         "n.onnx",
         {program("vitrine-normals"), "-i", "sfm=" + o, "-i", "network=" + at("n.onnx"), "-o", result, "-q", "--set",
          "source=onnx"}},
    };
  }
  std::vector<std::string> relight(const char* option, const char* file) const {
    return {program("vitrine"), "relight", out().string(), option, at(file), "--views", "heldout", "--spp", "1"};
  }
};

TEST_F(Executables, EndWithADocumentedCodeWhateverTheFileHolds) {
  ASSERT_EQ(room(true_poses(), {"--set", "optimize.iterations=10", "--set", "mesh.resolution=32"}).exit, 0);
  const uint64_t files = number_from("VITRINE_MUTATED_FILES", 34), seed = number_from("VITRINE_FUZZ_SEED", 1);
  const std::set<int> documented = {0, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  std::map<int, size_t> ends;
  const std::vector<Road> all = roads();
  size_t accepted = 0;
  for (const Road& road : all) {
    write_file(folder.path() / road.file, road.corpus.front());
    const ProcessResult r =
        run_process({.arguments = road.words, .working_folder = folder.path(), .on_line = [](std::string_view) {}});
    if (r.ok()) ++accepted;
    if (!r.ok()) fmt::print("the valid {} is refused: {}\n", road.file, r.tail.substr(0, 400));
    fs::remove_all(folder.path() / "result");
  }
  EXPECT_GE(accepted, all.size() - 1)  // the tiny network's frame is ambiguous in this room
      << "valid files are refused: the roads do not lead to the parsers";
  fs::remove(folder.path() / "few photos/img_0002.exr");
  for (uint64_t i = 0; i < files; ++i) {
    const Road& road = all[i % all.size()];
    const std::string bytes = mutated(fuzz_format(road.format), road.corpus, seed, i);
    fs::remove_all(folder.path() / "result");
    fs::remove(folder.path() / road.file);
    std::ofstream(folder.path() / road.file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    std::string said;
    const ProcessResult r =
        run_process({.arguments = road.words, .working_folder = folder.path(), .on_line = [&](std::string_view line) {
                       said.append(line) += '\n';
                     }});
    ++ends[r.signal != 0 ? 128 + r.signal : r.exit_code];
    const bool good =
        r.signal == 0 && documented.contains(r.exit_code) && (r.exit_code == 0 || said.find("error:") != std::string::npos);
    if (!good) {
      const fs::path kept =
          fs::temp_directory_path() / fmt::format("vitrine-defect-{}-{}-{}", seed, i, fs::path(road.file).filename().string());
      write_file(kept, bytes);
      ADD_FAILURE() << join_command(road.words) << "\nwith " << kept << ": code " << r.exit_code << ", signal " << r.signal
                    << "\n"
                    << said.substr(0, 3000);
    }
    if (&road == &all.back() || i + 1 == files) {
      // Every road works with its valid file again: the next round begins from there.
      for (const Road& any : all) write_file(folder.path() / any.file, any.corpus.front());
      fs::remove(folder.path() / "few photos/img_0002.exr");
    }
  }
  EXPECT_EQ(processes_with(folder.path().string()), 0u) << "child processes outlive their program";
  std::string text;
  for (const auto& [code, count] : ends) text += fmt::format("  {} x code {}", count, code);
  fmt::print("{} files:{}\n", files, text);
  if (files >= all.size()) {
    EXPECT_GT(ends.size(), 1u) << "nothing was refused: the files reach no parser";
  }
}

}  // namespace
}  // namespace vitrine
