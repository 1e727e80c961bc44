#include "stages/objects/objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/observe/stereo/silhouette.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/shape/shape_file.h"
#include "stages/objects/detect.h"
#include "stages/objects/roles.h"

namespace vitrine {

namespace {

constexpr std::array<MaskClass, 2> kClasses{MaskClass::Transparent, MaskClass::Specular};
constexpr double kDoubtful = 0.5;         // of a given object's pixels: below this share in the masks a warning is issued
constexpr double kFacetEdge_rel = 0.02;   // of a shape's size: edge length in shapes.ply
constexpr double kExactInside = 0.92;     // of a free form's pixels: minimum inside the masks to use its normals on a coat
constexpr double kLeastUnlocated = 0.02;  // of the pixels of a class: below, the unlocated pixels are mask specks
constexpr double kExplainedHull = 0.5;    // of an unfitted object's pixels: above this share in planes, these replace it

MaskClass class_of(ObjectRole role) { return is_glass(role) ? MaskClass::Transparent : MaskClass::Specular; }

// An object without an id: its shapes, and its own silhouettes where it was carved.
struct Found {
  ShapeSet shapes;
  std::optional<MaskedObject> carved = {};
  bool is_hull() const { return !shapes.entries.empty() && std::ranges::none_of(shapes.entries, &ShapeSet::Entry::exact); }
};

class ObjectsRun {
 public:
  ObjectsRun(const ObjectsConfig& config, StageContext& context)
      : config_(config),
        context_(context),
        views_(load_view_set(context.input("sfm"))),
        heldout_(heldout_views(context.input("sfm"), views_.views, config.holdout_every)),
        masks_(context.optional_input("masks")) {}

  void run() {
    read_masks();
    const auto given = context_.optional_input("objects");
    given_ = given && config_.source == ObjectSource::Auto;
    if (given_)
      take(*given);
    else if (config_.source != ObjectSource::None)
      fit();
    const fs::path folder = context_.output() / "objects";
    make_folders(folder / "labels");
    label();
    measure();
    write_objects(folder, set_);
    if (!set_.shapes.entries.empty()) write_mesh_ply(folder / "shapes.ply", all_shapes());
    if (!set_.empty())
      write_contact_sheet(folder / "contact_sheet.png", context_.input("sfm"), views_, LabelledObjects(context_.output(), set_));
    report();
  }

 private:
  void read_masks() {
    if (!masks_) return;
    for (const MaskClass kind : kClasses) {
      origin_[size_t(kind)] = mask_origin(*masks_, kind);
      auto& silhouettes = silhouettes_[size_t(kind)];
      for (uint32_t v = 0; v < views_.views.size(); ++v) {
        throw_if_interrupted();
        if (heldout_[v]) continue;
        const View& view = views_.views[v];
        if (auto s = mask_silhouette(*masks_, kind, view, view.intrinsics.limited_to(config_.max_side)))
          silhouettes.push_back(std::move(*s));
      }
      // If all specular pixels are glass, the remaining pixels have no hull.
      if (std::ranges::none_of(silhouettes, marks_something)) silhouettes.clear();
    }
    context_.progress({.fraction = 0.2, .text = "masks read", .values = {}});
  }

  void fit() {
    double done = 0.2;
    for (const MaskClass kind : kClasses) {
      if (silhouettes_[size_t(kind)].empty()) continue;
      std::vector<Found> found = find(kind);
      const size_t count = found.size();
      for (Found& f : found) add(kind, std::move(f));
      done += 0.3;
      context_.progress({.fraction = done, .text = fmt::format("{}: {} objects", name(kind), count), .values = {}});
    }
    decide_roles();
  }

  std::vector<Found> find(MaskClass kind) const {
    const HullDesc hull{.resolution = config_.hull_voxels};
    const auto& silhouettes = silhouettes_[size_t(kind)];
    std::vector<Found> out;
    ShapeSet fitted;  // all fitted shapes
    const auto add_planes = [&](const ShapeSet& planes) {
      for (const ShapeSet::Entry& plane : planes.entries) out.push_back({.shapes = {{plane}}});
      fitted.append(planes);
    };
    // Planes on walls first: inside their masks, objects in front of them cannot be segmented.
    add_planes(open_planes(kind, silhouettes, views_.points, true));
    const auto before = fitted.entries.empty() ? silhouettes : unexplained(silhouettes, fitted);
    for (MaskedObject& object : masked_objects(kind, before, hull)) {
      throw_if_interrupted();
      Found f{.shapes = detected_shapes(object, hull.rule, origin_[size_t(kind)].propagated), .carved = std::move(object)};
      if (!f.is_hull()) fitted.append(f.shapes);
      if (!f.shapes.entries.empty()) out.push_back(std::move(f));
    }
    const ShapeSet standing = open_planes(kind, unexplained(silhouettes, fitted), views_.points, false);
    if (!standing.entries.empty())
      std::erase_if(out, [&](const Found& f) { return f.is_hull() && mostly_shows(*f.carved, standing); });
    add_planes(standing);
    return out;
  }

  static bool mostly_shows(const MaskedObject& object, const ShapeSet& planes) {
    size_t marked = 0, left = 0;
    const std::vector<Silhouette> rest = unexplained(object.silhouettes, planes);
    for (size_t v = 0; v < rest.size(); ++v)
      for (size_t i = 0; i < rest[v].value.data().size(); ++i)
        marked += object.silhouettes[v].value.data()[i] >= 0.5f, left += rest[v].value.data()[i] >= 0.5f;
    return double(marked - left) > kExplainedHull * double(marked);
  }

  void add(MaskClass kind, Found found) {
    const auto id = static_cast<uint16_t>(set_.objects.size() + 1);
    for (ShapeSet::Entry& e : found.shapes.entries) e.object = id;
    set_.shapes.append(std::move(found.shapes));
    set_.objects.push_back({.id = id,
                            .name = {},
                            .role = kind == MaskClass::Transparent ? ObjectRole::ThinGlass : ObjectRole::Mirror,
                            .trust = trust_of(kind)});
    carved_.push_back(std::move(found.carved));
  }

  ObjectTrust trust_of(MaskClass kind) const { return object_trust(origin_[size_t(kind)].trust).value_or(ObjectTrust::Given); }

  void decide_roles() {
    if (!silhouettes_[size_t(MaskClass::Specular)].empty()) {
      const RoleTest test(context_.input("sfm"), silhouettes_[size_t(MaskClass::Specular)]);
      for (Object& object : set_.objects) {
        if (is_glass(object.role)) continue;
        throw_if_interrupted();
        const bool hull = is_hull(object.id);
        auto& figure = object.evidence.view_dependence;
        figure = hull ? test.view_dependence(*carved_[object.id - 1u]) : test.view_dependence(set_.shapes, object.id);
        object.role = object_role_of(MaskClass::Specular, figure, !hull, config_.coat_below);
      }
    }
    find_solids(set_, {context_.input("sfm"), views_, silhouettes_[size_t(MaskClass::Transparent)], heldout_});
    std::map<ObjectRole, int> numbers;
    for (Object& object : set_.objects) {
      object.name = numbered(object.role, ++numbers[is_glass(object.role) ? ObjectRole::ThinGlass : object.role]);
      for (ShapeSet::Entry& e : set_.shapes.entries)
        if (e.object == object.id) e.role = shape_role(object.role);
    }
  }

  static std::string numbered(ObjectRole role, int number) {
    return fmt::format("{}-{}", is_glass(role) ? "glass" : name(role), number);
  }

  bool is_hull(uint16_t id) const {
    return std::ranges::none_of(set_.shapes.entries, [&](const ShapeSet::Entry& e) { return e.object == id && e.exact; });
  }

  void take(const fs::path& given) {
    set_ = read_objects_file(given);
    for (const MaskClass kind : kClasses) {
      const bool any = std::ranges::any_of(
          set_.objects, [&](const Object& o) { return o.role != ObjectRole::Opaque && class_of(o.role) == kind; });
      if (any && silhouettes_[size_t(kind)].empty())
        context_.warning("OBJECTS_WITHOUT_MASKS",
                         fmt::format("objects of {} are given, but no {} mask marks anything: nothing trains on them (--masks)",
                                     kind == MaskClass::Transparent ? "glass" : "mirrors and coats", name(kind)));
    }
  }

  // Writes the label images; marked pixels without a shape become one extra object per class.
  void label() {
    if (!masks_) return;
    const auto [first, second] = unused_ids();
    const UnlocatedObjects unlocated{first, second};
    const std::vector<std::string> names = marked_objects(*masks_);
    std::vector<PhotoCounts> photos(views_.views.size());
    parallel_for(views_.views.size(), 1, [&](size_t v) {
      if (interrupt_signal() != 0) return;
      const Image16 labels = labelled_pixels(*masks_, views_.views[v], set_, unlocated);
      if (labels.empty()) return;
      const fs::path path = label_path(context_.output(), views_.views[v]);
      make_folders(path.parent_path());
      write_png16(path, labels);
      if (!heldout_[v]) photos[v] = counted(labels, marked_objects_path(*masks_, views_.views[v]), names);
    });
    throw_if_interrupted();
    PhotoCounts all;
    for (const PhotoCounts& photo : photos) {
      for (const auto& [id, count] : photo.pixels) all.pixels[id] += count, ++all.views[id];
      for (const auto& [pair, count] : photo.marked) all.marked[pair] += count;
    }
    for (const auto& [id, role] : {std::pair{unlocated.glass, ObjectRole::ThinGlass}, {unlocated.specular, ObjectRole::Coat}}) {
      double of_class = double(all.pixels[id]);
      for (const Object& o : set_.objects) of_class += is_glass(o.role) == is_glass(role) ? double(all.pixels[o.id]) : 0;
      if (!(double(all.pixels[id]) > kLeastUnlocated * of_class)) continue;  // ids missing in the table count 0 pixels
      set_.objects.push_back({.id = id, .name = unused_name(role), .role = role, .trust = trust_of(class_of(role))});
      if (set_.objects.back().trust != ObjectTrust::Guessed)
        context_.warning(
            "OBJECT_WITHOUT_SHAPE",
            fmt::format("{} ({:.0f} % of what the {} masks mark): the photos do not fix where it is, from all sides or "
                        "at all; it has no shape",
                        set_.objects.back().name, 100 * double(all.pixels[id]) / of_class, name(class_of(role))));
    }
    std::ranges::sort(set_.objects, {}, &Object::id);
    for (Object& object : set_.objects) object.evidence.views = all.views[object.id];
    if (!given_) take_names(all, names);
    context_.progress({.fraction = 0.9, .text = "labels written", .values = {}});
  }

  struct PhotoCounts {
    std::map<uint16_t, size_t> pixels, views;                // [id]
    std::map<std::pair<uint16_t, uint16_t>, size_t> marked;  // [id, 1 + marked object] pixels
  };
  static PhotoCounts counted(const Image16& labels, const fs::path& marked, const std::vector<std::string>& names) {
    PhotoCounts out;
    const ImageF marks = !names.empty() && fs::exists(marked) ? read_unchanged(marked) : ImageF();
    for (int y = 0; y < labels.height(); ++y)
      for (int x = 0; x < labels.width(); ++x) {
        const uint16_t id = labels.at(x, y);
        if (id == 0) continue;
        ++out.pixels[id];
        if (marks.empty()) continue;
        const float value = marks.at(x * marks.width() / labels.width(), y * marks.height() / labels.height(), 0);
        if (const auto mark = uint16_t(std::lround(65535.f * value)); mark > 0 && mark <= names.size()) ++out.marked[{id, mark}];
      }
    return out;
  }

  // An object takes the name of the marked object that most of its pixels belong to.
  void take_names(const PhotoCounts& counts, const std::vector<std::string>& names) {
    for (Object& object : set_.objects) {
      size_t most = 0, of = 0;
      for (size_t t = 1; t <= names.size(); ++t)
        if (const auto found = counts.marked.find({object.id, uint16_t(t)}); found != counts.marked.end() && found->second > most)
          most = found->second, of = t;
      if (of == 0 || names[of - 1].empty() || 2 * most < counts.pixels.at(object.id)) continue;
      object.name.clear();
      object.name = unused_name(names[of - 1]);
    }
  }

  bool has_name(const std::string& name) const {
    return std::ranges::any_of(set_.objects, [&](const Object& o) { return o.name == name; });
  }
  std::string unused_name(const std::string& word) const {
    std::string out = word;
    for (int n = 2; has_name(out); ++n) out = fmt::format("{}-{}", word, n);
    return out;
  }
  std::string unused_name(ObjectRole role) const {
    int n = 1;
    while (has_name(numbered(role, n))) ++n;
    return numbered(role, n);
  }
  std::pair<uint16_t, uint16_t> unused_ids() const {
    std::vector<uint16_t> out;
    for (uint16_t id = 1; out.size() < 2; ++id)
      if (set_.find(id) == nullptr) out.push_back(id);
    return {out[0], out[1]};
  }

  // Overlap of shapes and masks.
  void measure() {
    for (Object& object : set_.objects) {
      const auto& silhouettes = silhouettes_[size_t(class_of(object.role))];
      std::vector<uint8_t> own(set_.shapes.entries.size());
      for (size_t i = 0; i < own.size(); ++i) own[i] = set_.shapes.entries[i].object == object.id;
      if (silhouettes.empty() || std::ranges::count(own, 1) == 0) continue;
      throw_if_interrupted();
      const MaskAgreement agreement = mask_agreement(set_.shapes.kept(own), silhouettes);
      object.evidence.inside = agreement.inside, object.evidence.covered = agreement.covered;
      // The normals of a mesh with large occlusions are no better than those of a hull; coats do not use them.
      if (!given_ && object.role == ObjectRole::Coat && agreement.inside < kExactInside)
        for (ShapeSet::Entry& e : set_.shapes.entries)
          if (e.object == object.id && std::holds_alternative<TriangleShape>(e.shape)) e.exact = false;
      if (given_ && agreement.inside < kDoubtful)
        context_.warning("OBJECT_OUTSIDE_MASKS",
                         fmt::format("given object '{}': the {} masks mark only {:.0f} % of the pixels that show it", object.name,
                                     name(class_of(object.role)), 100 * agreement.inside));
    }
  }

  TriMesh all_shapes() const {
    TriMesh out;
    for (const ShapeSet::Entry& entry : set_.shapes.entries) {
      const TriMesh mesh = tessellated(entry.shape, kFacetEdge_rel * size_of(entry.shape));
      const auto first = static_cast<uint32_t>(out.positions.size());
      out.positions.insert(out.positions.end(), mesh.positions.begin(), mesh.positions.end());
      for (const auto& f : mesh.faces) out.faces.push_back({first + f[0], first + f[1], first + f[2]});
    }
    return out;
  }

  void report() {
    std::array<size_t, kObjectRoles> roles{};
    size_t guessed = 0;
    for (const Object& o : set_.objects) ++roles[size_t(o.role)], guessed += o.trust == ObjectTrust::Guessed;
    std::string summary;
    for (const ObjectRole role : {ObjectRole::ThinGlass, ObjectRole::SolidGlass, ObjectRole::Mirror, ObjectRole::Coat})
      if (const size_t count = roles[size_t(role)]; count > 0) {
        std::string word(name(role));
        std::ranges::replace(word, '_', ' ');
        summary += fmt::format("{}{} {}", summary.empty() ? "" : ", ", count, word);
      }
    context_.metric("objects", double(set_.objects.size()));
    context_.metric("shapes", double(std::ranges::count(set_.shapes.entries, true, &ShapeSet::Entry::exact)));
    context_.metric("coats", double(roles[size_t(ObjectRole::Coat)]));
    if (summary.empty()) summary = "no glass or metal is marked";
    context_.summary(summary + (given_ ? " (given)" : guessed > 0 ? "; guessed: no layer follows them" : ""));
  }

  const ObjectsConfig& config_;
  StageContext& context_;
  const ViewSet views_;
  const std::vector<uint8_t> heldout_;
  const std::optional<fs::path> masks_;
  std::array<std::vector<Silhouette>, kMaskClassCount> silhouettes_;  // of the training photos
  std::array<MaskOrigin, kMaskClassCount> origin_;
  ObjectSet set_;
  std::vector<std::optional<MaskedObject>> carved_;  // [object]
  bool given_ = false;
};

}  // namespace

fs::path meant_objects(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec) || path.filename() != "objects.json") return path;
  const fs::directory_iterator files(path.parent_path(), ec);
  const auto is_mesh = [](const fs::directory_entry& f) {
    return f.path().extension() == ".ply" && f.path().stem().string().starts_with("shape_");
  };
  return !ec && std::ranges::any_of(files, is_mesh) ? path.parent_path() : path;
}

void describe(Describer& d, ObjectsConfig& c) {
  d.choice("source", c.source, {"auto", "fitted", "none"},
           "auto: the given table, else shapes fitted to the masks; none: masks alone, no shape is known.");
  d.option("max_side", c.max_side, "Longest side of the masks that shapes are fitted to, pixels.").range(64, 4096);
  d.option("coat_below", c.coat_below,
           "An object of the specular masks whose view dependence is less has the role coat: it keeps its paint; 0: none has.")
      .range(0, 10);
  d.option("holdout_every", c.holdout_every,
           "Every how many photos one is kept for the evaluation and not looked at; as optimize.holdout_every.")
      .range(0, 100000);
}

void run_objects(const ObjectsConfig& config, StageContext& context) { ObjectsRun(config, context).run(); }

Stage objects_stage() {
  StageInfo info{.name = "objects",
                 .version = 2,
                 .summary = "the table of objects: glass, mirrors and coats, with shapes, roles and labels",
                 .inputs = {{.name = "sfm", .doc = "cameras and undistorted photos"},
                            {.name = "masks", .optional = true, .doc = "which pixels are glass or mirror"},
                            {.name = "objects",
                             .artifact = false,
                             .optional = true,
                             .doc = "a table of objects: objects.json of another run, corrected by hand, or its folder",
                             .meant = meant_objects}},
                 .doing = "finding glass, mirrors and coats",
                 .cost = objects_cost,
                 .report = objects_report()};
  return make_stage<ObjectsConfig>(std::move(info), run_objects);
}

}  // namespace vitrine
