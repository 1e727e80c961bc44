#include "core/light/lighting.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/config/text.h"
#include "core/config/yaml.h"

namespace vitrine {

float AreaLight::area() const { return (disc ? std::numbers::pi_v<float> : 4.f) * length(half_u) * length(half_v); }

Vec3f AreaLight::point(const Vec2f& uniform) const {
  if (!disc) return center + (2 * uniform.x - 1) * half_u + (2 * uniform.y - 1) * half_v;
  const float r = std::sqrt(uniform.x), a = 2 * std::numbers::pi_v<float> * uniform.y;
  return center + (r * std::cos(a)) * half_u + (r * std::sin(a)) * half_v;
}

std::optional<float> AreaLight::hit(const Vec3f& origin, const Vec3f& direction) const {
  const float facing = -dot(direction, normal);
  if (!(facing > 1e-6f)) return std::nullopt;
  const float t = dot(origin - center, normal) / facing;
  if (!(t > 0)) return std::nullopt;
  const Vec3f p = origin + t * direction - center;
  const float u = dot(p, half_u) / squared_length(half_u), v = dot(p, half_v) / squared_length(half_v);
  const bool inside = disc ? u * u + v * v <= 1 : std::abs(u) <= 1 && std::abs(v) <= 1;
  return inside ? std::optional(t) : std::nullopt;
}

LampSample Lighting::sample_lamp(size_t lamp, const Vec3f& point, const Vec2f& uniform) const {
  if (lamp < points.size()) {
    const Vec3f d = points[lamp].position - point;
    const float r2 = squared_length(d);
    if (!(r2 > 0)) return {};
    return {d / std::sqrt(r2), std::sqrt(r2), points[lamp].intensity / r2, 1.f};
  }
  if (lamp < sharp_lamps()) {
    const DirectionalLight& light = directionals[lamp - points.size()];
    return {light.towards, kFar, light.irradiance, 1.f};
  }
  const AreaLight& light = areas[lamp - sharp_lamps()];
  const Vec3f d = light.point(uniform) - point;
  const float r = length(d), facing = -dot(d, light.normal) / r;
  if (!(facing > 0)) return {};
  return {d / r, r, light.radiance, r * r / (facing * light.area())};
}

namespace {

// One lamp of the file, read key by key; what is wrong is collected.
class LampReader {
 public:
  LampReader(const YamlFile& file, const YamlNode& lamp, ConfigErrors& errors) : file_(file), lamp_(lamp), errors_(errors) {}

  void only(const std::vector<std::string>& keys) {
    for (const auto& [key, value] : lamp_.entries) {
      if (key.text == "type" || std::ranges::find(keys, key.text) != keys.end()) continue;
      const std::string near = nearest_word(key.text, keys);
      complain(key, fmt::format("unknown key '{}'{}", key.text, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
    }
  }
  Vec3f vector(const char* key) {
    const YamlNode* node = find(key);
    if (node == nullptr) return {};
    if (node->kind != YamlNode::Kind::List || node->items.size() != 3) {
      complain(*node, fmt::format("'{}' must be a list of three numbers", key));
      return {};
    }
    return {number(node->items[0]), number(node->items[1]), number(node->items[2])};
  }
  Vec3f direction(const char* key) {
    const Vec3f d = vector(key);
    if (squared_length(d) > 0) return normalized(d);
    if (const YamlNode* node = lamp_.find(key)) complain(*node, fmt::format("'{}' must not be zero", key));
    return {0, 0, 1};
  }
  Vec3f color(const char* key) {
    const YamlNode* node = find(key);
    if (node == nullptr) return {};
    Vec3f rgb;
    if (node->kind == YamlNode::Kind::Scalar)
      rgb.x = rgb.y = rgb.z = number(*node);
    else
      rgb = vector(key);
    if (rgb.x < 0 || rgb.y < 0 || rgb.z < 0) complain(*node, fmt::format("'{}' must not be negative", key));
    return rgb;
  }
  float positive(const char* key) {
    const YamlNode* node = find(key);
    return node == nullptr ? 1.f : positive(*node, key);
  }
  Vec2f size(const char* key) {
    const YamlNode* node = find(key);
    if (node == nullptr) return {1, 1};
    if (node->kind == YamlNode::Kind::List && node->items.size() == 2)
      return {positive(node->items[0], key), positive(node->items[1], key)};
    complain(*node, fmt::format("'{}' must be a list of two numbers", key));
    return {1, 1};
  }

 private:
  void complain(const YamlNode& at, const std::string& message) { errors_.add(file_, at.mark, at.text.size(), message); }
  const YamlNode* find(const char* key) {
    const YamlNode* node = lamp_.find(key);
    if (node == nullptr) complain(lamp_, fmt::format("this light needs '{}'", key));
    return node;
  }
  float number(const YamlNode& node) {
    float value = 0;
    const char* end = node.text.data() + node.text.size();
    const auto r = std::from_chars(node.text.data(), end, value);
    if (node.kind == YamlNode::Kind::Scalar && r.ec == std::errc() && r.ptr == end && std::isfinite(value)) return value;
    complain(node, fmt::format("a number is wanted, got \"{}\"", node.text));
    return 0;
  }
  float positive(const YamlNode& node, const char* key) {
    const float value = number(node);
    if (value > 0) return value;
    complain(node, fmt::format("'{}' must be above 0", key));
    return 1;
  }

  const YamlFile& file_;
  const YamlNode& lamp_;
  ConfigErrors& errors_;
};

void add_lamp(const YamlFile& file, const YamlNode& node, ConfigErrors& errors, Lighting& out) {
  const YamlNode* type = node.find("type");
  LampReader in(file, node, errors);
  if (type == nullptr) {
    errors.add(file, node.mark, 1, "this light needs 'type': point, directional, rectangle or disc");
  } else if (type->text == "point") {
    in.only({"position", "intensity"});
    out.points.push_back({in.vector("position"), in.color("intensity")});
  } else if (type->text == "directional") {
    in.only({"from", "irradiance"});
    out.directionals.push_back({in.direction("from"), in.color("irradiance")});
  } else if (type->text == "rectangle" || type->text == "disc") {
    AreaLight light;
    light.disc = type->text == "disc";
    in.only({"center", "facing", light.disc ? "radius" : "size", "radiance"});
    light.center = in.vector("center");
    light.normal = in.direction("facing");
    light.radiance = in.color("radiance");
    const Vec3f up = std::abs(light.normal.z) < 0.999f ? Vec3f{0, 0, 1} : Vec3f{0, 1, 0};
    const Vec3f u = normalized(cross(up, light.normal)), v = cross(light.normal, u);
    const Vec2f half = light.disc ? [&] { const float r = in.positive("radius"); return Vec2f{r, r}; }() : 0.5f * in.size("size");
    light.half_u = half.x * u;
    light.half_v = half.y * v;
    out.areas.push_back(light);
  } else {
    errors.add(file, type->mark, type->text.size(),
               fmt::format("there is no light of type \"{}\"; types are point, directional, rectangle, disc", type->text));
  }
}

}  // namespace

void parse_lamps(std::string_view text, const std::string& name, Lighting& lighting) {
  const YamlFile file = parse_yaml(text, name);
  ConfigErrors errors;
  const YamlNode* list = file.root.find("lights");
  if (list == nullptr || list->kind != YamlNode::Kind::List)
    errors.add(file, list != nullptr ? list->mark : file.root.mark, 1, "a list `lights:` is wanted");
  else
    for (const YamlNode& lamp : list->items) add_lamp(file, lamp, errors, lighting);
  errors.throw_if_any("core/light/lighting.h and stages/relit/README.md show a file with one light of each type");
}

void read_lamps(const fs::path& path, Lighting& lighting) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    throw Error(ErrorKind::Input, "there is no such file of lights", {.where = path.string(), .code = "MISSING_INPUT"});
  parse_lamps(read_file(path), path.string(), lighting);
}

}  // namespace vitrine
