// Binary COLMAP models.
// cameras.bin:  u64 N, each: u32 id, i32 model, u64 width, u64 height, f64 params[k]
// images.bin:   u64 N, each: u32 id, f64 q[wxyz], f64 t[3], u32 camera, name, '\0', u64 M, M x {f64 x, f64 y, u64 point}
// points3D.bin: u64 N, each: u64 id, f64 xyz[3], u8 rgb[3], f64 error, u64 L, L x {u32 image, u32 index}
// rigs.bin:     u64 N, each: u32 id, u32 S, if S > 0: i32 type, u32 sensor of the reference, (S - 1) x {i32 type, u32 sensor, u8
// posed,
//               if posed: f64 q[wxyz], f64 t[3]}
// frames.bin:   u64 N, each: u32 id, u32 rig, f64 q[wxyz], f64 t[3], u32 D, D x {i32 type, u32 sensor, u64 image}
// Types: 0 camera, 1 IMU. Little-endian, no padding.
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "core/scene/camera/colmap_files.h"

namespace vitrine::colmap {

namespace {

static_assert(std::endian::native == std::endian::little, "COLMAP files are little-endian");

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T value(const char* what) {
    require(sizeof(T), what);
    T v;
    std::memcpy(&v, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return v;
  }
  // Reads items whose file layout equals their memory layout.
  template <class T>
  void fill(std::vector<T>& items, const char* what) {
    require(items.size() * sizeof(T), what);
    if (!items.empty()) std::memcpy(items.data(), bytes_.data() + at_, items.size() * sizeof(T));
    at_ += items.size() * sizeof(T);
  }
  // Reads a count of items of at least `item_bytes` each; the items must fit into the rest of the file.
  template <class Count = uint64_t>
  size_t count(size_t item_bytes, const char* what) {
    const auto n = value<Count>(what);
    const size_t left = bytes_.size() - at_;
    if (n > left / item_bytes)
      throw Malformed{
          fmt::format("at byte {} it announces {} {}, which need at least {} bytes each, but only {} bytes follow: "
                      "the file is truncated or damaged",
                      at_ - sizeof(Count), n, what, item_bytes, left)};
    return static_cast<size_t>(n);
  }
  std::string zero_terminated(const char* what) {
    const size_t end = bytes_.find('\0', at_);
    if (end == std::string_view::npos)
      throw Malformed{fmt::format("the {} at byte {} does not end: the file is truncated", what, at_)};
    std::string s(bytes_.substr(at_, end - at_));
    at_ = end + 1;
    return s;
  }
  void require(size_t n, const char* what) const {
    if (bytes_.size() - at_ < n)
      throw Malformed{fmt::format("it ends at byte {} inside {}: the file is truncated", bytes_.size(), what)};
  }
  void expect_end() const {
    if (at_ != bytes_.size())
      throw Malformed{fmt::format("{} bytes follow the last item: the count at its start is damaged", bytes_.size() - at_)};
  }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

constexpr int32_t kCameraSensor = 0;

void read_pose(Reader& in, Quatd& rotation, Vec3d& translation) {
  for (double* v : {&rotation.w, &rotation.x, &rotation.y, &rotation.z, &translation.x, &translation.y, &translation.z})
    *v = in.value<double>("a pose");
}

template <class T>
void append(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
template <class T>
void append_all(std::string& out, const std::vector<T>& items) {
  out.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(T));
}

}  // namespace

std::vector<ColmapCamera> cameras_from_binary(std::string_view bytes) {
  Reader in(bytes);
  std::vector<ColmapCamera> cameras(in.count(4 + 4 + 8 + 8 + 2 * 8, "cameras"));
  for (ColmapCamera& c : cameras) {
    c.id = in.value<uint32_t>("a camera id");
    c.model_id = in.value<int32_t>("a camera model id");
    const ColmapCameraType& type = known_camera_type(c.model_id);
    c.width = in.value<uint64_t>("a camera width");
    c.height = in.value<uint64_t>("a camera height");
    c.params.resize(type.parameter_count);
    in.fill(c.params, "camera parameters");
  }
  in.expect_end();
  return cameras;
}

std::vector<ColmapImage> images_from_binary(std::string_view bytes) {
  static_assert(sizeof(ColmapPoint2D) == 24, "2D points are copied as they lie in the file");
  Reader in(bytes);
  std::vector<ColmapImage> images(in.count(4 + 7 * 8 + 4 + 1 + 8, "images"));
  for (ColmapImage& image : images) {
    image.id = in.value<uint32_t>("an image id");
    read_pose(in, image.rotation, image.translation);
    image.camera_id = in.value<uint32_t>("a camera id");
    image.name = in.zero_terminated("image name");
    image.points.resize(in.count(24, "2D points"));
    in.fill(image.points, "2D points");
  }
  in.expect_end();
  return images;
}

std::vector<ColmapPoint3D> points_from_binary(std::string_view bytes) {
  static_assert(sizeof(ColmapTrackElement) == 8, "track elements are copied as they lie in the file");
  Reader in(bytes);
  std::vector<ColmapPoint3D> points(in.count(8 + 3 * 8 + 3 + 8 + 8, "3D points"));
  for (ColmapPoint3D& p : points) {
    p.id = in.value<uint64_t>("a point id");
    for (double* v : {&p.position.x, &p.position.y, &p.position.z}) *v = in.value<double>("a point");
    p.srgb = in.value<std::array<uint8_t, 3>>("a point colour");
    p.error_px = in.value<double>("a point error");
    p.track.resize(in.count(8, "track elements"));
    in.fill(p.track, "a track");
  }
  in.expect_end();
  return points;
}

std::vector<Rig> rigs_from_binary(std::string_view bytes) {
  Reader in(bytes);
  std::vector<Rig> rigs(in.count(4 + 4, "rigs"));
  for (Rig& rig : rigs) {
    rig.id = in.value<uint32_t>("a rig id");
    rig.sensors.resize(in.count<uint32_t>(4 + 4, "sensors"));
    for (Sensor& sensor : rig.sensors) {
      sensor.is_camera = in.value<int32_t>("a type of sensor") == kCameraSensor;
      sensor.id = in.value<uint32_t>("a sensor id");
      if (&sensor == rig.sensors.data()) continue;  // the reference
      sensor.has_pose = in.value<uint8_t>("a sensor") != 0;
      if (sensor.has_pose) read_pose(in, sensor.rotation, sensor.translation);
    }
  }
  in.expect_end();
  return rigs;
}

std::vector<Frame> frames_from_binary(std::string_view bytes) {
  Reader in(bytes);
  std::vector<Frame> frames(in.count(4 + 4 + 7 * 8 + 4, "frames"));
  for (Frame& frame : frames) {
    frame.id = in.value<uint32_t>("a frame id");
    frame.rig_id = in.value<uint32_t>("a rig id");
    read_pose(in, frame.rotation, frame.translation);
    for (size_t left = in.count<uint32_t>(4 + 4 + 8, "images of a frame"); left > 0; --left) {
      const bool is_camera = in.value<int32_t>("a type of sensor") == kCameraSensor;
      FrameImage image;
      image.camera_id = in.value<uint32_t>("a sensor id");
      image.image_id = in.value<uint64_t>("an image id");
      if (is_camera) frame.images.push_back(image);
    }
  }
  in.expect_end();
  return frames;
}

std::string binary_of(const std::vector<ColmapCamera>& cameras) {
  std::string out;
  append<uint64_t>(out, cameras.size());
  for (const ColmapCamera& c : cameras) {
    append<uint32_t>(out, c.id);
    append<int32_t>(out, c.model_id);
    append<uint64_t>(out, c.width);
    append<uint64_t>(out, c.height);
    append_all(out, c.params);
  }
  return out;
}

std::string binary_of(const std::vector<ColmapImage>& images) {
  std::string out;
  append<uint64_t>(out, images.size());
  for (const ColmapImage& image : images) {
    append<uint32_t>(out, image.id);
    for (double v : {image.rotation.w, image.rotation.x, image.rotation.y, image.rotation.z, image.translation.x,
                     image.translation.y, image.translation.z})
      append(out, v);
    append<uint32_t>(out, image.camera_id);
    out.append(image.name).push_back('\0');
    append<uint64_t>(out, image.points.size());
    append_all(out, image.points);
  }
  return out;
}

std::string binary_of(const std::vector<ColmapPoint3D>& points) {
  std::string out;
  append<uint64_t>(out, points.size());
  for (const ColmapPoint3D& p : points) {
    append<uint64_t>(out, p.id);
    for (double v : {p.position.x, p.position.y, p.position.z}) append(out, v);
    append(out, p.srgb);
    append(out, p.error_px);
    append<uint64_t>(out, p.track.size());
    append_all(out, p.track);
  }
  return out;
}

}  // namespace vitrine::colmap
