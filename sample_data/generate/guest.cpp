#include "sample_data/generate/guest.h"

#include <cmath>
#include <cstdio>

#include "core/foundation/base/error.h"
#include "sample_data/generate/content.h"

namespace vitrine::generate {
namespace {

Vec3f turned(const Vec3f& p, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
}

// The texture of the guest at a point of the host.
Texture moved_texture(Texture texture, const GuestPlace& place) {
  return [texture = std::move(texture), place](const SurfacePoint& at) {
    const Vec3f before = turned(at.position - Vec3f{place.x, place.y, 0}, -place.turn_rad);
    return texture({.position = before / place.scale, .normal = turned(at.normal, -place.turn_rad), .uv = at.uv});
  };
}

}  // namespace

GuestPlace guest_place(const std::string& text) {
  GuestPlace place;
  float degrees = 0;
  int end = 0;
  if (std::sscanf(text.c_str(), "%f,%f,%f,%f%n", &place.x, &place.y, &degrees, &place.scale, &end) != 4 ||
      size_t(end) != text.size() || !(place.scale > 0) || !std::isfinite(place.x + place.y + degrees + place.scale))
    throw Error(ErrorKind::Usage, "--guest-place is not X,Y,DEGREES,SCALE",
                {.where = text, .hint = "for example --guest-place 0.1,-0.2,30,0.5", .code = "USAGE"});
  place.turn_rad = degrees * kPi / 180;
  return place;
}

void add_guest(Scene& host, const Scene& guest, const GuestPlace& place) {
  for (Part& part : host.parts) part.object = false;
  for (const Part& original : guest.parts) {
    if (!original.object) continue;
    Part part = original;
    part.name = "guest_" + part.name;
    for (Vec3f& p : part.shape.mesh.positions) p = place.scale * turned(p, place.turn_rad) + Vec3f{place.x, place.y, 0};
    for (Vec3f& n : part.shape.mesh.normals) n = turned(n, place.turn_rad);
    if (part.material.content)
      part.material.content =
          std::make_shared<const GlassContent>(part.material.content->moved({place.x, place.y, 0}, place.turn_rad, place.scale));
    if (part.material.albedo) part.material.albedo = moved_texture(part.material.albedo, place);
    host.parts.push_back(std::move(part));
  }
}

}  // namespace vitrine::generate
