// YAML and JSON files: configurations, lights, marks, edits, compositions, X-ray scans; the records that stages leave for each other and for the report.
#include "core/foundation/artifact/manifest.h"
#include "core/foundation/config/schema.h"
#include "core/intake/masks/marks_check.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/light/lighting.h"
#include "pipeline/report_page/facts.h"
#include "stages/compose/compose.h"
#include "stages/edit/edit.h"
#include "stages/masks/boxes/marks_file.h"
#include "stages/tomography/scan_file.h"
#include "tests/core/foundation/config/example.h"
#include "tests/fuzz/entry.h"

namespace vitrine {

namespace {

std::vector<View> two_views() {
  std::vector<View> views(2);
  views[0].name = "left/a.jpg", views[1].name = "b.jpg";
  for (View& v : views) v.intrinsics = {80, 60, 70, 70, 40, 30};
  return views;
}

const MaskCapture& capture() {
  static const MaskCapture made = [] {
    const Undistortion u = undistortion({1, 2, 80, 60, {70, 40, 30, 0.05}});  // SIMPLE_RADIAL
    MaskCapture c{.sfm_folder = {}, .set = {}, .undistortions = {u, u}};
    c.set.views = two_views();
    for (View& v : c.set.views) v.intrinsics = u.target;
    return c;
  }();
  return made;
}

}  // namespace

void fuzz_yaml(std::span<const uint8_t> bytes) {
  refuses_or_reads([&] {
    const YamlFile file = parse_yaml(text_of(bytes), "config.yaml");
    example::Config config;
    OptionTable table = options_of(config);
    ConfigErrors errors;
    apply_yaml(file, file.root, table, {}, errors);
    errors.throw_if_any("");
  });
}

void fuzz_lights(std::span<const uint8_t> bytes) {
  refuses_or_reads([&] {
    Lighting lighting;
    parse_lamps(text_of(bytes), "lights.yaml", lighting);
    for (size_t lamp = 0; lamp < lighting.lamps(); ++lamp) (void)lighting.sample_lamp(lamp, {0.1f, 0.2f, 0.3f}, {0.5f, 0.5f});
  });
}

void fuzz_marks(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("marks.yaml", text_of(bytes));
  refuses_or_reads([&] { read_marks(path, capture()); });
  refuses_or_reads([&] { check_marks(path, {}); });
}

void fuzz_edits(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("edits.yaml", text_of(bytes));
  refuses_or_reads([&] { read_edits(path, two_views()); });
}

void fuzz_compositions(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("scene.yaml", text_of(bytes));
  refuses_or_reads([&] { composition_files(path); });
  refuses_or_reads([&] { read_composition(path); });
}

// Three pictures lie in the folder; their pixels are not read.
void fuzz_scans(std::span<const uint8_t> bytes) {
  make_folders(fuzz_folder() / "scan/views");
  const fs::path path = input_file("scan/scan.yaml", text_of(bytes));
  for (const char* name : {"scan/views/a.png", "scan/views/b.png", "scan/views/c.png"}) input_file(name, "");
  refuses_or_reads([&] { scan_pictures(path); });
  refuses_or_reads([&] { read_scan(path); });
}

// photos.json, scene.json, gains.json, views.json, poses.json, a manifest, run.json, a line of events.jsonl, a CSV: all readers get the same
// bytes.
void fuzz_records(std::span<const uint8_t> bytes) {
  const fs::path folder = fuzz_folder() / "records";
  std::error_code ec;
  fs::create_directories(folder / "ingest", ec);
  const fs::path path = input_file("records/ingest/photos.json", text_of(bytes));
  refuses_or_reads([&] { read_photo_list(folder); });
  refuses_or_reads([&] { read_scene_info(path); });
  refuses_or_reads([&] { read_gains(path); });
  std::filesystem::create_directories(folder / "sfm", ec);
  input_file("records/sfm/rigs.json", text_of(bytes));
  refuses_or_reads([&] { read_rigs(folder); });
  refuses_or_reads([&] { read_view_split(path, two_views()); });
  std::filesystem::create_directories(folder / "optimize", ec);
  input_file("records/optimize/poses.json", text_of(bytes));
  std::vector<View> corrected = two_views();
  refuses_or_reads([&] { correct_poses(folder, corrected); });
  refuses_or_reads([&] { manifest_from_json(text_of(bytes), "manifest.json"); });
  const Facts facts = Facts::of_file(path);
  for (const std::string& key : facts.keys()) {
    (void)facts.text(key);
    (void)facts.number(key);
    for (const Facts& item : facts.member(key).items()) (void)item.number("seconds"), (void)item.text("name");
  }
  for (const auto& row : rows_of_csv(std::string(text_of(bytes))))
    for (const auto& [name, value] : row) (void)number_of(value);
}

std::vector<std::string> yaml_corpus() {
  return {
      "voxel: 0.01\niterations: 200\nbackend: reference\nschedule: [0.25, 0.5, 1]\nformats: [ply, glb]\nfusion:\n"
      "  weight_cap: 12\n  carve: true\nnote: \"a: b\"\n",
      "{voxel: 1e-3, fusion: {carve: no}, formats:\n  - obj\n  - ply\n}\n", "note: |\n  two\n  lines\nthreads: ~\n"};
}

std::vector<std::string> lights_corpus() {
  return {
      "lights:\n  - {type: point, position: [0, 0, 2], intensity: [4, 4, 3]}\n"
      "  - {type: directional, from: [1, 1, 2], irradiance: 2}\n"
      "  - {type: rectangle, center: [1, 0, 2], facing: [-1, 0, -2], size: [0.5, 0.3], radiance: 20}\n"
      "  - {type: disc, center: [0, 0, 2], facing: [0, 0, -1], radius: 0.2, radiance: [20, 18, 15]}\n"};
}

std::vector<std::string> marks_corpus() {
  return {
      "size: [80, 60]\nmarks:\n  - {photo: left/a.jpg, class: transparent, box: [10, 10, 40, 50]}\n"
      "  - {photo: b.jpg, class: transparent, polygon: [[10, 10], [40, 12], [38, 50]], size: [160, 120]}\n"
      "  - {photo: a, class: object, thing: jar, box: [1, 2, 30, 40]}\n"
      "  - {photo: b, class: object, thing: jar, box: [5, 6, 70, 55]}\n"};
}

std::vector<std::string> edits_corpus() {
  return {
      "edits:\n  - name: gold\n    select:\n      class: specular\n      box: [-1, -2, -3, 1, 2, 3]\n      marks:\n"
      "        - {photo: left/a, box: [10, 20, 30, 40]}\n        - {photo: b.jpg, polygon: [[0, 0], [80, 0], [0, 60]]}\n"
      "      component: 2\n      except: {class: transparent}\n"
      "    set: {tint: 0.5, f0: [1, 0.8, 0.3], roughness: 0.2, k_s: 0.1, tau: 0}\n"
      "  - select: all\n    set: {tint: [2, 1, 0]}\n  - select: {component: 1}\n    delete: true\n"};
}

// No project is there: places are read before their artifacts.
std::vector<std::string> compositions_corpus() {
  return {
      "parts:\n  - project: room\n  - project: ../kettle\n    name: a kettle\n    edited: true\n    select: {object: kettle}\n"
      "    place: {translate: [0.5, 0, -0.25], rotate: {axis: [0, 0, 1], angle: 30}, scale: 1.5}\n",
      "parts:\n  - {project: room, place: {scale: 2}}\n", "parts:\n  - {project: room, select: all}\n"};
}

std::vector<std::string> scans_corpus() {
  return {"beam: cone\nsource_distance: 100\ndetector_distance: 150.5\npixel_size: 0.2\nunit: mm\ndetector_offset: [0.1, -2]\n"
          "angles: {first: 0, step: 120}\nprojections: views\nflat: 0.9\ndark: 0.01\n",
          "beam: parallel\npixel_size: 0.02\nangles: [0, 45, 90]\nprojections: [views/a.png, views/b.png, views/c.png]\nabsorption: 4\n"};
}

std::vector<std::string> records_corpus() {
  const auto written = [](const char* name, const auto& write) {
    write(fuzz_folder() / name);
    return read_file(fuzz_folder() / name);
  };
  std::vector<Photo> photos(2);
  for (size_t i = 0; i < 2; ++i) {
    photos[i].name = two_views()[i].name, photos[i].stem = fs::path(photos[i].name).replace_extension().string();
    photos[i].source = photos[i].name;
    photos[i].width = photos[i].original_width = 80, photos[i].height = photos[i].original_height = 60;
    photos[i].focal_px = 70.5;
    if (i == 1) photos[i].gps = GpsPosition{47.5, -8.25, 431.5, "TOKYO", 4.5};
  }
  photos[1].rig = PhotoRig{"a.jpg", {0.5, 0.5, 0.5, 0.5}};
  write_photo_list(fuzz_folder() / "made", photos);
  Manifest manifest;
  manifest.stage = "mesh", manifest.key = "00", manifest.terms = {{"stage", "mesh"}, {"option.voxel", "0.004"}};
  manifest.options = {{"voxel", "0.004", "default"}}, manifest.metrics = {{"faces", 12}}, manifest.warnings = {{"CODE", "text"}};
  manifest.outputs = {{"mesh/mesh.ply", 12, "00112233445566778899aabbccddeeff"}};
  return {
      read_file(fuzz_folder() / "made/ingest/photos.json"),
      written("scene.json", [](const fs::path& p) { write_scene_info(p, {}); }),
      written("placed.json",
              [](const fs::path& p) {
                SceneInfo s;
                s.geo = GeoOrigin{47.5, -8.25, 431.5, 12};
                write_scene_info(p, s);
              }),
      written("gains.json",
              [](const fs::path& p) {
                write_gains(p, {{"b.jpg", {1, 1.1, 0.9}}, {"left/a.jpg", {1, 1, 1}}});
              }),
      "{\"panorama_of\": {\"left/a.jpg\": \"a.jpg\", \"b.jpg\": \"a.jpg\"}}",
      "{\"holdout_every\": 8, \"max_side\": 640, \"train\": [\"b.jpg\"], \"heldout\": [\"left/a.jpg\"]}",
      to_json(manifest),
      R"({"v":1,"type":"stage_end","stage":"mesh","seconds":1.5,"peak_rss_bytes":1000,"key":"00","stages":[{"name":"mesh"}]})",
      "view,psnr,\"a \"\"b\"\"\"\nb.jpg,31.5,x\nleft/a.jpg,29.25,\n"};
}

}  // namespace vitrine
