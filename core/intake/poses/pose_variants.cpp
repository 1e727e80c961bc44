#include "core/intake/poses/pose_variants.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

namespace {

// Columns: x, y and z axes of the file's camera frame in the program's frame.
struct CameraAxes {
  const char* text;
  Mat3d ours_from_file;
};
const CameraAxes kOpenCv{"x right, y down, z forward (OpenCV's)", Mat3d::identity()};
const CameraAxes kOpenGl{"x right, y up, z backward (OpenGL's)", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
const CameraAxes kRobots{"x forward, y left, z up (ROS's)", {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}};
const CameraAxes kUnity{"x right, y up, z forward (left-handed)", {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
const CameraAxes kUnreal{"x forward, y right, z up (left-handed)", {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}}};

int inverse_orientation(int orientation) { return orientation == 6 ? 8 : orientation == 8 ? 6 : orientation; }

// Applies a change to a pose in its original, unrotated form.
class Unturned {
 public:
  explicit Unturned(const PosePixels& pixels) {
    for (const PosedPhoto& p : pixels.photos) turn_[p.name] = p.for_stored ? p.orientation : 1;
  }
  template <class F>
  ColmapModel changed(const ColmapModel& model, const F& change) const {
    ColmapModel out = model;
    for (ColmapImage& image : out.images) {
      const auto found = turn_.find(image.name);
      const int orientation = found == turn_.end() ? 1 : found->second;
      const Rigid as_read = upright_pose(image.cam_from_world(), inverse_orientation(orientation));
      const Rigid pose = upright_pose(change(as_read), orientation);
      image.rotation = quaternion(pose.rotation);
      image.translation = pose.translation;
    }
    return out;
  }

 private:
  std::map<std::string, int> turn_;
};

// Natural sort order: "img2" before "img10".
bool counts_before(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      size_t ie = i, je = j;
      while (ie < a.size() && digit(a[ie])) ++ie;
      while (je < b.size() && digit(b[je])) ++je;
      std::string na = a.substr(i, ie - i), nb = b.substr(j, je - j);
      na.erase(0, std::min(na.find_first_not_of('0'), na.size()));
      nb.erase(0, std::min(nb.find_first_not_of('0'), nb.size()));
      if (na.size() != nb.size()) return na.size() < nb.size();
      if (na != nb) return na < nb;
      i = ie, j = je;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

}  // namespace

std::string rule_of(PoseSource source) {
  switch (source) {
    case PoseSource::Transforms:
      return "in transforms.json a transform_matrix is world-from-camera, with camera axes x right, y up, z backward";
    case PoseSource::Colmap:
      return "in images.txt a pose is camera-from-world (QW QX QY QZ TX TY TZ), with camera axes x right, y down, z forward";
    case PoseSource::Matrices:
      return "a projection matrix is P = K [R | t] in pixels, camera-from-world, with camera axes x right, y down, z forward";
    case PoseSource::Metashape:
      return "in Metashape's XML the transform of a camera is chunk-from-camera, with camera axes x right, y down, z forward";
    case PoseSource::OpenSfm:
      return "in reconstruction.json rotation (axis times angle) and translation are camera-from-world, with camera axes x "
             "right, y "
             "down, z forward";
    case PoseSource::OpenMvg:
      return "in sfm_data.json rotation is camera-from-world and center the camera's place, with camera axes x right, y down, z "
             "forward";
  }
  return {};
}

namespace {

// Instructions for the most common mistakes; for the others the rule of the format.
std::string fix_of(PoseSource source, const CameraAxes& axes, bool inverted) {
  const bool transforms = source == PoseSource::Transforms;
  const CameraAxes &format = transforms ? kOpenGl : kOpenCv, &other = transforms ? kOpenCv : kOpenGl;
  std::string fix;
  if (inverted) fix = transforms ? "invert every transform_matrix" : "invert every pose";
  if (&axes == &other)
    fix +=
        std::string(fix.empty() ? "" : ", then ") + (transforms ? "negate the second and third column of every transform_matrix"
                                                                : "negate the second and third row of every [R | t]");
  else if (&axes != &format)
    fix.clear();
  const std::string rule = rule_of(source);
  return fix.empty() ? "change the poses: " + rule : fix + ": " + rule;
}

// Poses of which one half follows the format and the other half its inverse.
struct MixedPose {
  std::string what, fix;
  std::function<Rigid(const Rigid& as_read)> pose;
};

Rigid with_centre(const Mat3d& rotation, const Vec3d& centre) { return {rotation, -(rotation * centre)}; }

// With A = diag(1, -1, -1), the file's 3x3 part is S = R^T A and its last column the centre C, for the pose (R, -R C) as read.
std::vector<MixedPose> mixed_in_transforms() {
  const Mat3d flip = kOpenGl.ours_from_file;
  const std::string transpose = "transpose the rotation (the first three rows and columns) of every transform_matrix";
  const std::string cv = fmt::format(", and their camera axes are {}, not {}", kOpenCv.text, kOpenGl.text);
  const char* const columns = "the last columns are the translations -R C, not the camera centres";
  const std::string centres = "write the camera centre into the last column of every transform_matrix";
  const auto centre = [](const Rigid& p) { return inverse(p).translation; };
  return {
      {"the rotations are transposed (the camera centres are right)", transpose,
       [=](const Rigid& p) { return with_centre(flip * transposed(p.rotation) * flip, centre(p)); }},
      {"the rotations are transposed (the camera centres are right)" + cv,
       transpose + ", then negate its second and third column",
       [=](const Rigid& p) { return with_centre(transposed(p.rotation) * flip, centre(p)); }},
      {"the rotations are transposed (the camera centres are right), and columns were negated afterwards",
       "transpose each rotation, then negate its second and third column",
       [=](const Rigid& p) { return with_centre(transposed(p.rotation), centre(p)); }},
      {columns, centres,
       [=](const Rigid& p) {
         return Rigid{p.rotation, flip * centre(p)};
       }},
      {columns + cv, centres + ", then negate the second and third column",
       [=](const Rigid& p) {
         return Rigid{flip * p.rotation, centre(p)};
       }},
      {std::string(columns) + ", in camera axes " + kOpenCv.text, centres,
       [=](const Rigid& p) {
         return Rigid{p.rotation, centre(p)};
       }},
  };
}

// Of (R, t) as read.
std::vector<MixedPose> mixed_in_projections() {
  const Mat3d flip = kOpenGl.ours_from_file;
  const std::string gl = fmt::format(", and their camera axes are {}, not {}", kOpenGl.text, kOpenCv.text);
  const char* const centres = "their translations are the camera centres, not -R C";
  const char* const transpose = "transpose every rotation";
  return {
      {centres, "write t = -R C", [](const Rigid& p) { return with_centre(p.rotation, p.translation); }},
      {centres + gl, "negate the second and third row of every rotation, then write t = -R C",
       [=](const Rigid& p) { return with_centre(flip * p.rotation, p.translation); }},
      {"the rotations are transposed (the translations are right)", transpose,
       [](const Rigid& p) {
         return Rigid{transposed(p.rotation), p.translation};
       }},
      {"the rotations are transposed (the camera centres are right)", std::string(transpose) + ", then write t = -R C",
       [](const Rigid& p) { return with_centre(transposed(p.rotation), inverse(p).translation); }},
  };
}

}  // namespace

std::vector<PoseVariant> convention_variants(const ColmapModel& model, const PosePixels& pixels) {
  std::vector<PoseVariant> out;
  const bool transforms = pixels.source == PoseSource::Transforms;
  const CameraAxes& format = transforms ? kOpenGl : kOpenCv;
  const Unturned unturned(pixels);
  const char* const inverse_text =
      transforms ? "they are camera-from-world, not world-from-camera" : "they are world-from-camera, not camera-from-world";
  const auto add = [&](const CameraAxes& axes, bool inverted) {
    const bool mirrors = determinant(axes.ours_from_file) < 0;
    const Mat3d turn = inverted ? axes.ours_from_file : axes.ours_from_file * transposed(format.ours_from_file);
    PoseVariant& v = out.emplace_back();
    v.hint = fix_of(pixels.source, axes, inverted);
    if (inverted) v.what = inverse_text;
    if (&axes != &format)
      v.what += fmt::format("{}their camera axes are {}, not {}", inverted ? ", and " : "", axes.text, format.text);
    v.model = unturned.changed(model, [&](const Rigid& as_read) {
      const Rigid pose = inverted ? inverse(as_read) : as_read;
      Rigid turned{turn * pose.rotation, turn * pose.translation};
      if (mirrors) turned.rotation = turned.rotation * kUnity.ours_from_file;  // mirrors the world with the camera
      return turned;
    });
  };
  add(transforms ? kOpenCv : kOpenGl, false);
  add(kRobots, false);
  for (const CameraAxes* axes : {&kOpenCv, &kOpenGl, &kRobots}) add(*axes, true);
  for (const bool inverted : {false, true})
    for (const CameraAxes* axes : {&kUnity, &kUnreal}) add(*axes, inverted);
  if (pixels.source == PoseSource::Colmap)
    for (const bool inverted : {false, true})
      out.push_back({std::string("their quaternions are in the order x y z w, not w x y z") +
                         (inverted ? ", they are world-from-camera" : ""),
                     rule_of(pixels.source), unturned.changed(model, [&](Rigid pose) {
                       const Quatd q = quaternion(pose.rotation);
                       pose.rotation = rotation_matrix(normalized(Quatd{q.z, q.w, q.x, q.y}));
                       return inverted ? inverse(pose) : pose;
                     })});
  std::vector<MixedPose> mixed = transforms ? mixed_in_transforms() : mixed_in_projections();
  for (MixedPose& m : mixed) out.push_back({m.what, m.fix + ": " + rule_of(pixels.source), unturned.changed(model, m.pose)});
  return out;
}

std::vector<PoseVariant> order_variants(const ColmapModel& model) {
  std::vector<std::string> words;
  for (const ColmapImage& image : model.images) words.push_back(image.name);
  const size_t n = words.size();
  std::vector<PoseVariant> out;
  // Image i of the model gets the name `name_of(i)`.
  const auto add = [&](std::string what, const auto& name_of) {
    PoseVariant v{std::move(what), "give every pose the name of the photo that it belongs to", model};
    for (size_t i = 0; i < n; ++i) v.model.images[i].name = name_of(i);
    out.push_back(std::move(v));
  };
  for (const size_t k : {size_t{1}, size_t{2}}) {
    if (k >= n) continue;
    const char* const by = k == 1 ? "" : " but one";
    add(fmt::format("each photo has the pose of the photo before it{}", by), [&](size_t i) { return words[(i + n - k) % n]; });
    add(fmt::format("each photo has the pose of the photo after it{}", by), [&](size_t i) { return words[(i + k) % n]; });
  }
  add("they are in reverse order", [&](size_t i) { return words[n - 1 - i]; });
  std::vector<std::string> numbers = words;
  std::stable_sort(numbers.begin(), numbers.end(), counts_before);
  if (numbers != words) {
    std::map<std::string, size_t> place_in_numbers;
    for (size_t i = 0; i < n; ++i) place_in_numbers[numbers[i]] = i;
    add("they were written in the order of numbers (2, 10), and named in the order of words (10, 2)",
        [&](size_t i) { return numbers[i]; });
    add("they were written in the order of words (10, 2), and named in the order of numbers (2, 10)",
        [&](size_t i) { return words[place_in_numbers.at(words[i])]; });
  }
  return out;
}

namespace {

// A convention of intrinsics without pixels: focal lengths and principal point for sides of 1, or of 2 (from -1 to 1).
struct NormalizedIntrinsics {
  const char* what;
  bool each_side;    // relative to its own side; else to the longest
  bool from_middle;  // the principal point
  double side;       // length of a side
};
constexpr NormalizedIntrinsics kNormalized[] = {
    {"fractions of the width and the height", true, false, 1},
    {"fractions of the longest side, with the principal point from the middle (OpenSfM's)", false, true, 1},
    {"fractions of the longest side", false, false, 1},
    {"in a picture from -1 to 1 (normalised device coordinates)", true, true, 2}};

constexpr double kNormalizedFocal = 16;  // a lens longer than that has a field of view below 4 degrees; in pixels it has 120

// Principal points outside the unit square are in pixels, as the middle is where a file has none.
ColmapCamera denormalized(const ColmapCamera& c, const PixelSize& given, const NormalizedIntrinsics& n) {
  ColmapCamera out = c;
  const bool two = has_two_focals(c.model_id);
  const double sides[] = {double(c.width), double(c.height)}, file_sides[] = {given.width, given.height};
  const double longest = std::max(sides[0], sides[1]);
  const size_t centre = two ? 2 : 1;
  for (size_t k = 0; k < 2; ++k) {
    const double as_written = file_sides[k] / sides[k], unit = (n.each_side ? sides[k] : longest) / n.side;
    if (k == 0 || two) out.params[k] = c.params[k] * as_written * unit;
    const double at = c.params[centre + k] * as_written;
    if (std::abs(at) <= 1) out.params[centre + k] = n.from_middle ? 0.5 * sides[k] + at * unit : at * unit;
  }
  return out;
}

void add_normalized(const ColmapModel& model, const PosePixels& pixels, std::vector<PoseVariant>& out) {
  std::map<std::string, PixelSize> size_of_photo;
  for (const PosedPhoto& p : pixels.photos)
    size_of_photo[p.name] = p.for_stored && swaps_sides(p.orientation) ? PixelSize{p.given.height, p.given.width} : p.given;
  std::map<uint32_t, PixelSize> size_of;
  for (const ColmapImage& image : model.images)
    if (const auto found = size_of_photo.find(image.name); found != size_of_photo.end()) size_of[image.camera_id] = found->second;
  const auto normalized = [&](const ColmapCamera& c) {
    const auto given = size_of.find(c.id);
    return given != size_of.end() && c.params[0] * given->second.width / double(c.width) < kNormalizedFocal;
  };
  if (!std::all_of(model.cameras.begin(), model.cameras.end(), normalized)) return;
  for (const NormalizedIntrinsics& n : kNormalized) {
    PoseVariant v{fmt::format("the intrinsics are {}, not pixels", n.what),
                  "give focal lengths and principal points in pixels, like width and height", model};
    for (ColmapCamera& camera : v.model.cameras) camera = denormalized(camera, size_of.at(camera.id), n);
    out.push_back(std::move(v));
  }
}

}  // namespace

std::vector<PoseVariant> focal_variants(const ColmapModel& model, const PosePixels& pixels) {
  std::vector<PoseVariant> out;
  add_normalized(model, pixels, out);
  for (const double factor : {2.0, 0.5, 4.0, 0.25, 8.0, 0.125}) {
    PoseVariant v{{}, {}, model};
    double before = 0;
    for (ColmapCamera& camera : v.model.cameras) {
      before = camera.params[0];
      camera.params[0] *= factor;
      if (has_two_focals(camera.model_id)) camera.params[1] *= factor;
    }
    v.what = fmt::format("the focal length is about {:.3g} times as long ({:.0f} instead of {:.0f} pixels)", factor,
                         factor * before, before);
    v.hint = fmt::format("give the focal length in pixels of a picture of {} x {}, like width and height", model.cameras[0].width,
                         model.cameras[0].height);
    out.push_back(std::move(v));
  }
  return out;
}

ColmapModel turned_other_way(ColmapModel model, PosePixels& pixels) {
  std::map<std::string, const PosedPhoto*> open;
  bool mirrored = false;
  for (PosedPhoto& p : pixels.photos) {
    if (p.settled) continue;
    p.for_stored = !p.for_stored;
    mirrored |= is_mirrored(p.orientation);
    open[p.name] = &p;
  }
  // Unsettled photos have cameras of their own (given_poses.cpp): rotate each once.
  std::map<uint32_t, int> cameras;
  for (ColmapImage& image : model.images) {
    const auto found = open.find(image.name);
    if (found == open.end()) continue;
    const PosedPhoto& p = *found->second;
    const int turn = p.for_stored ? p.orientation : inverse_orientation(p.orientation);
    const PixelSize from = p.for_stored ? p.stored : p.upright;
    const Rigid pose = upright_pose(image.cam_from_world(), turn);
    image.rotation = quaternion(pose.rotation);
    image.translation = pose.translation;
    for (ColmapPoint2D& q : image.points) {
      const Vec2d to = upright_pixel({q.x, q.y}, turn, from);
      q.x = to.x, q.y = to.y;
    }
    cameras[image.camera_id] = turn;
  }
  for (ColmapCamera& camera : model.cameras)
    if (const auto found = cameras.find(camera.id); found != cameras.end()) camera = upright_camera(camera, found->second);
  if (mirrored)
    for (ColmapPoint3D& p : model.points) p.position = mirrored_world(p.position);
  return model;
}

ColmapModel as_cropped(ColmapModel model, const PosePixels& pixels) {
  std::map<std::string, const PosedPhoto*> photo_of;
  for (const PosedPhoto& p : pixels.photos) photo_of[p.name] = &p;
  std::map<uint32_t, const PosedPhoto*> cameras;
  // Upright photo: from pixels of the resized picture to those of its central crop.
  const auto middle = [](const PosedPhoto& p) {
    const bool swapped = p.for_stored && swaps_sides(p.orientation);
    const PixelSize given = swapped ? PixelSize{p.given.height, p.given.width} : p.given;
    struct {
      double sx, sy, x0, y0;
    } m{given.width / p.upright.width, given.height / p.upright.height, 0.5 * (p.upright.width - given.width),
        0.5 * (p.upright.height - given.height)};
    return m;
  };
  for (ColmapImage& image : model.images) {
    const PosedPhoto& p = *photo_of.at(image.name);
    const auto m = middle(p);
    for (ColmapPoint2D& q : image.points) q.x = m.sx * q.x + m.x0, q.y = m.sy * q.y + m.y0;
    cameras[image.camera_id] = &p;
  }
  for (ColmapCamera& camera : model.cameras) {
    const auto found = cameras.find(camera.id);
    if (found == cameras.end()) continue;
    const auto m = middle(*found->second);
    const bool two = has_two_focals(camera.model_id);
    const size_t centre = two ? 2 : 1;
    camera.params[0] *= two ? m.sx : 0.5 * (m.sx + m.sy);
    if (two) camera.params[1] *= m.sy;
    camera.params[centre] = m.sx * camera.params[centre] + m.x0;
    camera.params[centre + 1] = m.sy * camera.params[centre + 1] + m.y0;
  }
  return model;
}

}  // namespace vitrine
