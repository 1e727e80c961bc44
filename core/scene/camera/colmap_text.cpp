// Text COLMAP models.
// cameras.txt:  CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]
// images.txt:   two lines per image: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then (X Y POINT3D_ID)*, possibly empty
// points3D.txt: POINT3D_ID X Y Z R G B ERROR (IMAGE_ID POINT2D_IDX)*
// rigs.txt:     RIG_ID NUM_SENSORS REF_TYPE REF_ID (TYPE SENSOR_ID HAS_POSE [QW QX QY QZ TX TY TZ])*
// frames.txt:   FRAME_ID RIG_ID QW QX QY QZ TX TY TZ NUM_DATA (TYPE SENSOR_ID IMAGE_ID)*, types CAMERA and IMU
// Lines that start with # are comments. Point id -1 means none. The name is the rest of its line and may contain spaces.
// Integers may have a decimal point ("320.0"), as in COLMAP. Scripts omit the lines of 2D points: a line that cannot be such a
// list and starts like an image is the next image.
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <type_traits>

#include <fmt/format.h>

#include "core/scene/camera/colmap_files.h"

namespace vitrine::colmap {

namespace {

class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  // Reads the next line without its terminator; false at the end of the text.
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    size_t end = text_.find('\n', at_);
    if (end == std::string_view::npos) end = text_.size();
    line = text_.substr(at_, end - at_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at_ = end + 1;
    ++number_;
    return true;
  }
  // Reads the next line that is neither empty nor a comment.
  bool next_record(std::string_view& line) {
    while (next(line)) {
      const size_t first = line.find_first_not_of(" \t");
      if (first != std::string_view::npos && line[first] != '#') return true;
    }
    return false;
  }
  size_t number() const { return number_; }

 private:
  std::string_view text_;
  size_t at_ = 0, number_ = 0;
};

// Splits one line into fields.
class Fields {
 public:
  Fields(std::string_view line, size_t line_number) : rest_(line), line_number_(line_number) {}

  bool at_end() {
    const size_t first = rest_.find_first_not_of(" \t");
    rest_.remove_prefix(first == std::string_view::npos ? rest_.size() : first);
    return rest_.empty();
  }
  std::string_view word(const char* what) {
    if (at_end()) throw Malformed{fmt::format("line {} ends before {}", line_number_, what)};
    const size_t end = std::min(rest_.find_first_of(" \t"), rest_.size());
    const std::string_view w = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return w;
  }
  template <class T>
  T number(const char* what) {
    const std::string_view w = word(what);
    T value{};
    if (parse(w, value)) return value;
    if constexpr (std::is_integral_v<T>)
      if (double decimal = 0; parse(w, decimal) && decimal == std::floor(decimal) && decimal >= 0 &&
                              decimal <= double(std::numeric_limits<T>::max()) && decimal < 9e15)
        return static_cast<T>(decimal);
    throw Malformed{fmt::format("line {}: '{}' is not {}", line_number_, w.substr(0, 40), what)};
  }
  uint64_t point_id() {
    const std::string_view before = rest_;
    if (word("a point id") == "-1") return kNoPoint3D;
    rest_ = before;
    return number<uint64_t>("a point id");
  }
  std::string_view rest(const char* what) {
    if (at_end()) throw Malformed{fmt::format("line {} ends before {}", line_number_, what)};
    std::string_view r = rest_;
    while (!r.empty() && (r.back() == ' ' || r.back() == '\t')) r.remove_suffix(1);
    rest_ = {};
    return r;
  }

 private:
  template <class T>
  static bool parse(std::string_view w, T& value) {
    if (w.size() > 1 && w[0] == '+') w.remove_prefix(1);
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    return error == std::errc() && end == w.data() + w.size();
  }
  std::string_view rest_;
  size_t line_number_;
};

void read_pose(Fields& fields, Quatd& rotation, Vec3d& translation) {
  for (double* v : {&rotation.w, &rotation.x, &rotation.y, &rotation.z, &translation.x, &translation.y, &translation.z})
    *v = fields.number<double>("a number of the pose");
}

// True for at least ten fields of which the tenth (the name) is not a number: not a list of 2D points.
bool begins_an_image(std::string_view line) {
  Fields fields(line, 0);
  try {
    fields.number<uint32_t>("");
    for (int i = 0; i < 7; ++i) fields.number<double>("");
    fields.number<uint32_t>("");
    if (fields.at_end()) return false;
  } catch (const Malformed&) {
    return false;
  }
  try {
    fields.number<double>("");
    return false;
  } catch (const Malformed&) {
    return true;
  }
}

}  // namespace

std::vector<ColmapCamera> cameras_from_text(std::string_view text) {
  std::vector<ColmapCamera> cameras;
  Lines lines(text);
  std::string_view line;
  while (lines.next_record(line)) {
    Fields fields(line, lines.number());
    ColmapCamera c;
    c.id = fields.number<uint32_t>("a camera id");
    const ColmapCameraType& type = known_camera_type(fields.word("a camera model"));
    c.model_id = type.id;
    c.width = fields.number<uint64_t>("a width");
    c.height = fields.number<uint64_t>("a height");
    while (!fields.at_end()) c.params.push_back(fields.number<double>("a camera parameter"));
    if (c.params.size() != type.parameter_count)
      throw Malformed{fmt::format("line {}: camera model {} has {} parameters, not {}", lines.number(), type.name,
                                  type.parameter_count, c.params.size())};
    cameras.push_back(std::move(c));
  }
  return cameras;
}

std::vector<ColmapImage> images_from_text(std::string_view text) {
  std::vector<ColmapImage> images;
  Lines lines(text);
  std::string_view line;
  bool ahead = false;  // `line` already holds the next image
  while (ahead || lines.next_record(line)) {
    ahead = false;
    Fields fields(line, lines.number());
    ColmapImage image;
    image.id = fields.number<uint32_t>("an image id");
    read_pose(fields, image.rotation, image.translation);
    image.camera_id = fields.number<uint32_t>("a camera id");
    image.name = fields.rest("the image name");
    const bool more = lines.next(line);
    ahead = more && begins_an_image(line);
    if (more && !ahead) {
      Fields points(line, lines.number());
      while (!points.at_end()) {
        ColmapPoint2D p;
        p.x = points.number<double>("a pixel coordinate");
        p.y = points.number<double>("a pixel coordinate");
        p.point3d_id = points.point_id();
        image.points.push_back(p);
      }
    }
    images.push_back(std::move(image));
  }
  return images;
}

std::vector<ColmapPoint3D> points_from_text(std::string_view text) {
  std::vector<ColmapPoint3D> points;
  Lines lines(text);
  std::string_view line;
  while (lines.next_record(line)) {
    Fields fields(line, lines.number());
    ColmapPoint3D p;
    p.id = fields.number<uint64_t>("a point id");
    for (double* v : {&p.position.x, &p.position.y, &p.position.z}) *v = fields.number<double>("a coordinate");
    for (uint8_t& c : p.srgb) c = fields.number<uint8_t>("a colour of 0..255");
    p.error_px = fields.number<double>("an error in pixels");
    while (!fields.at_end()) {
      ColmapTrackElement e;
      e.image_id = fields.number<uint32_t>("an image id");
      e.point2d_index = fields.number<uint32_t>("an index of a 2D point");
      p.track.push_back(e);
    }
    points.push_back(std::move(p));
  }
  return points;
}

std::vector<Rig> rigs_from_text(std::string_view text) {
  std::vector<Rig> rigs;
  Lines lines(text);
  std::string_view line;
  while (lines.next_record(line)) {
    Fields fields(line, lines.number());
    Rig rig;
    rig.id = fields.number<uint32_t>("a rig id");
    for (auto left = fields.number<uint32_t>("a number of sensors"); left > 0; --left) {
      Sensor sensor;
      sensor.is_camera = fields.word("a type of sensor") == "CAMERA";
      sensor.id = fields.number<uint32_t>("a sensor id");
      if (!rig.sensors.empty()) {  // the reference has no pose
        sensor.has_pose = fields.number<uint32_t>("0 or 1") != 0;
        if (sensor.has_pose) read_pose(fields, sensor.rotation, sensor.translation);
      }
      rig.sensors.push_back(sensor);
    }
    rigs.push_back(std::move(rig));
  }
  return rigs;
}

std::vector<Frame> frames_from_text(std::string_view text) {
  std::vector<Frame> frames;
  Lines lines(text);
  std::string_view line;
  while (lines.next_record(line)) {
    Fields fields(line, lines.number());
    Frame frame;
    frame.id = fields.number<uint32_t>("a frame id");
    frame.rig_id = fields.number<uint32_t>("a rig id");
    read_pose(fields, frame.rotation, frame.translation);
    for (auto left = fields.number<uint32_t>("a number of images"); left > 0; --left) {
      const bool is_camera = fields.word("a type of sensor") == "CAMERA";
      FrameImage image;
      image.camera_id = fields.number<uint32_t>("a sensor id");
      image.image_id = fields.number<uint64_t>("an image id");
      if (is_camera) frame.images.push_back(image);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::string text_of(const std::vector<ColmapCamera>& cameras) {
  std::string out = "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# Number of cameras: {}\n", cameras.size());
  for (const ColmapCamera& c : cameras) {
    fmt::format_to(to, "{} {} {} {}", c.id, known_camera_type(c.model_id).name, c.width, c.height);
    for (double p : c.params) fmt::format_to(to, " {}", p);
    out += '\n';
  }
  return out;
}

std::string text_of(const std::vector<ColmapImage>& images) {
  std::string out =
      "# Image list with two lines of data per image:\n"
      "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
      "#   POINTS2D[] as (X, Y, POINT3D_ID)\n";
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# Number of images: {}\n", images.size());
  for (const ColmapImage& i : images) {
    const Quatd& q = i.rotation;
    const Vec3d& t = i.translation;
    fmt::format_to(to, "{} {} {} {} {} {} {} {} {} {}\n", i.id, q.w, q.x, q.y, q.z, t.x, t.y, t.z, i.camera_id, i.name);
    const char* separator = "";
    for (const ColmapPoint2D& p : i.points) {
      fmt::format_to(to, "{}{} {} ", separator, p.x, p.y);
      if (p.point3d_id == kNoPoint3D)
        out += "-1";
      else
        fmt::format_to(to, "{}", p.point3d_id);
      separator = " ";
    }
    out += '\n';
  }
  return out;
}

std::string text_of(const std::vector<ColmapPoint3D>& points) {
  std::string out =
      "# 3D point list with one line of data per point:\n"
      "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  auto to = std::back_inserter(out);
  fmt::format_to(to, "# Number of points: {}\n", points.size());
  for (const ColmapPoint3D& p : points) {
    fmt::format_to(to, "{} {} {} {} {} {} {} {}", p.id, p.position.x, p.position.y, p.position.z, p.srgb[0], p.srgb[1], p.srgb[2],
                   p.error_px);
    for (const ColmapTrackElement& e : p.track) fmt::format_to(to, " {} {}", e.image_id, e.point2d_index);
    out += '\n';
  }
  return out;
}

}  // namespace vitrine::colmap
