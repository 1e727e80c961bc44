#include "core/scene/mesh/mesh_hits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/foundation/base/error.h"
#include "core/scene/mesh/embree_device.h"
#include "core/scene/mesh/embree_version.h"

namespace vitrine {

namespace {

// A ray through an edge hits both faces at distances that differ by rounding; they count as one surface.
constexpr float kEdgeStep = 4e-6f;

// Ties: the smallest face index, independent of the BVH.
struct FirstFace : embree::RayContext {
  float t = -1.f;
  uint32_t face = 0;
};
void keep_first_face(const RTCFilterFunctionNArguments* args) {
  auto& best = *static_cast<FirstFace*>(args->context);
  const float t = RTCRayN_tfar(args->ray, args->N, 0);
  const uint32_t face = RTCHitN_primID(args->hit, args->N, 0);
  if (t == best.t && face > best.face) {
    args->valid[0] = 0;
    return;
  }
  best.t = t;
  best.face = face;
}

// All faces are opaque unless transmittances are given.
struct AnyFace : embree::RayContext {
  const MeshHits::Panes* panes = nullptr;
  float share = 1;
  int passed = 0;
  std::array<float, MeshHits::kMostPanes> at{};  // distances of the panes hit so far
};
void pass_panes(const RTCFilterFunctionNArguments* args) {
  auto& any = *static_cast<AnyFace*>(args->context);
  if (any.panes == nullptr) return;
  const float through = any.panes->transmittance[RTCHitN_primID(args->hit, args->N, 0)], t = RTCRayN_tfar(args->ray, args->N, 0);
  if (!(through > 0)) return;
  const auto passed = any.at.begin() + any.passed;
  if (std::none_of(any.at.begin(), passed, [&](float at) { return std::abs(t - at) <= any.panes->same + kEdgeStep * t; })) {
    any.share *= through;
    if (any.share < any.panes->least || passed == any.at.end()) return;
    *passed = t;
    ++any.passed;
  }
  args->valid[0] = 0;
}

FaceHit face_hit(const RTCRayHit& r) {
  const Vec3f normal{r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z}, direction{r.ray.dir_x, r.ray.dir_y, r.ray.dir_z};
  return {r.ray.tfar, r.hit.primID, r.hit.u, r.hit.v, dot(normal, direction) > 0.f};
}

}  // namespace

struct MeshHits::Tree {
  embree::Scene scene = embree::Scene::robust();
};

MeshHits::MeshHits(const TriMesh& mesh) : tree_(std::make_unique<Tree>()), faces_(mesh.faces.size()) {
  for (const auto& face : mesh.faces)
    for (const uint32_t v : face)
      if (v >= mesh.positions.size())
        throw Error(ErrorKind::Input, "a face of the mesh names a vertex that does not exist",
                    {.why = fmt::format("vertex {} of {}", v, mesh.positions.size()),
                     .hint = "compute the mesh anew: --only mesh --force",
                     .code = "BAD_MESH"});
  RTCGeometry geometry = rtcNewGeometry(embree::device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
  for (size_t v = 0; v < mesh.positions.size(); ++v)
    for (size_t c = 0; c < 3; ++c) positions[3 * v + c] = mesh.positions[v][c];
  auto* faces = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), mesh.faces.size()));
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t c = 0; c < 3; ++c) faces[3 * f + c] = mesh.faces[f][c];
  rtcSetGeometryIntersectFilterFunction(geometry, keep_first_face);
  rtcSetGeometryOccludedFilterFunction(geometry, pass_panes);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(tree_->scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tree_->scene.get());
}

MeshHits::~MeshHits() = default;

RTCRayHit MeshHits::nearest(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  RTCRayHit r = embree::ray_hit(origin, direction, near, far);
  FirstFace context;
  embree::intersect(tree_->scene.get(), context, r);
  return r;
}

std::optional<FaceHit> MeshHits::first_face(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  const RTCRayHit r = nearest(origin, direction, near, far);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return face_hit(r);
}

std::optional<MeshHit> MeshHits::first_hit(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  const RTCRayHit r = nearest(origin, direction, near, far);
  if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return MeshHit{face_hit(r), normalized(Vec3f{r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z})};
}

std::optional<MeshHit> MeshHits::back_surface(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  std::optional<MeshHit> last_back;
  int open = 1;
  while (const std::optional<MeshHit> hit = first_hit(origin, direction, near, far)) {
    if (!hit->from_inside) {
      ++open;
    } else {
      last_back = hit;
      if (--open == 0) break;
    }
    near = hit->t * (1.f + kEdgeStep) + std::numeric_limits<float>::min();
  }
  return last_back;
}

bool MeshHits::occluded(const Vec3f& origin, const Vec3f& direction, float near, float far) const {
  RTCRay ray = embree::ray_hit(origin, direction, near, far).ray;
  AnyFace context;
  embree::occluded(tree_->scene.get(), context, ray);
  return ray.tfar < 0.f;
}

float MeshHits::transmittance(const Vec3f& origin, const Vec3f& direction, float far, const Panes& panes) const {
  VITRINE_CHECK(panes.transmittance.size() == faces_, "a transmittance for every face");
  RTCRay ray = embree::ray_hit(origin, direction, 0, far).ray;
  AnyFace context;
  context.panes = &panes;
  embree::occluded(tree_->scene.get(), context, ray);
  return ray.tfar < 0.f ? 0.f : context.share;
}

}  // namespace vitrine
