#include "stages/export/formats/gaussian_ply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/rigid.h"
#include "core/foundation/math/spherical_harmonics.h"

namespace vitrine {

static_assert(std::endian::native == std::endian::little, "the writer copies floats as they are");

void write_gaussian_ply(const std::filesystem::path& path, const SplatLayer& layer, const GaussianPlyDesc& desc) {
  const size_t rest = layer.width(Attribute::ShRest) / 3;  // coefficients per channel above the DC
  const int degree = std::max(layer.sh_degree(), desc.least_degree);
  const size_t padded = size_t((degree + 1) * (degree + 1) - 1);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& c : desc.comments) header += "comment " + c + "\n";
  header += fmt::format("element vertex {}\n", layer.size());
  size_t properties = 0;
  const auto property = [&](const std::string& name) {
    header += "property float " + name + "\n";
    ++properties;
  };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) property(name);
  for (size_t i = 0; i < 3 * padded; ++i) property(fmt::format("f_rest_{}", i));
  property("opacity");
  for (size_t i = 0; i < (desc.thickness > 0 ? 3u : 2u); ++i) property(fmt::format("scale_{}", i));
  for (size_t i = 0; i < 4; ++i) property(fmt::format("rot_{}", i));
  for (const MoreProperty& m : desc.more) {
    VITRINE_CHECK(m.values.size() == layer.size(), "{} values of {} for {} surfels", m.values.size(), m.name, layer.size());
    property(m.name);
  }
  const std::span<const uint16_t> objects = layer.object_ids();
  if (!objects.empty()) property("object_id");
  header += "end_header\n";

  std::string bytes = header;
  bytes.resize(header.size() + layer.size() * properties * sizeof(float));
  char* out = bytes.data() + header.size();
  const auto put = [&](float v) {
    std::memcpy(out, &v, sizeof v);
    out += sizeof v;
  };
  const auto put_all = [&](const float* v, size_t n) {
    for (size_t i = 0; i < n; ++i) put(v[i]);
  };
  std::vector<float> sh(3 * (rest + 1));
  for (size_t i = 0; i < layer.size(); ++i) {
    put_all(layer.at(Attribute::Mean, i), 3);
    const float* q = layer.at(Attribute::Rotation, i);
    Vec3f normal{};
    if (!desc.normals.empty())
      normal = desc.normals[i];
    else if (desc.disk_normals)
      normal = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})) * Vec3f{0, 0, 1};
    for (size_t c = 0; c < 3; ++c) put(normal[c]);
    std::memcpy(sh.data(), layer.at(Attribute::ShDc, i), 3 * sizeof(float));
    if (rest > 0) std::memcpy(sh.data() + 3, layer.at(Attribute::ShRest, i), 3 * rest * sizeof(float));
    if (desc.convert_color) desc.convert_color(sh);
    put_all(sh.data(), 3);
    for (size_t c = 0; c < 3; ++c)
      for (size_t k = 1; k <= padded; ++k) put(k <= rest ? sh[3 * k + c] : 0);
    put(*layer.at(Attribute::Opacity, i));
    put_all(layer.at(Attribute::LogScale, i), 2);
    if (desc.thickness > 0) put(std::log(desc.thickness));
    put_all(q, 4);
    for (const MoreProperty& m : desc.more) put(m.values[i]);
    if (!objects.empty()) put(float(objects[i]));
  }
  write_file(path, bytes);
}

void encode_sh_for_display(std::span<float> sh) {
  const size_t coefficients = sh.size() / 3;
  for (size_t c = 0; c < 3; ++c) {
    const float linear = 0.5f + kShDc * sh[c];
    double energy = 0;  // of the higher bands: integral of their squared sum over the sphere
    for (size_t k = 1; k < coefficients; ++k) energy += double(sh[3 * k + c]) * sh[3 * k + c];
    const float spread = float(std::sqrt(energy / (4 * std::numbers::pi)));
    const float slope = srgb_from_linear_slope(std::max(linear, spread));
    sh[c] = (srgb_from_linear(std::max(linear, 0.f)) - 0.5f) / kShDc;
    for (size_t k = 1; k < coefficients; ++k) sh[3 * k + c] *= slope;
  }
}

std::vector<Vec3f> outward_normals(const SplatLayer& layer, const TriMesh& mesh, float reach) {
  const KdTreef vertices(mesh.positions);
  std::vector<KdTreef::Near> near;
  std::vector<Vec3f> out(layer.size());
  for (size_t i = 0; i < layer.size(); ++i) {
    const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i);
    const Vec3f mean{m[0], m[1], m[2]}, normal = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
    vertices.nearest(mean, 1, reach, near);
    const Vec3f side = !near.empty() ? mesh.normals[near[0].index] : squared_length(mean) > 1 ? -mean : mean;
    out[i] = dot(normal, side) < 0 ? -normal : normal;
  }
  return out;
}

}  // namespace vitrine
