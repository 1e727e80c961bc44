#include "stages/shapes/shapes.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/log.h"
#include "core/base/process.h"
#include "core/camera/mask_origin.h"
#include "core/mesh/mesh_io.h"
#include "core/shape/registry.h"
#include "core/shape/shape_file.h"
#include "core/stereo/mask_silhouette.h"
#include "core/stereo/shapes_artifact.h"
#include "stages/shapes/coats.h"
#include "stages/shapes/contact_sheet.h"
#include "stages/shapes/detect.h"
#include "stages/shapes/open_planes.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<MaskClass, 2> kClasses{MaskClass::Transparent, MaskClass::Specular};
constexpr double kDoubtful = 0.5;        // of a given shape's pixels: fewer in the masks, and the photos doubt it
constexpr double kFacetEdge_rel = 0.02;  // of a shape's size: edges of shapes.ply

MaskClass class_of(ShapeRole role) { return role == ShapeRole::Sheet ? MaskClass::Transparent : MaskClass::Specular; }

class ShapesRun {
 public:
  ShapesRun(const ShapesConfig& config, StageContext& context)
      : config_(config), context_(context), set_(load_view_set(context.input("sfm"))), masks_(context.optional_input("masks")) {}

  void run() {
    read_masks();
    const auto given = context_.optional_input("shapes");
    if (given && config_.source == "auto")
      take(*given);
    else if (config_.source != "none")
      fit();
    judge_paint();
    measure();
    write();
  }

 private:
  void read_masks() {
    if (!masks_) return;
    for (const MaskClass kind : kClasses) {
      auto& silhouettes = silhouettes_[size_t(kind)];
      for (uint32_t v = 0; v < set_.views.size(); ++v) {
        throw_if_interrupted();
        if (is_heldout(v, config_.holdout_every)) continue;
        const View& view = set_.views[v];
        if (auto s = mask_silhouette(*masks_, kind, view, view.intrinsics.limited_to(config_.max_side)))
          silhouettes.push_back(std::move(*s));
      }
      // Where glass is all that there is of gloss, the rest has no hull.
      if (std::ranges::none_of(silhouettes, marks_something)) silhouettes.clear();
    }
    context_.progress({.fraction = 0.2, .text = "masks read", .values = {}});
  }

  void fit() {
    const HullDesc hull{.resolution = config_.resolution, .rule = {.dissent = config_.dissent}};
    double done = 0.2;
    for (const MaskClass kind : kClasses) {
      const auto& silhouettes = silhouettes_[size_t(kind)];
      if (silhouettes.empty()) continue;
      const bool propagated = mask_origin(*masks_, kind).propagated;
      // Those on walls first: where one is marked, masks say nothing about the objects in front of it.
      ShapeSet of_class = open_planes(kind, silhouettes, set_.points, true);
      const std::vector<MaskedObject> objects =
          masked_objects(kind, of_class.entries.empty() ? silhouettes : unexplained(silhouettes, of_class), hull);
      for (const MaskedObject& object : objects) {
        throw_if_interrupted();
        const size_t before = of_class.entries.size();
        of_class.append(detected_shapes(object, hull.rule, propagated, config_.free_form));
        ++objects_;
        if (kind == MaskClass::Specular && of_class.entries.size() == before) keep_hull_of_paint(object, of_class);
      }
      of_class.append(open_planes(kind, unexplained(silhouettes, of_class), set_.points, false));
      found_.append(std::move(of_class));
      done += 0.3;
      context_.progress({.fraction = done, .text = fmt::format("{}: {} objects", name(kind), objects.size()), .values = {}});
    }
  }

  // An object without a shape.
  void keep_hull_of_paint(const MaskedObject& object, ShapeSet& found) {
    const auto figure = coat_test().view_dependence_of(object);
    const Vec3d centre = 0.5 * (object.hull.bounds().low + object.hull.bounds().high);
    log_info("an object without a shape at ({:.2f}, {:.2f}, {:.2f}): {}", centre.x, centre.y, centre.z,
             figure ? fmt::format("view dependence {:.3f}", *figure) : "too few photos see its surface");
    if (is_paint(figure)) found.append(hull_coat(object));
  }

  bool is_paint(const std::optional<double>& view_dependence) const {
    return view_dependence && *view_dependence < config_.coat_below;
  }

  const CoatTest& coat_test() {
    if (!coat_test_) coat_test_.emplace(context_.input("sfm"), silhouettes_[size_t(MaskClass::Specular)]);
    return *coat_test_;
  }

  // The role of opaque shapes: paint under a coat, or metal. A given role stays.
  void judge_paint() {
    view_dependence_.resize(found_.entries.size());
    if (silhouettes_[size_t(MaskClass::Specular)].empty()) return;
    for (uint32_t i = 0; i < found_.entries.size(); ++i) {
      ShapeSet::Entry& entry = found_.entries[i];
      if (entry.role == ShapeRole::Sheet) continue;
      if (entry.parent >= 0) {
        entry.role = found_.entries[size_t(entry.parent)].role;
        continue;
      }
      throw_if_interrupted();
      view_dependence_[i] = coat_test().view_dependence_of(found_, i);
      if (!given_ && entry.role == ShapeRole::Mirror && is_paint(view_dependence_[i])) entry.role = ShapeRole::Coat;
    }
  }

  void take(const fs::path& given) {
    std::error_code ec;
    fs::path file = given;
    if (fs::is_directory(given, ec)) file = given / "shapes.json";
    found_ = read_shapes_file(file);
    given_ = true;
    for (const MaskClass kind : kClasses) {
      const bool any = std::ranges::any_of(found_.entries, [&](const auto& e) { return class_of(e.role) == kind; });
      if (any && silhouettes_[size_t(kind)].empty())
        context_.warning("SHAPES_WITHOUT_MASKS",
                         fmt::format("shapes of {} are given, but no {} mask marks anything: nothing trains on them (--masks)",
                                     kind == MaskClass::Transparent ? "glass" : "mirrors and coats", name(kind)));
    }
  }

  void measure() {
    agreements_.resize(found_.entries.size());
    for (size_t i = 0; i < found_.entries.size(); ++i) {
      const ShapeSet::Entry& entry = found_.entries[i];
      const auto& silhouettes = silhouettes_[size_t(class_of(entry.role))];
      if (entry.parent >= 0 || silhouettes.empty()) continue;
      throw_if_interrupted();
      agreements_[i] = mask_agreement(found_, i, silhouettes);
      if (given_ && agreements_[i]->inside < kDoubtful)
        context_.warning("SHAPE_OUTSIDE_MASKS",
                         fmt::format("given shape {} (a {}): the {} masks mark only {:.0f} % of the pixels that show it", i,
                                     kind_of(entry.shape).name, name(class_of(entry.role)), 100 * agreements_[i]->inside));
    }
  }

  void write() {
    const fs::path folder = context_.output() / "shapes";
    make_folders(folder);
    Json shapes = write_shapes(found_, folder);
    for (size_t i = 0; i < agreements_.size(); ++i) {
      shapes[i]["source"] = given_ ? "given" : found_.entries[i].exact ? "fitted" : "hull";
      if (view_dependence_[i]) shapes[i]["view_dependence"] = *view_dependence_[i];
      if (!agreements_[i]) continue;
      shapes[i]["inside_masks"] = agreements_[i]->inside;
      shapes[i]["masks_covered"] = agreements_[i]->covered;
    }
    const Json document{{"format", 1}, {"frame", "scene"}, {"shapes", std::move(shapes)}};
    write_file(folder / "shapes.json", readable(document));
    if (!found_.entries.empty()) {
      write_mesh_ply(folder / "shapes.ply", all_of_them());
      write_contact_sheet(folder / "contact_sheet.png", context_.input("sfm"), set_, found_);
    }
    report();
  }

  TriMesh all_of_them() const {
    TriMesh out;
    for (const ShapeSet::Entry& entry : found_.entries) {
      const TriMesh mesh = tessellated(entry.shape, kFacetEdge_rel * size_of(entry.shape));
      const auto first = static_cast<uint32_t>(out.positions.size());
      out.positions.insert(out.positions.end(), mesh.positions.begin(), mesh.positions.end());
      for (const auto& f : mesh.faces) out.faces.push_back({first + f[0], first + f[1], first + f[2]});
    }
    return out;
  }

  void report() {
    std::map<std::string, size_t> kinds;
    size_t roots = 0, coats = 0;
    double least = 1;
    for (size_t i = 0; i < found_.entries.size(); ++i) {
      if (found_.entries[i].parent >= 0) continue;
      ++kinds[std::string(kind_of(found_.entries[i].shape).name)];
      ++roots;
      coats += found_.entries[i].role == ShapeRole::Coat;
      if (agreements_[i]) least = std::min(least, agreements_[i]->inside);
    }
    context_.metric("shapes", static_cast<double>(roots));
    context_.metric("objects", static_cast<double>(objects_));
    context_.metric("coats", static_cast<double>(coats));
    std::string summary;
    for (const auto& [kind, count] : kinds) summary += fmt::format("{}{} {}", summary.empty() ? "" : ", ", count, kind);
    context_.summary(!summary.empty()           ? fmt::format("{}{}{}, {:.0f} % inside the masks", summary,
                                                    coats > 0 ? fmt::format(", {} of them coats", coats) : "",
                                                    given_ ? " (given)" : "", 100 * least)
                     : config_.source == "none" ? "shapes are off"
                     : std::ranges::any_of(silhouettes_, [](const auto& s) { return !s.empty(); })
                         ? "no object has a simple shape"
                         : "no glass or metal is marked");
  }

  const ShapesConfig& config_;
  StageContext& context_;
  const ViewSet set_;
  const std::optional<fs::path> masks_;
  std::array<std::vector<Silhouette>, kMaskClassCount> silhouettes_;
  ShapeSet found_;
  bool given_ = false;
  size_t objects_ = 0;
  std::optional<CoatTest> coat_test_;
  std::vector<std::optional<double>> view_dependence_;    // [entry] of opaque ones without a parent
  std::vector<std::optional<MaskAgreement>> agreements_;  // [entry] of those without a parent
};

}  // namespace

fs::path meant_shapes(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec) || path.filename() != "shapes.json") return path;
  const fs::directory_iterator files(path.parent_path(), ec);
  const auto is_mesh = [](const fs::directory_entry& f) {
    return f.path().extension() == ".ply" && f.path().stem().string().starts_with("shape_");
  };
  return !ec && std::ranges::any_of(files, is_mesh) ? path.parent_path() : path;
}

void describe(Describer& d, ShapesConfig& c) {
  d.option("source", c.source, "auto: the given file of shapes, else fitted to the masks; none: no shape is known.")
      .choices({"auto", "fitted", "none"});
  d.option("max_side", c.max_side, "Longest side of the masks that shapes are fitted to, pixels.").range(64, 4096);
  d.option("resolution", c.resolution, "Voxels along the longest side of the visual hull.").range(16, 512);
  d.option("dissent", c.dissent, "Share of the photos that may see a point outside the object before it is cut away.")
      .range(0, 0.5);
  d.option("free_form", c.free_form, "Fit a mesh to the silhouettes of objects that are no simple shape.");
  d.option("coat_below", c.coat_below,
           "An object of the specular masks whose view dependence is less has the role coat: it keeps its paint; 0: none has.")
      .range(0, 10);
  d.option("holdout_every", c.holdout_every,
           "Every how many photos one is kept for the evaluation and not looked at; as optimize.holdout_every.")
      .range(0, 100000);
}

void run_shapes(const ShapesConfig& config, StageContext& context) { ShapesRun(config, context).run(); }

Stage shapes_stage() {
  StageInfo info{.name = "shapes",
                 .version = 4,
                 .summary = "planes, boxes, surfaces of revolution and meshes that glass and metal have",
                 .inputs = {{.name = "sfm", .doc = "cameras and undistorted photos"},
                            {.name = "masks", .optional = true, .doc = "which pixels are glass or mirror"},
                            {.name = "shapes",
                             .artifact = false,
                             .optional = true,
                             .doc = "known shapes: a shapes.json of another run, corrected by hand, or its folder",
                             .meant = meant_shapes}},
                 .doing = "finding simple shapes",
                 .cost = shapes_cost,
                 .report = shapes_report()};
  return make_stage<ShapesConfig>(std::move(info), run_shapes);
}

}  // namespace vitrine
