#include "core/intake/poses/pose_agreement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

// --- matches --------------------------------------------------------------------------------------------------------
constexpr double kTolerancePx = 4;   // accuracy of features and their geometric verification
constexpr double kInfinityPx = 2;    // smaller parallax does not determine the sign of a depth
constexpr size_t kMostOfPair = 200;  // tested matches per pair
// Matches at the same pixel in both photos are dirt on the lens, a watermark, or the room around a turntable, and do not
// constrain the poses. (A moving camera produces hardly any others.)
constexpr double kInPlace = 0.003;   // of the longest side
constexpr double kSamePlace = 1e-6;  // of the largest baseline: pure rotation

struct PosedCamera {
  const ColmapImage* image;
  const ColmapCamera* camera;
  Rigid cam_from_world;
  double focal;
};

std::map<std::string, PosedCamera> posed_cameras(const ColmapModel& model) {
  std::map<std::string, PosedCamera> out;
  for (const ColmapImage& image : model.images) {
    const ColmapCamera* camera = model.find_camera(image.camera_id);
    const Intrinsics k = pinhole_part(*camera);
    out[image.name] = {&image, camera, image.cam_from_world(), 0.5 * (k.fx + k.fy)};
  }
  return out;
}

double largest_baseline(const ColmapModel& model) {
  Bounds3 centres;
  for (const ColmapImage& image : model.images) centres.extend(inverse(image.cam_from_world()).translation);
  return centres.diagonal();
}

// Distance in pixels; nullopt when the two rays do not intersect in front of both cameras.
std::optional<double> epipolar_offset(const Rigid& b_from_a, const Vec2d& a, const Vec2d& b, double fa, double fb,
                                      bool same_place) {
  const Vec3d xa{a.x, a.y, 1}, xb{b.x, b.y, 1}, turned = b_from_a.rotation * xa;
  const double sine = length(cross(turned, xb)) / (length(turned) * length(xb)), cosine = dot(turned, xb);
  const double angle_px = std::min(fa, fb) * std::atan2(sine * length(turned) * length(xb), cosine);
  if (same_place) return cosine > 0 ? std::optional(angle_px) : std::nullopt;
  const Vec3d t = normalized(b_from_a.translation);
  const Vec3d line_b = cross(t, turned);                                   // E x_a
  const Vec3d line_a = transposed_times(b_from_a.rotation, cross(xb, t));  // E' x_b
  const double scale = std::sqrt((line_b.x * line_b.x + line_b.y * line_b.y) / (fb * fb) +
                                 (line_a.x * line_a.x + line_a.y * line_a.y) / (fa * fa));
  const double offset = scale > 0 ? std::abs(dot(xb, line_b)) / scale : angle_px;
  if (cosine > 0 && angle_px < kInfinityPx) return offset;
  // depth_a R x_a + t = depth_b x_b, least squares.
  const double aa = dot(turned, turned), ab = dot(turned, xb), bb = dot(xb, xb), at = dot(turned, t), bt = dot(xb, t);
  const double det = aa * bb - ab * ab;
  if (!(det > 0)) return std::nullopt;
  const double depth_a = (ab * bt - bb * at) / det, depth_b = (aa * bt - ab * at) / det;
  return depth_a > 0 && depth_b > 0 ? std::optional(offset) : std::nullopt;
}

// --- pictures -------------------------------------------------------------------------------------------------------
constexpr int kPictureSide = 400;                      // longest side of the reduced pictures
constexpr std::array<double, 3> kRadii = {1, 2.5, 5};  // radii of the compared discs, in reduced pixels
constexpr size_t kDescriptor = 3 * kRadii.size();
constexpr size_t kMostTracks = 4000;
constexpr int kRivals = 2;            // other observations compared with each pair
constexpr size_t kFewestSeen = 8;     // observations of a photo required for sampling rivals
constexpr double kAlike = 6.0 / 255;  // rivals with a smaller colour difference are indistinguishable

using Look = std::array<float, kDescriptor>;

// Mean colours of discs, invariant to camera roll.
std::optional<Look> look_at(const Image8& picture, double x, double y) {
  if (!(x >= 0 && y >= 0 && x < picture.width() && y < picture.height())) return std::nullopt;
  Look out{};
  for (size_t r = 0; r < kRadii.size(); ++r) {
    const int reach = int(std::ceil(kRadii[r]));
    double sum[3] = {}, weight = 0;
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const int px = int(x) + dx, py = int(y) + dy;
        if (px < 0 || py < 0 || px >= picture.width() || py >= picture.height()) continue;
        // Antialiased edge, for continuity under subpixel shifts.
        const double w = std::clamp(kRadii[r] + 0.5 - std::hypot(px + 0.5 - x, py + 0.5 - y), 0.0, 1.0);
        for (int c = 0; c < 3; ++c) sum[c] += w * picture.at(px, py, c);
        weight += w;
      }
    for (size_t c = 0; c < 3; ++c) out[3 * r + c] = float(weight > 0 ? sum[c] / weight / 255 : 0);
  }
  return out;
}

double difference(const Look& a, const Look& b) {
  double sum = 0;
  for (size_t i = 0; i < kDescriptor; ++i) sum += double(a[i] - b[i]) * double(a[i] - b[i]);
  return std::sqrt(sum / double(kDescriptor));
}

}  // namespace

double agreement_tolerance_px(const ColmapCamera& camera, double of_longest_side) {
  return std::max(kTolerancePx, of_longest_side * double(std::max(camera.width, camera.height)));
}

std::vector<PhotoMatches> thinned(std::span<const PhotoMatches> matches, size_t most) {
  size_t all = 0;
  for (const PhotoMatches& m : matches) all += m.in_a.size();
  const size_t step = std::max<size_t>(1, all / std::max<size_t>(1, most));
  std::vector<PhotoMatches> out;
  size_t at = 0;
  for (const PhotoMatches& m : matches) {
    PhotoMatches& kept = out.emplace_back(PhotoMatches{m.a, m.b, {}, {}});
    for (size_t k = 0; k < m.in_a.size(); ++k, ++at)
      if (at % step == 0) kept.in_a.push_back(m.in_a[k]), kept.in_b.push_back(m.in_b[k]);
    if (kept.in_a.empty()) out.pop_back();
  }
  return out;
}

std::vector<std::pair<std::string, AgreementCount>> disagreeing_photos(const Agreement& agreement, double least_share) {
  constexpr size_t kFewestTests = 20;
  std::map<std::string, AgreementCount> photos;
  for (const PairAgreement& pair : agreement.pairs)
    for (const std::string* name : {&pair.a, &pair.b}) {
      photos[*name].tests += pair.count.tests, photos[*name].agree += pair.count.agree;
      if (pair.a == pair.b) break;
    }
  const size_t most = photos.size() / 2;
  std::vector<std::pair<std::string, AgreementCount>> out;
  while (true) {
    auto worst = photos.end();
    for (auto p = photos.begin(); p != photos.end(); ++p)
      if (p->second.tests >= kFewestTests && (worst == photos.end() || p->second.share() < worst->second.share())) worst = p;
    if (worst == photos.end() || worst->second.share() >= least_share) break;
    const std::string name = worst->first;
    out.push_back(*worst);
    photos.erase(worst);
    for (const PairAgreement& pair : agreement.pairs) {
      if (pair.a != name && pair.b != name) continue;
      if (const auto other = photos.find(pair.a == name ? pair.b : pair.a); other != photos.end())
        other->second.tests -= pair.count.tests, other->second.agree -= pair.count.agree;
    }
  }
  return out.size() > most ? std::vector<std::pair<std::string, AgreementCount>>{} : out;
}

Agreement matches_agreement(const ColmapModel& poses, std::span<const PhotoMatches> matches, double of_longest_side) {
  const std::map<std::string, PosedCamera> cameras = posed_cameras(poses);
  const double baseline = largest_baseline(poses);
  struct Tested {
    AgreementCount count;
    std::vector<double> offsets;  // of rays that intersect in front of both cameras
  };
  std::vector<Tested> tested(matches.size());
  parallel_for(matches.size(), 1, [&](size_t i) {
    const PhotoMatches& m = matches[i];
    const auto a = cameras.find(m.a), b = cameras.find(m.b);
    if (a == cameras.end() || b == cameras.end()) return;
    const PosedCamera &ca = a->second, &cb = b->second;
    const Rigid b_from_a = cb.cam_from_world * inverse(ca.cam_from_world);
    const bool same_place = length(b_from_a.translation) <= kSamePlace * baseline;
    const double tolerance =
        std::max(agreement_tolerance_px(*ca.camera, of_longest_side), agreement_tolerance_px(*cb.camera, of_longest_side));
    const double side = double(std::max(ca.camera->width, ca.camera->height));
    const size_t n = m.in_a.size(), step = std::max<size_t>(1, n / kMostOfPair);
    for (size_t k = 0; k < n; k += step) {
      const Vec2d moved = m.in_b[k] - m.in_a[k];
      if (std::hypot(moved.x, moved.y) < kInPlace * side) continue;
      const std::optional<Vec2d> ra = unproject(*ca.camera, m.in_a[k]), rb = unproject(*cb.camera, m.in_b[k]);
      if (!ra || !rb) continue;
      ++tested[i].count.tests;
      const std::optional<double> offset = epipolar_offset(b_from_a, *ra, *rb, ca.focal, cb.focal, same_place);
      if (!offset) continue;
      tested[i].count.agree += *offset <= tolerance;
      tested[i].offsets.push_back(*offset);
    }
  });
  Agreement out;
  std::vector<double> offsets;
  for (size_t i = 0; i < matches.size(); ++i) {
    const AgreementCount& count = tested[i].count;
    if (count.tests == 0) continue;
    out.all.tests += count.tests, out.all.agree += count.agree;
    out.pairs.push_back({matches[i].a, matches[i].b, count});
    offsets.insert(offsets.end(), tested[i].offsets.begin(), tested[i].offsets.end());
  }
  if (!offsets.empty()) out.offset = upper_median(std::move(offsets));
  return out;
}

Agreement own_points_agreement(const ColmapModel& model) {
  std::map<uint32_t, PosedCamera> by_id;
  for (const auto& [name, camera] : posed_cameras(model)) by_id[camera.image->id] = camera;
  Agreement out;
  std::map<std::string, AgreementCount> photos;
  std::vector<double> offsets;
  for (const ColmapPoint3D& point : model.points)
    for (const ColmapTrackElement& t : point.track) {
      const PosedCamera& c = by_id.at(t.image_id);
      const ColmapPoint2D& seen = c.image->points[t.point2d_index];
      const Vec3d q = c.cam_from_world * point.position;
      bool agrees = false;
      if (q.z > 0) {
        const Vec2d p = project(*c.camera, {q.x / q.z, q.y / q.z});
        const double offset = std::hypot(p.x - seen.x, p.y - seen.y);
        agrees = offset <= agreement_tolerance_px(*c.camera);
        offsets.push_back(offset);
      }
      for (AgreementCount* n : {&out.all, &photos[c.image->name]}) ++n->tests, n->agree += agrees;
    }
  for (const auto& [name, count] : photos) out.pairs.push_back({name, name, count});
  if (!offsets.empty()) out.offset = upper_median(std::move(offsets));
  return out;
}

TrackPictures::TrackPictures(const ColmapModel& model, const std::function<Image8(const ColmapImage&)>& picture) {
  std::vector<Image8> reduced(model.images.size());
  parallel_for(model.images.size(), 1, [&](size_t i) {
    const Image8 full = picture(model.images[i]);
    const Intrinsics size = Intrinsics{full.width(), full.height(), 1, 1, 0, 0}.limited_to(kPictureSide);
    ImageF values(full.width(), full.height(), 3);
    std::copy(full.data().begin(), full.data().end(), values.data().begin());
    const ImageF small = resized(values, size.width, size.height);
    reduced[i] = Image8(size.width, size.height, 3);
    std::transform(small.data().begin(), small.data().end(), reduced[i].data().begin(),
                   [](float v) { return uint8_t(std::clamp(v + 0.5f, 0.0f, 255.0f)); });
  });
  for (size_t i = 0; i < reduced.size(); ++i) pictures_[model.images[i].name] = std::move(reduced[i]);
}

Agreement TrackPictures::agreement(const ColmapModel& model) const {
  const std::map<std::string, PosedCamera> cameras = posed_cameras(model);
  std::map<uint32_t, size_t> index_of;
  for (size_t i = 0; i < model.images.size(); ++i) index_of[model.images[i].id] = i;
  // Patch colours of every used observation, by photo.
  struct Seen {
    size_t track;
    Look look;
  };
  std::vector<std::vector<Seen>> seen(model.images.size());
  const size_t step = std::max<size_t>(1, model.points.size() / kMostTracks);
  std::vector<std::vector<std::pair<size_t, size_t>>> tracks;  // (photo, index in seen[photo])
  for (size_t p = 0; p < model.points.size(); p += step) {
    auto& track = tracks.emplace_back();
    for (const ColmapTrackElement& t : model.points[p].track) {
      const size_t i = index_of.at(t.image_id);
      const ColmapImage& image = model.images[i];
      const auto picture = pictures_.find(image.name);
      if (picture == pictures_.end()) continue;
      const ColmapCamera& camera = *cameras.at(image.name).camera;
      const double sx = double(picture->second.width()) / double(camera.width),
                   sy = double(picture->second.height()) / double(camera.height);
      const ColmapPoint2D& q = image.points[t.point2d_index];
      const std::optional<Look> look = look_at(picture->second, sx * q.x, sy * q.y);
      if (!look) continue;
      track.push_back({i, seen[i].size()});
      seen[i].push_back({tracks.size() - 1, *look});
    }
  }
  Agreement out;
  std::map<std::pair<size_t, size_t>, AgreementCount> pairs;
  std::vector<double> differences;
  for (size_t t = 0; t < tracks.size(); ++t)
    for (size_t k = 0; k + 1 < tracks[t].size(); ++k) {
      const auto [ia, a] = tracks[t][k];
      const auto [ib, b] = tracks[t][k + 1];
      if (ia == ib || seen[ib].size() < kFewestSeen) continue;
      const double own = difference(seen[ia][a].look, seen[ib][b].look);
      differences.push_back(own);
      Rng rng(t, k);
      for (int rival = 0; rival < kRivals; ++rival) {
        const size_t other = rng.below(uint32_t(seen[ib].size()));
        if (seen[ib][other].track == t || difference(seen[ib][b].look, seen[ib][other].look) < kAlike) continue;
        const bool agrees = own < difference(seen[ia][a].look, seen[ib][other].look);
        for (AgreementCount* c : {&out.all, &pairs[{ia, ib}]}) ++c->tests, c->agree += agrees;
      }
    }
  for (const auto& [pair, count] : pairs)
    out.pairs.push_back({model.images[pair.first].name, model.images[pair.second].name, count});
  if (!differences.empty()) out.offset = upper_median(std::move(differences));
  return out;
}

}  // namespace vitrine
