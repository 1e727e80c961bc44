#include "core/scene/light/lighting.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/yaml.h"

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

std::string Lighting::idle_reason(size_t lamp, std::span<const Vec3f> lit) const {
  const bool sharp = lamp < sharp_lamps(), point = lamp < points.size();
  const Vec3f light = point   ? points[lamp].intensity
                      : sharp ? directionals[lamp - points.size()].irradiance
                              : areas[lamp - sharp_lamps()].radiance;
  if (!(std::max({light.x, light.y, light.z}) > 0))
    return fmt::format("its {} is 0", point ? "intensity" : sharp ? "irradiance" : "radiance");
  if (sharp) return {};
  const AreaLight& area = areas[lamp - sharp_lamps()];
  const bool faces = std::ranges::any_of(lit, [&](const Vec3f& p) { return dot(p - area.center, area.normal) > 0; });
  return faces ? "" : "it faces away from the whole scene: the sign of 'facing'?";
}

namespace {

// Parses one lamp. Errors are collected; a default value replaces a wrong one.
class LampReader {
 public:
  LampReader(YamlReader& in, const YamlNode& lamp) : in_(in), lamp_(lamp) {}

  Vec3f vector(const char* key) {
    const YamlNode* node = find(key);
    const auto v = node != nullptr ? in_.numbers(*node, 3, fmt::format("'{}' to be a list of three numbers", key)) : std::nullopt;
    return v ? Vec3f{float((*v)[0]), float((*v)[1]), float((*v)[2])} : Vec3f{};
  }
  Vec3f direction(const char* key) {
    const Vec3f d = vector(key);
    if (squared_length(d) > 0) return normalized(d);
    if (const YamlNode* node = lamp_.find(key)) in_.complain(*node, fmt::format("'{}' must not be zero", key));
    return {0, 0, 1};
  }
  Vec3f color(const char* key) {
    const YamlNode* node = find(key);
    if (node == nullptr) return {};
    Vec3f rgb;
    if (node->kind == YamlNode::Kind::Scalar)
      rgb.x = rgb.y = rgb.z = float(in_.number(*node).value_or(0));
    else
      rgb = vector(key);
    if (rgb.x < 0 || rgb.y < 0 || rgb.z < 0) in_.complain(*node, fmt::format("'{}' must not be negative", key));
    return rgb;
  }
  float positive(const char* key) {
    const YamlNode* node = find(key);
    return node != nullptr ? positive(*node, key, in_.number(*node)) : 1.f;
  }
  Vec2f size(const char* key) {
    const YamlNode* node = find(key);
    const auto v = node != nullptr ? in_.numbers(*node, 2, fmt::format("'{}' to be a list of two numbers", key)) : std::nullopt;
    return v ? Vec2f{positive(*node, key, (*v)[0]), positive(*node, key, (*v)[1])} : Vec2f{1, 1};
  }

 private:
  const YamlNode* find(const char* key) {
    const YamlNode* node = lamp_.find(key);
    if (node == nullptr) in_.complain(lamp_, fmt::format("this light needs '{}'", key));
    return node;
  }
  float positive(const YamlNode& node, const char* key, std::optional<double> value) {
    if (value && !(*value > 0)) in_.complain(node, fmt::format("'{}' must be above 0", key));
    return value && *value > 0 ? float(*value) : 1.f;
  }

  YamlReader& in_;
  const YamlNode& lamp_;
};

void add_lamp(YamlReader& reader, const YamlNode& node, Lighting& out) {
  const YamlNode* type = node.find("type");
  LampReader in(reader, node);
  if (type == nullptr) {
    reader.complain(node, "this light needs 'type': point, directional, rectangle or disc");
  } else if (type->text == "point") {
    reader.only_keys(node, {"type", "position", "intensity"});
    out.points.push_back({in.vector("position"), in.color("intensity")});
  } else if (type->text == "directional") {
    reader.only_keys(node, {"type", "from", "irradiance"});
    out.directionals.push_back({in.direction("from"), in.color("irradiance")});
  } else if (type->text == "rectangle" || type->text == "disc") {
    AreaLight light;
    light.disc = type->text == "disc";
    reader.only_keys(node, {"type", "center", "facing", light.disc ? "radius" : "size", "radiance"});
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
    reader.complain(*type,
                    fmt::format("there is no light of type \"{}\"; types are point, directional, rectangle, disc", type->text));
  }
}

// Lamps are stored by type, and their places in the same order.
void add_lamps(YamlReader& reader, const std::vector<YamlNode>& list, Lighting& out) {
  std::vector<std::string> points, directionals, areas;
  for (const YamlNode& lamp : list) {
    const size_t before[] = {out.points.size(), out.directionals.size()}, lamps = out.lamps();
    add_lamp(reader, lamp, out);
    if (out.lamps() == lamps) continue;
    auto& places = out.points.size() > before[0] ? points : out.directionals.size() > before[1] ? directionals : areas;
    places.push_back(fmt::format("{}:{}:{}", reader.name(), lamp.mark.line, lamp.mark.column));
  }
  for (const auto* places : {&points, &directionals, &areas}) out.places.insert(out.places.end(), places->begin(), places->end());
}

}  // namespace

void parse_lamps(std::string_view text, const std::string& name, Lighting& lighting) {
  YamlReader reader(parse_yaml(text, name));
  const YamlNode* list = reader.root().find("lights");
  if (list == nullptr || list->kind != YamlNode::Kind::List)
    reader.complain(list != nullptr ? *list : reader.root(), "a list `lights:` is wanted");
  else if (list->items.empty())
    reader.complain(*list, "this list has no lamp, and lights nothing");
  else
    add_lamps(reader, list->items, lighting);
  reader.finish("core/scene/light/lighting.h and stages/relight/README.md show a file with one light of each type");
}

void read_lamps(const fs::path& path, Lighting& lighting) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    throw Error(ErrorKind::Input, "there is no such file of lights",
                {.where = path.string(), .hint = "configs/lights has samples", .code = "MISSING_INPUT"});
  parse_lamps(read_file(path), path.string(), lighting);
}

}  // namespace vitrine
