#include "sample_data/generate/ray_scene.h"

#include <limits>

#include "core/foundation/base/error.h"
#include "core/render/model/kernels/mirror.h"
#include "core/scene/mesh/embree_version.h"
#include "sample_data/generate/content.h"

namespace vitrine::generate {
namespace {

constexpr float kFarthest = 1e6f;
constexpr float kOffset = 2e-5f;  // metres; the scenes are a few metres wide, floats resolve 5e-7 there
constexpr int kMostPanes = 32;    // on one shadow ray; a bottle has four

void on_embree_error(void*, RTCError code, const char* text) {
  throw Error(ErrorKind::Internal, "Embree failed", {.why = text ? text : "", .code = std::to_string(static_cast<int>(code))});
}

RTCRayHit ray_hit(const Vec3f& o, const Vec3f& d, float near, float far) {
  RTCRayHit r{};
  r.ray.org_x = o.x, r.ray.org_y = o.y, r.ray.org_z = o.z;
  r.ray.dir_x = d.x, r.ray.dir_y = d.y, r.ray.dir_z = d.z;
  r.ray.tnear = near;
  r.ray.tfar = far;
  r.ray.mask = 0xffffffffu;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return r;
}

bool intersect(RTCScene tree, RTCRayHit& r) {
  embree::RayContext context;
  embree::intersect(tree, context, r);
  return r.hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

}  // namespace

struct RayScene::Trees {
  RTCDevice device = nullptr;
  RTCScene opaque = nullptr, glass = nullptr;
  bool has_glass = false, has_content = false;
  ~Trees() {
    if (glass) rtcReleaseScene(glass);
    if (opaque) rtcReleaseScene(opaque);
    if (device) rtcReleaseDevice(device);
  }
};

RayScene::RayScene(const Scene& scene) : scene_(scene), trees_(std::make_unique<Trees>()) {
  // One building thread: the shape of the tree, and with it the choice among equal hits, must not depend on the machine.
  trees_->device = rtcNewDevice("threads=1");
  if (!trees_->device) throw Error(ErrorKind::Dependency, "Embree has no device on this machine");
  rtcSetDeviceErrorFunction(trees_->device, on_embree_error, nullptr);
  for (RTCScene* tree : {&trees_->opaque, &trees_->glass}) {
    *tree = rtcNewScene(trees_->device);
    rtcSetSceneFlags(*tree, RTC_SCENE_FLAG_ROBUST);
  }
  for (size_t i = 0; i < scene.parts.size(); ++i) {
    const TriMesh& mesh = scene.parts[i].shape.mesh;
    const bool glass = scene.parts[i].material.glass();
    RTCGeometry geometry = rtcNewGeometry(trees_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                  3 * sizeof(float), mesh.positions.size()));
    for (size_t v = 0; v < mesh.positions.size(); ++v)
      for (size_t c = 0; c < 3; ++c) positions[3 * v + c] = mesh.positions[v][c];
    auto* faces = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), mesh.faces.size()));
    for (size_t f = 0; f < mesh.faces.size(); ++f)
      for (size_t c = 0; c < 3; ++c) faces[3 * f + c] = mesh.faces[f][c];
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(glass ? trees_->glass : trees_->opaque, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
    trees_->has_glass |= glass;
    trees_->has_content |= scene.parts[i].material.content != nullptr;
  }
  rtcCommitScene(trees_->opaque);
  rtcCommitScene(trees_->glass);
}

RayScene::~RayScene() = default;

bool RayScene::has_content() const { return trees_->has_content; }

std::optional<Hit> RayScene::first_hit(const Vec3f& origin, const Vec3f& direction, bool with_glass) const {
  RTCRayHit r = ray_hit(origin, direction, 0, kFarthest);
  bool found = intersect(trees_->opaque, r);
  if (with_glass && trees_->has_glass) {
    RTCRayHit pane = ray_hit(origin, direction, 0, r.ray.tfar);
    if (intersect(trees_->glass, pane)) {
      r = pane;
      found = true;
    }
  }
  if (!found) return std::nullopt;
  Hit hit;
  hit.part_index = r.hit.geomID;
  hit.part = &scene_.parts[hit.part_index];
  const Shape& shape = hit.part->shape;
  hit.vertices = shape.mesh.faces[r.hit.primID];
  hit.barycentric = {1.0f - r.hit.u - r.hit.v, r.hit.u, r.hit.v};
  hit.distance = r.ray.tfar;
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = hit.vertices[c];
    hit.position += hit.barycentric[c] * shape.mesh.positions[v];
    hit.normal += hit.barycentric[c] * shape.mesh.normals[v];
    hit.uv = hit.uv + hit.barycentric[c] * shape.uv[v];
  }
  const auto& at = shape.mesh.positions;
  hit.geometric = normalized(cross(at[hit.vertices[1]] - at[hit.vertices[0]], at[hit.vertices[2]] - at[hit.vertices[0]]));
  hit.normal = normalized(hit.normal);
  return hit;
}

float RayScene::transmittance(const Vec3f& origin, const Vec3f& direction, float distance, bool with_glass) const {
  embree::RayContext context;
  RTCRay shadow = ray_hit(origin, direction, 0, distance).ray;
  embree::occluded(trees_->opaque, context, shadow);
  if (shadow.tfar < 0) return 0;
  float passed = 1;
  if (!with_glass || !trees_->has_glass) return passed;
  float from = 0, entered = 0;
  for (int pane = 0; pane < kMostPanes; ++pane) {
    RTCRayHit r = ray_hit(origin, direction, from, distance);
    if (!intersect(trees_->glass, r)) break;
    const Vec3f n = normalized(Vec3f{r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z});
    const Material& material = scene_.parts[r.hit.geomID].material;
    const float index = material.index_of_refraction, cosine = dot(n, direction);
    passed *=
        1.0f - (material.kind == MaterialKind::ThinGlass ? sheet_reflectance(index, cosine)
                                                         : interface_reflectance(cosine < 0 ? index : 1.0f / index, cosine));
    if (material.content && cosine >= 0)
      passed *= material.content->transmittance(origin + entered * direction, direction, r.ray.tfar - entered);
    entered = r.ray.tfar;
    from = r.ray.tfar + kOffset;
  }
  return passed;
}

float RayScene::content_transmittance(const Vec3f& origin, const Vec3f& direction) const {
  float passed = 1;
  const GlassContent* within = nullptr;
  Vec3f from = origin, towards = direction;
  for (int pane = 0; trees_->has_content && pane < kMostPanes; ++pane) {
    const std::optional<Hit> hit = first_hit(from, towards);
    if (within) passed *= within->transmittance(from, towards, hit ? hit->distance : kFarthest);
    if (!hit || !hit->glass()) break;
    const Material& material = hit->part->material;
    const bool outer = dot(hit->geometric, towards) < 0;
    const Vec3f normal = outer ? hit->normal : -hit->normal;
    const float ratio = outer ? 1.0f / material.index_of_refraction : material.index_of_refraction;
    if (material.kind == MaterialKind::SolidGlass && !refract(towards, normal, ratio, towards))
      towards = towards - 2.0f * dot(towards, normal) * normal;
    else
      within = outer ? material.content.get() : nullptr;
    from = offset_origin(*hit, towards);
  }
  return passed;
}

const GlassContent* RayScene::content_at(const Vec3f& point) const {
  float from = 0;
  for (int pane = 0; trees_->has_content && pane < kMostPanes; ++pane) {
    RTCRayHit r = ray_hit(point, {0, 0, 1}, from, kFarthest);
    if (!intersect(trees_->glass, r)) break;
    const GlassContent* content = scene_.parts[r.hit.geomID].material.content.get();
    if (content) return r.hit.Ng_z > 0 ? content : nullptr;
    from = r.ray.tfar + kOffset;
  }
  return nullptr;
}

Vec3f offset_origin(const Hit& hit, const Vec3f& direction) {
  return hit.position + (dot(hit.geometric, direction) >= 0 ? kOffset : -kOffset) * hit.geometric;
}

}  // namespace vitrine::generate
