// What the tree has once: small geometry of core, and who may decide or read what. Each file that does such a thing by itself has
// its reason here, and a file that no longer does so leaves the list.
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

const fs::path kToolboxRoot = VITRINE_SOURCE_DIR;

struct ToolboxRule {
  const char* use;
  std::string home;         // folder of the one implementation
  const char* handwritten;  // a regular expression, found in a line
  const char* example;      // that it finds
  std::set<std::string> exceptions;
};

std::set<std::string> files_that_write(const ToolboxRule& rule) {
  const std::regex pattern(rule.handwritten);
  std::set<std::string> found;
  for (const char* folder : {"core", "stages", "pipeline"})
    for (const auto& e : fs::recursive_directory_iterator(kToolboxRoot / folder)) {
      const std::string extension = e.path().extension().string(), file = fs::relative(e.path(), kToolboxRoot).generic_string();
      if (!e.is_regular_file() || (extension != ".h" && extension != ".cpp") || file.starts_with(rule.home)) continue;
      std::istringstream text(read_file(e.path()));
      for (std::string line; std::getline(text, line);)
        if (std::regex_search(line, pattern)) found.insert(file);
    }
  return found;
}

TEST(Toolbox, IsUsedInsteadOfHandwrittenCopies) {
  const ToolboxRule rules[] = {
      {"projection() or image_point() of core/scene/camera/projection.h",
       "core/scene/camera/",
       R"(\bf[xy] \* .*\+ [\w.>-]*\bc[xy]\b)",
       "const double u = k.fx * p.x / p.z + k.cx, v = k.fy * p.y / p.z + k.cy;",
       {"core/render/raster/kernels/project.h",   // differentiable, of the homography of a surfel
        "core/observe/stereo/edge_field.cpp",     // on x / z, which its derivative needs, too
        "core/observe/stereo/patch_score.cpp"}},  // the matrix of a homography
      {"orthonormal_basis() of core/foundation/math/vec.h",
       "core/foundation/math/",
       R"(abs\(.*\? Vec3[df]\{[01], [01], [01]\})",
       "const Vec3d helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};",
       {"core/scene/light/lighting.cpp",   // users give sizes along these two: horizontal up to 2.6 degrees from the vertical
        "stages/export/bake/atlas.cpp"}},  // texture axes of a floor: x to the right, y up
      {"quantile_of() of core/foundation/math/quantile.h or upper_median() of core/foundation/math/median.h",
       "core/foundation/math/",
       R"(nth_element)",
       "std::nth_element(values.begin(), middle, values.end());",
       {"core/scene/mesh/mesh_distance.cpp",     // splits nodes of a tree of triangles
        "core/render/relight/subsurface.cpp",    // and of vertices
        "core/intake/photos/measures.cpp",       // uses the part on one side
        "stages/optimize/medium_samples.cpp"}},  // the element, not its value: its distance counts, too
      {"KdTree of core/foundation/math/kd_tree.h",
       "core/foundation/math/",
       R"(class \w*(Kd|Point)(Tree|Grid)\b)",
       "class PointTree {",
       {}},
      {"connected_components() of core/foundation/math/connected_components.h, or DisjointSets",
       "core/foundation/math/",
       R"(open\.back\(\)|stack\.back\(\)|(\w+)\[(\w+)\] = \1\[\1\[\2\]\])",
       "while (root[v] != v) v = root[v] = root[root[v]];",
       {}},
      {"VoxelGrid of core/foundation/math/voxel_grid.h",
       "core/foundation/math/",
       R"(size_t\(z\) \* size_t\(\w+)",
       "return (size_t(z) * size_t(ny) + size_t(y)) * size_t(nx) + size_t(x);",
       {}},
      {"the table of objects (core/scene/objects): the masks of glass and mirrors are read by the stage that makes it alone",
       "core/scene/objects/",
       R"(\b(read_view_mask|view_mask_path|mask_silhouette)\()",
       "auto mask = read_view_mask(artifact, MaskClass::Transparent, view);",
       {"core/scene/camera/view_masks.cpp", "core/scene/camera/view_masks.h", "core/observe/stereo/silhouette.cpp",
        "core/observe/stereo/silhouette.h",
        "core/learn/trainer/targets.cpp",                           // object and ignore
        "stages/evaluate/regions.cpp",                              // object and ignore
        "stages/optimize/transients.cpp",                           // ignore
        "stages/optimize/outputs.cpp",                              // writes those of the object that was trained
        "stages/masks/outputs.cpp", "stages/mark/run_results.cpp",  // make and show masks
        "stages/objects/labels.cpp", "stages/objects/objects.cpp"}},
      {"CarvingRule of core/observe/stereo/carving.h, which has the thresholds of carving",
       "core/observe/stereo/carving",
       R"(\boutlier_share = )",
       "constexpr CarvingRule kRule{.outlier_share = 0.08};",
       {}},
      {"the role that the objects stage decided (core/scene/objects)",
       "stages/objects/",
       R"(stereo/view_dependence|\blower_half)",
       "#include \"core/observe/stereo/view_dependence.h\"",
       {"core/observe/stereo/view_dependence.cpp", "stages/masks/proposed/found_mirrors.cpp",  // before there are objects
        "stages/masks/proposed/proposed_source.h"}},
      {"a file of data that a stage writes for others: a report.json is for people",
       "pipeline/",  // shows reports
       R"((read_file|read_json_file|parse)\(.*report\.json)",
       "read_json_file(mesh / \"report.json\", \"report\", read);",
       {}},
  };
  for (const ToolboxRule& rule : rules) {
    EXPECT_TRUE(std::regex_search(rule.example, std::regex(rule.handwritten))) << rule.handwritten;
    const std::set<std::string> found = files_that_write(rule);
    for (const std::string& file : found)
      EXPECT_TRUE(rule.exceptions.contains(file)) << file << " writes out what is in core: use " << rule.use;
    for (const std::string& file : rule.exceptions) EXPECT_TRUE(found.contains(file)) << file << " is no exception any more";
  }
}

}  // namespace
}  // namespace vitrine
