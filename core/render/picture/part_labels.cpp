#include "core/render/picture/part_labels.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/camera/projection.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/raster/renderer.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

namespace {

constexpr double kLeastSeen = 0.5;   // pixels, summed over the photos: below it, the part counts as occluded
constexpr double kUndecided = 0.25;  // labelled share of a surfel's pixels: this close to one half, its position decides
constexpr double kHullShare = 0.8;   // of the photos whose frustum contains a position
constexpr size_t kHullViews = 3;     // minimum number of such photos
constexpr float kOffSurface = 0.5f;  // mean edges: offset of rays to the cameras from the mesh
constexpr size_t kLabelGrain = 256;
constexpr size_t kAtOnce = 3;  // number of labels rendered at once, one per colour channel

Vec3d mean_place(const SplatLayer& layer, size_t i) {
  const float* m = layer.at(Attribute::Mean, i);
  return {double(m[0]), double(m[1]), double(m[2])};
}

uint16_t label_near(const Image16& labels, int x, int y) {
  if (const uint16_t own = labels.at(x, y); own != 0) return own;
  for (int v = std::max(0, y - 1); v <= std::min(y + 1, labels.height() - 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(x + 1, labels.width() - 1); ++u)
      if (const uint16_t label = labels.at(u, v); label != 0) return label;
  return 0;
}

Image16 widened(const Image16& labels) {
  Image16 out(labels.width(), labels.height(), 1);
  for (int y = 0; y < labels.height(); ++y)
    for (int x = 0; x < labels.width(); ++x) out.at(x, y) = label_near(labels, x, y);
  return out;
}

// Labels in use, ascending, without 0.
std::vector<uint16_t> labels_in(const Image16& image) {
  std::vector<uint8_t> used(65536, 0);
  for (const uint16_t l : image.data()) used[l] = 1;
  std::vector<uint16_t> out;
  for (size_t l = 1; l < used.size(); ++l)
    if (used[l]) out.push_back(uint16_t(l));
  return out;
}
std::vector<uint16_t> labels_in(std::span<const LabelledView> views) {
  std::vector<uint16_t> out;
  for (const LabelledView& v : views)
    for (const uint16_t l : labels_in(v.labels)) out.push_back(l);
  std::ranges::sort(out);
  const auto rest = std::ranges::unique(out);
  out.erase(rest.begin(), rest.end());
  return out;
}

// Vote counts of a few labels.
class Votes {
 public:
  explicit Votes(std::span<const uint16_t> labels) : labels_(labels), counts_(labels.size()) {}
  void add(uint16_t label, double count) {
    all_ += count;
    if (label != 0) counts_[size_t(std::ranges::lower_bound(labels_, label) - labels_.begin())] += count;
  }
  double all() const { return all_; }
  double labelled() const { return std::accumulate(counts_.begin(), counts_.end(), 0.0) / std::max(all_, 1e-9); }  // share
  // The label with the most votes; 0 unless labels have more than half of all votes.
  uint16_t winner() const {
    return labelled() > 0.5 ? labels_[size_t(std::ranges::max_element(counts_) - counts_.begin())] : uint16_t(0);
  }
  // The label with the most votes; 0 unless its share is at least `share`.
  uint16_t agreed(double share) const {
    const auto most = std::ranges::max_element(counts_);
    return most != counts_.end() && *most >= share * all_ ? labels_[size_t(most - counts_.begin())] : uint16_t(0);
  }

 private:
  std::span<const uint16_t> labels_;
  std::vector<double> counts_;
  double all_ = 0;
};

uint16_t label_of_place(const Vec3d& p, std::span<const uint16_t> labels, std::span<const LabelledView> views) {
  Votes votes(labels);
  for (const LabelledView& v : views)
    if (const auto px = image_point(p, v.view)) votes.add(label_near(v.labels, int(px->x), int(px->y)), 1);
  return votes.all() >= double(kHullViews) ? votes.agreed(kHullShare) : uint16_t(0);
}

SplatLayer grey_surfels(const SplatLayer& layer) {
  SplatLayer out(layer.kind(), 0, layer.size());
  for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity})
    std::ranges::copy(layer.values(a), out.values(a).begin());
  return out;
}

// Blending weights per label: the gradient of the blended colour by the colours of the surfels.
class SurfelWeights {
 public:
  SurfelWeights(const SplatLayer& layer, float near_z, std::span<const uint16_t> labels)
      : grey_(grey_surfels(layer)),
        grad_(grey_.zeros_like()),
        near_z_(near_z),
        labels_(labels),
        all_(layer.size(), 0),
        of_label_(layer.size() * labels.size(), 0) {}

  void add(const LabelledView& v) {
    const RasterDesc desc{.intrinsics = v.view.intrinsics,
                          .cam_from_world = v.view.cam_from_world,
                          .features = FeatureSet::ColorOnly,
                          .sh_degree = 0,
                          .near_z = near_z_};
    renderer_->forward(grey_, desc, images_);
    const Image16 labels = widened(v.labels);
    const std::vector<uint16_t> here = labels_in(labels);
    for (size_t first = 0; first == 0 || first < here.size(); first += kAtOnce) {
      const auto some = std::span(here).subspan(first, std::min(kAtOnce, here.size() - first));
      add(labels, some, desc, first == 0);
    }
  }

  Votes of(size_t i) const {
    Votes votes(labels_);
    double labelled = 0;
    for (size_t l = 0; l < labels_.size(); ++l) {
      const double weight = of_label_[i * labels_.size() + l];
      votes.add(labels_[l], weight), labelled += weight;
    }
    votes.add(0, std::max(0.0, all_[i] - labelled));
    return votes;
  }

 private:
  void add(const Image16& labels, std::span<const uint16_t> some, const RasterDesc& desc, bool first) {
    gradients_.reset(desc);
    const size_t pixels = labels.pixel_count();
    for (size_t c = 0; c < some.size(); ++c)
      for (size_t p = 0; p < pixels; ++p) gradients_.plane(Aov::Color)[c * pixels + p] = labels.data()[p] == some[c] ? 1.f : 0.f;
    grad_.fill(0);
    SurfelStatistics statistics;
    renderer_->backward({.gradients = &gradients_}, grad_, &statistics);
    for (size_t c = 0; c < some.size(); ++c) {
      const auto l = size_t(std::ranges::lower_bound(labels_, some[c]) - labels_.begin());
      for (size_t i = 0; i < all_.size(); ++i)
        of_label_[i * labels_.size() + l] += double(grad_.at(Attribute::ShDc, i)[c]) / double(kShDc);
    }
    for (size_t i = 0; first && i < all_.size(); ++i) all_[i] += double(statistics.weight[i]);
  }

  SplatLayer grey_, grad_;  // grey: no channel is clamped
  float near_z_;
  std::span<const uint16_t> labels_;
  std::unique_ptr<Renderer> renderer_ = make_renderer(Backend::Cpu);
  RasterImages images_, gradients_;
  std::vector<double> all_, of_label_;  // [surfels], [surfels][labels]
};

float mean_edge(const TriMesh& mesh) {
  double sum = 0;
  for (const auto& f : mesh.faces)
    for (size_t k = 0; k < 3; ++k) sum += double(length(mesh.positions[f[(k + 1) % 3]] - mesh.positions[f[k]]));
  return float(sum / (3.0 * double(std::max<size_t>(1, mesh.faces.size()))));
}

}  // namespace

std::vector<LabelledView> labelled_views(const LabelledObjects& objects, std::span<const View> photos) {
  std::vector<LabelledView> out;
  for (View view : photos) {
    throw_if_interrupted();
    view.intrinsics = view.intrinsics.limited_to(kLabelSide);
    if (Image16 labels = objects.labels(view, view.intrinsics); !labels.empty()) out.push_back({view, std::move(labels)});
  }
  return out;
}

SurfelLabels labels_of_surfels(const SplatLayer& layer, float near_z, std::span<const LabelledView> views) {
  const std::vector<uint16_t> labels = labels_in(views);
  SurfelWeights weights(layer, near_z, labels);
  for (const LabelledView& v : views) {
    throw_if_interrupted();
    weights.add(v);
  }
  SurfelLabels out{std::vector<uint16_t>(layer.size()), std::vector<uint8_t>(layer.size())};
  parallel_for(layer.size(), kLabelGrain, [&](size_t i) {
    const Votes votes = weights.of(i);
    out.seen[i] = votes.all() > kLeastSeen;
    const bool decided = out.seen[i] && std::abs(votes.labelled() - 0.5) > kUndecided;
    out.label[i] = decided ? votes.winner() : label_of_place(mean_place(layer, i), labels, views);
  });
  return out;
}

std::vector<uint16_t> labels_of_vertices(const TriMesh& mesh, std::span<const LabelledView> views) {
  const std::vector<uint16_t> labels = labels_in(views);
  const MeshHits hits(mesh);
  const float off = kOffSurface * mean_edge(mesh);
  std::vector<uint16_t> out(mesh.positions.size());
  parallel_for(out.size(), kLabelGrain, [&](size_t i) {
    const Vec3f p = mesh.positions[i];
    Votes votes(labels);
    for (const LabelledView& v : views) {
      const auto px = image_point(cast<double>(p), v.view);
      if (!px) continue;
      const Vec3f to_camera = cast<float>(v.view.centre_in_world()) - p;
      const float distance = length(to_camera);
      if (!hits.occluded(p, to_camera / distance, off, distance)) votes.add(label_near(v.labels, int(px->x), int(px->y)), 1);
    }
    out[i] = votes.all() > 0 ? votes.winner() : label_of_place(cast<double>(p), labels, views);
  });
  return out;
}

std::vector<uint16_t> labels_of_places(size_t count, const std::function<Vec3d(size_t)>& place,
                                       std::span<const LabelledView> views) {
  const std::vector<uint16_t> labels = labels_in(views);
  std::vector<uint16_t> out(count);
  parallel_for(count, kLabelGrain, [&](size_t i) { out[i] = label_of_place(place(i), labels, views); });
  return out;
}

bool shows_thin_glass(const ObjectSet& objects, uint16_t label) {
  const Object* object = objects.find(label);
  return object != nullptr && object->role == ObjectRole::ThinGlass;
}

void leave_out_thin_glass(const ObjectSet& objects, std::span<uint16_t> labels) {
  for (uint16_t& label : labels)
    if (shows_thin_glass(objects, label)) label = 0;
}

void assign_objects(const ObjectSet& objects, std::span<const LabelledView> views, float near_z, SplatLayer& diffuse,
                    SplatLayer& transmittance) {
  if (views.empty()) return;
  std::vector<uint16_t> shown = labels_of_surfels(diffuse, near_z, views).label;
  for (size_t i = 0; i < shown.size() && transmittance.size() > 0; ++i)
    if (!is_glass(diffuse, i) && shows_thin_glass(objects, shown[i])) shown[i] = 0;
  diffuse.set_object_ids(std::move(shown));
  std::vector<uint16_t> behind = labels_of_places(
      transmittance.size(), [&](size_t i) { return mean_place(transmittance, i); }, views);
  leave_out_thin_glass(objects, behind);
  transmittance.set_object_ids(std::move(behind));
}

Image16 rendered_objects(const SplatLayer& diffuse, float near_z, const View& view) {
  const std::span<const uint16_t> ids = diffuse.object_ids();
  std::vector<uint16_t> labels(ids.begin(), ids.end());
  std::ranges::sort(labels);
  const auto rest = std::ranges::unique(labels);
  labels.erase(rest.begin(), rest.end());
  std::erase(labels, uint16_t(0));
  const size_t pixels = view.intrinsics.pixel_count();
  Image16 out(view.intrinsics.width, view.intrinsics.height, 1);
  std::vector<float> most(pixels, 0.f), left(pixels, 1.f);
  SplatLayer flat = grey_surfels(diffuse);
  const auto renderer = make_renderer(Backend::Cpu);
  RasterImages images;
  for (size_t first = 0; first < labels.size(); first += kAtOnce) {
    const auto some = std::span(labels).subspan(first, std::min(kAtOnce, labels.size() - first));
    for (size_t i = 0; i < flat.size(); ++i)
      for (size_t c = 0; c < kAtOnce; ++c)
        flat.at(Attribute::ShDc, i)[c] = ((c < some.size() && ids[i] == some[c] ? 1.f : 0.f) - 0.5f) / kShDc;
    renderer->forward(flat,
                      {.intrinsics = view.intrinsics,
                       .cam_from_world = view.cam_from_world,
                       .features = FeatureSet::ColorOnly,
                       .sh_degree = 0,
                       .near_z = near_z},
                      images);
    const std::span<const float> weight = images.plane(Aov::Color);
    for (size_t c = 0; c < some.size(); ++c)
      for (size_t p = 0; p < pixels; ++p) {
        const float w = weight[c * pixels + p];
        left[p] -= w;
        if (w > most[p]) most[p] = w, out.data()[p] = some[c];
      }
  }
  for (size_t p = 0; p < pixels; ++p)
    if (left[p] > most[p]) out.data()[p] = 0;
  return out;
}

}  // namespace vitrine
