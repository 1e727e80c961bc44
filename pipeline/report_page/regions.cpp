#include "pipeline/report_page/regions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/math/median.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/ldr.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine {

namespace {

constexpr size_t kMostPhotos = 12;
constexpr int kSamplesAcross = 160;  // sampling grid across a photo, for shares and confidence
constexpr double kFewViews = 3;      // points with fewer views are constrained by a single pair of photos

enum Region : size_t { kTransparent, kReflective, kRest, kRegions };
constexpr std::array<const char*, kRegions> kIds = {"transparent", "reflective", "rest"};

std::optional<Image8> grey(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) return std::nullopt;
  try {
    return read_grey8(path);
  } catch (const Error&) {
    return std::nullopt;
  }
}

// A damaged object table or label file counts as empty.
LabelledObjects objects_of(const fs::path& project) {
  try {
    return LabelledObjects::all(project);
  } catch (const Error&) {
    return {};
  }
}

// Value at relative coordinates in [0,1).
template <class T>
T look_up(const Image<T>& image, double u, double v) {
  return image.at(std::min(int(u * image.width()), image.width() - 1), std::min(int(v * image.height()), image.height() - 1));
}

struct SampledPixels {
  std::optional<Image8> confidence;
  const ObjectSet& objects;
  Image16 labels;
  Region at(double u, double v) const {
    const Object* object = labels.empty() ? nullptr : objects.find(look_up(labels, u, v));
    return object == nullptr || !is_specular(object->role) ? kRest : is_glass(object->role) ? kTransparent : kReflective;
  }
};

struct Tally {
  double samples = 0, confidence = 0, confidence_samples = 0, points = 0;
  std::vector<double> views_per_point;
};

void tally_photo(const ViewSet& set, size_t index, const SampledPixels& pixels, std::array<Tally, kRegions>& tallies) {
  const View& view = set.views[index];
  const int rows = std::max(1, kSamplesAcross * view.intrinsics.height / std::max(1, view.intrinsics.width));
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < kSamplesAcross; ++x) {
      const double u = (x + 0.5) / kSamplesAcross, v = (y + 0.5) / rows;
      Tally& t = tallies[pixels.at(u, v)];
      t.samples += 1;
      if (!pixels.confidence) continue;
      t.confidence += look_up(*pixels.confidence, u, v) / 255.0;
      t.confidence_samples += 1;
    }
  for (const ScenePoint& p : set.points) {
    if (std::find(p.views.begin(), p.views.end(), uint32_t(index)) == p.views.end()) continue;
    const auto q = image_point(p.position, view);
    if (!q) continue;
    Tally& t = tallies[pixels.at(q->x / view.intrinsics.width, q->y / view.intrinsics.height)];
    t.points += 1;
    t.views_per_point.push_back(double(p.views.size()));
  }
}

// `n` receives the number of views.
std::optional<double> mean_psnr(const std::vector<PhotoScore>& views, const char* region, bool heldout, double& n) {
  double sum = 0;
  n = 0;
  for (const PhotoScore& v : views)
    if (const auto found = v.regions.find(region); v.heldout == heldout && found != v.regions.end()) sum += found->second, n += 1;
  return n > 0 ? std::optional(sum / n) : std::nullopt;
}

// Rates by held-out PSNR; at most medium if the training views are much better, or if few photos support the region.
void rate_region(RegionTrust& r, const ReportFigure& by_psnr) {
  if (!r.psnr) return;
  int step = int(rate(by_psnr, *r.psnr));
  std::vector<std::string> why = {step == 0   ? "drawn well from new places"
                                  : step == 1 ? "somewhat soft from new places"
                                              : "poor from new places"};
  if (const ReportFigure* gap = declared_figure("gap"); gap && r.train_psnr && *r.train_psnr - *r.psnr > gap->fair)
    step = std::max(step, 1), why.push_back("much better where it was trained");
  if (r.views_per_point && *r.views_per_point < kFewViews)
    step = std::max(step, 1), why.push_back("its points are seen by two photos");
  else if (r.views_per_point)
    why.push_back(fmt::format("half of its points are seen by {:.0f} photos or more", *r.views_per_point));
  else
    why.push_back("no sparse point lies on it");
  if (r.heldout_views < 2) step = std::max(step, 1), why.push_back("measured on a single held-out view");
  r.trust = Rating(step);
  for (const std::string& w : why) r.why += (r.why.empty() ? "" : "; ") + w;
}

}  // namespace

std::vector<RegionTrust> region_trust(const fs::path& project, const ViewSet& views, const Figures& figures) {
  std::array<Tally, kRegions> tallies;
  const size_t n = views.views.size(), count = std::min(n, kMostPhotos);
  const LabelledObjects objects = objects_of(project);
  bool masked = false;
  for (size_t i = 0; i < count; ++i) {
    const size_t index = i * n / count;
    const std::string stem = views.views[index].stem();
    if (!stays_below(stem)) continue;
    const SampledPixels pixels{.confidence = grey(project / "normals" / (stem + "_confidence.png")),
                               .objects = objects.objects(),
                               .labels = objects.labels(views.views[index], views.views[index].intrinsics)};
    masked |= !pixels.labels.empty();
    tally_photo(views, index, pixels, tallies);
  }
  double all = 0;
  for (const Tally& t : tallies) all += t.samples;
  std::vector<RegionTrust> regions;
  for (size_t r = 0; r < kRegions; ++r) {
    Tally& t = tallies[r];
    const ReportFigure* by_psnr = declared_figure(fmt::format("region_{}", kIds[r]));
    if (t.samples == 0 || by_psnr == nullptr) continue;
    RegionTrust& out = regions.emplace_back();
    out.id = kIds[r];
    out.title = masked ? by_psnr->label : "The whole picture";
    out.share = t.samples / all;
    out.points = t.points / double(count) / (10 * out.share);
    if (!t.views_per_point.empty()) out.views_per_point = upper_median(std::move(t.views_per_point));
    if (t.confidence_samples > 0) out.normals_confidence = t.confidence / t.confidence_samples;
    double train_views = 0;
    out.psnr = mean_psnr(figures.views, kIds[r], true, out.heldout_views);
    out.train_psnr = mean_psnr(figures.views, kIds[r], false, train_views);
    if (!masked && !out.psnr) {
      const Figure *psnr = figures.find("psnr"), *gap = figures.find("gap");
      if (psnr != nullptr) out.psnr = psnr->value, out.heldout_views = psnr->rating == Rating::Unknown ? 1 : 2;
      if (psnr != nullptr && gap != nullptr) out.train_psnr = psnr->value + gap->value;
    }
    rate_region(out, *by_psnr);
  }
  return regions;
}

}  // namespace vitrine
