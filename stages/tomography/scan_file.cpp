#include "stages/tomography/scan_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/yaml.h"

namespace vitrine {

namespace {

constexpr const char* kHint = "stages/tomography/README.md shows the format";
constexpr double kLongest = 1e9;  // of any length, units
constexpr size_t kMostAngles = 100000;

bool is_picture(const fs::path& path) {
  const std::string extension = lowered(path.extension().string());
  return extension == ".png" || extension == ".tif" || extension == ".tiff" || extension == ".exr";
}

// Pictures of a folder, by name: numbers in names have the same number of digits, as scanners write them.
std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code ec;
  for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
    if (is_picture(it->path()) && it->path().filename().string().front() != '.') out.push_back(it->path());
  std::ranges::sort(out);
  return out;
}

fs::path next_to_file(const fs::path& file, const std::string& word) {
  return (fs::absolute(file).parent_path() / word).lexically_normal();
}

class Reader {
 public:
  explicit Reader(const fs::path& file) : file_(file), in_(read_yaml(file.string())) {}

  ScanFile scan() {
    const YamlNode& root = in_.root();
    in_.only_keys(root, {"beam", "source_distance", "detector_distance", "pixel_size", "unit", "detector_offset", "angles",
                         "projections", "flat", "dark", "absorption"});
    in_.finish(kHint);
    take_geometry(root);
    take_levels(root);
    const YamlNode* projections = root.find("projections");
    if (projections == nullptr)
      in_.complain(root, "projections must be a folder or a list of pictures, one for each angle");
    else
      take_projections(*projections);
    const YamlNode* angles = root.find("angles");
    if (angles == nullptr)
      in_.complain(root, "angles must be a list of degrees, or {first: A, step: B}");
    else
      take_angles(*angles);
    in_.finish(kHint);
    check_counts();
    return std::move(scan_);
  }

 private:
  std::string place(const YamlNode& node) const { return fmt::format("{}:{}:{}", in_.name(), node.mark.line, node.mark.column); }

  double positive(const YamlNode& root, const char* key, const char* what) {
    const YamlNode* node = root.find(key);
    if (node == nullptr) {
      in_.complain(root, fmt::format("{} is missing: {}", key, what));
      return 1;
    }
    const auto value = in_.number(*node);
    if (value && !(*value > 0 && *value <= kLongest)) in_.complain(*node, fmt::format("{} must be more than 0: {}", key, what));
    return value.value_or(1);
  }

  void take_geometry(const YamlNode& root) {
    ScanGeometry& g = scan_.geometry;
    const YamlNode* beam = root.find("beam");
    if (beam == nullptr || (beam->text != "parallel" && beam->text != "cone"))
      in_.complain(beam != nullptr ? *beam : root, "beam must be parallel or cone");
    else
      g.beam = beam->text == "cone" ? Beam::Cone : Beam::Parallel;
    g.pixel_size = positive(root, "pixel_size", "edge of a pixel of the detector");
    if (g.beam == Beam::Cone) {
      g.source_distance = positive(root, "source_distance", "from the source to the axis of rotation");
      g.detector_distance = positive(root, "detector_distance", "from the source to the detector");
      if (g.detector_distance < g.source_distance)
        in_.complain(*root.find("detector_distance"),
                     fmt::format("the detector lies before the axis: it is {} from the source, the axis {}", g.detector_distance,
                                 g.source_distance));
    } else {
      for (const char* key : {"source_distance", "detector_distance"})
        if (const YamlNode* node = root.find(key)) in_.complain(*node, fmt::format("a parallel beam has no {}", key));
    }
    if (const YamlNode* unit = root.find("unit")) {
      g.unit = unit->text;
      if (g.unit != "mm" && g.unit != "um" && g.unit != "cm" && g.unit != "m")
        in_.complain(*unit, "unit must be um, mm, cm or m");
    }
    if (const YamlNode* offset = root.find("detector_offset"))
      if (const auto o = in_.numbers(*offset, 2, "[right, up], of the middle of the detector"))
        g.detector_offset = {std::clamp((*o)[0], -kLongest, kLongest), std::clamp((*o)[1], -kLongest, kLongest)};
  }

  DetectorLevel level(const YamlNode& node) {
    DetectorLevel out{.where = place(node)};
    if (is_picture(node.text)) {
      out.file = next_to_file(file_, node.text);
      std::error_code ec;
      if (!fs::is_regular_file(out.file, ec)) in_.complain(node, fmt::format("there is no file {}", out.file.string()));
    } else if (const auto value = in_.number(node)) {
      out.value = *value;
    }
    return out;
  }

  void take_levels(const YamlNode& root) {
    const YamlNode *flat = root.find("flat"), *dark = root.find("dark"), *absorption = root.find("absorption");
    if ((flat != nullptr) == (absorption != nullptr))
      return in_.complain(absorption != nullptr ? *absorption : root,
                          "give either flat (pixels are intensities) or absorption (pixels are line integrals)");
    if (absorption != nullptr) {
      scan_.absorption = true;
      const auto scale = in_.number(*absorption);
      if (scale && !(*scale > 0)) in_.complain(*absorption, "absorption is the line integral of a white pixel: more than 0");
      scan_.full_scale = scale.value_or(1);
      if (dark != nullptr) in_.complain(*dark, "dark needs flat");
      return;
    }
    scan_.flat = level(*flat);
    if (dark != nullptr) scan_.dark = level(*dark);
    if (scan_.flat.file.empty() && scan_.dark.file.empty() && scan_.flat.value <= scan_.dark.value)
      in_.complain(*flat, fmt::format("flat ({}) must be more than dark ({})", scan_.flat.value, scan_.dark.value));
  }

  void take_projections(const YamlNode& node) {
    scan_.where = place(node);
    std::error_code ec;
    if (node.kind == YamlNode::Kind::Scalar && !node.text.empty()) {
      const fs::path folder = next_to_file(file_, node.text);
      if (!fs::is_directory(folder, ec)) return in_.complain(node, fmt::format("there is no folder {}", folder.string()));
      scan_.projections = pictures_in(folder);
      std::erase_if(scan_.projections, [&](const fs::path& p) { return p == scan_.flat.file || p == scan_.dark.file; });
      if (scan_.projections.empty()) in_.complain(node, fmt::format("{} contains no .png, .tif, .tiff or .exr", folder.string()));
      return;
    }
    if (node.kind != YamlNode::Kind::List || node.items.empty())
      return in_.complain(node, "projections must be a folder or a list of pictures");
    for (const YamlNode& item : node.items) {
      const fs::path path = next_to_file(file_, item.text);
      if (!is_picture(path) || !fs::is_regular_file(path, ec))
        in_.complain(item, fmt::format("there is no .png, .tif, .tiff or .exr {}", path.string()));
      scan_.projections.push_back(path);
    }
  }

  void take_angles(const YamlNode& node) {
    constexpr double kRadians = std::numbers::pi / 180;
    angles_where_ = place(node);
    if (node.kind == YamlNode::Kind::List) {
      for (const YamlNode& item : node.items)
        if (const auto a = in_.number(item)) scan_.geometry.angles.push_back(*a * kRadians);
      return;
    }
    in_.only_keys(node, {"first", "step"});
    if (node.kind != YamlNode::Kind::Map) return;
    const YamlNode *first = node.find("first"), *step = node.find("step");
    if (step == nullptr) return in_.complain(node, "a range of angles needs 'step', in degrees");
    const auto by = in_.number(*step);
    const auto from = first != nullptr ? in_.number(*first) : std::optional(0.);
    if (!by || !from) return;
    if (*by == 0) return in_.complain(*step, "step must not be 0");
    for (size_t i = 0; i < std::min(scan_.projections.size(), kMostAngles); ++i)
      scan_.geometry.angles.push_back((*from + *by * double(i)) * kRadians);
  }

  void check_counts() const {
    const size_t angles = scan_.geometry.angles.size(), pictures = scan_.projections.size();
    if (angles != pictures)
      throw Error(ErrorKind::Input, fmt::format("{} angles, but {} projections", angles, pictures),
                  {.where = angles_where_,
                   .why = "every projection has one angle, in the order of the file names",
                   .hint = "give as many angles as pictures, or {first: A, step: B}",
                   .code = "ANGLES_DIFFER"});
    std::vector<double> turned;
    for (const double a : scan_.geometry.angles) turned.push_back(std::remainder(a, 2 * std::numbers::pi));
    std::ranges::sort(turned);
    const auto same = [](double a, double b) { return std::abs(a - b) < 1e-9; };
    turned.erase(std::unique(turned.begin(), turned.end(), same), turned.end());
    if (turned.size() < 3)
      throw Error(
          ErrorKind::Input, "a scan needs at least three different angles",
          {.where = angles_where_, .why = fmt::format("there are {}", turned.size()), .hint = kHint, .code = "FEW_ANGLES"});
  }

  fs::path file_;
  YamlReader in_;
  ScanFile scan_;
  std::string angles_where_;
};

}  // namespace

ScanFile read_scan(const fs::path& file) { return Reader(file).scan(); }

std::vector<fs::path> scan_pictures(const fs::path& file) {
  std::vector<fs::path> out;
  const YamlFile yaml = read_yaml(file.string());
  if (yaml.root.kind != YamlNode::Kind::Map) return out;
  std::error_code ec;
  const auto add = [&](const fs::path& path) {
    if (is_picture(path) && fs::is_regular_file(path, ec)) out.push_back(path);
  };
  for (const char* key : {"projections", "flat", "dark"}) {
    const YamlNode* node = yaml.root.find(key);
    if (node == nullptr) continue;
    for (const YamlNode& item : node->items) add(next_to_file(file, item.text));
    if (node->kind != YamlNode::Kind::Scalar || node->text.empty()) continue;
    const fs::path path = next_to_file(file, node->text);
    if (!fs::is_directory(path, ec))
      add(path);
    else
      for (const fs::path& picture : pictures_in(path)) out.push_back(picture);
  }
  return out;
}

}  // namespace vitrine
