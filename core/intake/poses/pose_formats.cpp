// The files of poses that are read, and those of other programs, with what to export there instead.

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/intake/photos/given_file.h"
#include "core/intake/poses/pose_files.h"

namespace vitrine {

namespace {

using Kind = PoseFile::Kind;

struct OtherFormat {
  std::string what, hint;
};

// Formats without a mark in their content, or that are no text.
const std::map<std::string, OtherFormat>& by_extension() {
  static const std::map<std::string, OtherFormat> known{
      {".nvm", {"a VisualSFM scene", "import it in COLMAP (File > Import model), and give the folder of the exported model"}},
      {".out", {"a Bundler scene", "give the model of the program that wrote it, as COLMAP"}},
      {".csv", {"a table (RealityCapture)", "in RealityScan: export the registration as COLMAP"}},
      {".ply", {"points, meshes or splats, not cameras", ""}},
      {".splat", {"splats, not cameras", ""}},
      {".db", {"COLMAP's database: it holds matches, not poses", "give the folder of the model: sparse/0"}},
      {".ini", {"COLMAP's project file: it holds settings, not poses", "give the folder of the model: sparse/0"}},
      {".mvs", {"an OpenMVS scene", "give the model that it was made from: COLMAP, or sfm_data.json of OpenMVG"}},
      {".psx", {"a Metashape project", "in Metashape: File > Export > Export Cameras, as Agisoft XML"}},
      {".psz", {"a Metashape project", "in Metashape: File > Export > Export Cameras, as Agisoft XML"}},
      {".sfm", {"a Meshroom scene", "in Meshroom: add the node ExportColmap, and give its output"}},
      {".mg", {"a Meshroom project", "in Meshroom: add the node ExportColmap, and give its output"}},
      {".rcproj", {"a RealityScan project", "in RealityScan: export the registration as COLMAP"}},
      {".abc", {"an Alembic scene", ""}},
      {".usd", {"a USD scene", ""}},
      {".fbx", {"an FBX scene", ""}},
      {".npy", {"a NumPy array (LLFF: poses_bounds.npy)", "give the COLMAP model that it was made from: sparse/0"}},
      {".npz", {"a NumPy archive", ""}},
      {".zip", {"an archive: unpack it", "unpack it, and give the file of the poses"}}};
  return known;
}

// A JSON file is of the first kind that has all of these keys: of the document, or of the first object of a list.
struct JsonKind {
  std::vector<const char*> keys;
  std::optional<Kind> kind;
  OtherFormat other;
};
const std::vector<JsonKind>& json_kinds() {
  static const std::vector<JsonKind> kinds{
      {{"frames"}, Kind::Transforms, {}},
      {{"camera_path"}, Kind::Transforms, {}},  // named by its reader
      {{"file_path"}, Kind::Transforms, {}},    // a list of frames
      {{"cameras", "shots"}, Kind::OpenSfm, {}},
      {{"sfm_data_version"}, Kind::OpenMvg, {}},
      {{"views", "intrinsics", "extrinsics"}, Kind::OpenMvg, {}},
      {{"views", "intrinsics"}, {}, {"a Meshroom (AliceVision) scene", by_extension().at(".sfm").hint}},
      {{"header", "graph"}, {}, {"a Meshroom project", by_extension().at(".mg").hint}},
      {{"img_name", "position", "rotation"},
       {},
       {"the list of cameras that 3D Gaussian splatting writes next to its result", "give what it was trained from: sparse/0"}},
      {{"t_00", "t_01", "t_10"},
       {},
       {"one camera of a Polycam capture",
        "convert the capture: ns-process-data polycam writes a transforms.json; or run without --poses"}},
      {{"cameraPoseARFrame"},
       {},
       {"one camera of an ARKit capture (3D Scanner App)", "convert the capture to a transforms.json; or run without --poses"}},
      {{"poses", "K"},
       {},
       {"the metadata of a Record3D capture",
        "convert the capture: ns-process-data record3d writes a transforms.json; or run without --poses"}},
      {{"orientation", "position", "focal_length"},
       {},
       {"one camera of a Nerfies capture", "convert the capture to a transforms.json; or run without --poses"}},
      {{"images", "annotations"}, {}, {"a file of annotations (COCO), not of cameras", ""}},
      {{"shapes", "imagePath"}, {}, {"a file of annotations (labelme), not of cameras", ""}},
      {{"type", "features"}, {}, {"a map of places (GeoJSON)", "give reconstruction.json of OpenSfM (ODM: opensfm/)"}},
  };
  return kinds;
}

RecognisedPoses recognised_json(const JsonOutline& json) {
  if (!json.complete || json.keys.empty()) return {Kind::Transforms, {}, {}};
  for (const JsonKind& kind : json_kinds())
    if (std::ranges::all_of(kind.keys, [&](const char* key) { return json.has(key); }))
      return {kind.kind, kind.other.what, kind.other.hint};
  std::string keys;
  for (size_t i = 0; i < std::min<size_t>(json.keys.size(), 6); ++i)
    keys += fmt::format("{}{}", i == 0 ? "" : ", ", json.keys[i].substr(0, 30));
  return {{}, fmt::format("JSON of no known kind: its keys are {}", keys), {}};
}

RecognisedPoses recognised_xml(const std::string& root) {
  if (root == "document" || root == "chunk") return {Kind::Metashape, {}, {}};
  if (root == "BlocksExchange")
    return {{},
            "a block of ContextCapture (iTwin Capture)",
            "run without --poses: poses are found from the photos; or give them as COLMAP"};
  if (root == "annotations" || root == "annotation") return {{}, "a file of annotations (CVAT, Pascal VOC), not of cameras", {}};
  return {{}, fmt::format("an XML file of no known kind: <{}>", root.substr(0, 40)), {}};
}

}  // namespace

RecognisedPoses recognised_poses(const fs::path& file) {
  const std::string extension = lowered(file.extension().string());
  if (const auto known = by_extension().find(extension); known != by_extension().end())
    return {{}, known->second.what, known->second.hint};
  if (kind_of_file(file) == FileKind::Archive) return {{}, by_extension().at(".zip").what, by_extension().at(".zip").hint};
  const DocumentOutline outline = document_outline(file);
  if (!outline.xml_root.empty()) return recognised_xml(outline.xml_root);
  if (outline.json) return recognised_json(*outline.json);
  if (outline.empty || extension == ".json") return {Kind::Transforms, {}, {}};
  return {{}, "no JSON", {}};
}

}  // namespace vitrine
