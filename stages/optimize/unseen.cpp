#include "stages/optimize/unseen.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/parallel.h"
#include "core/camera/image_point.h"
#include "core/model/diffuse_pass.h"
#include "core/model/thin_glass_pass.h"
#include "core/optim/adam.h"
#include "core/scene/activation.h"
#include "stages/optimize/initialise.h"
#include "stages/optimize/layer_init.h"

namespace vitrine {

namespace {

constexpr size_t kLevel = 1;          // of the photos' pyramids
constexpr float kSolid = 0.5f;        // alpha of a pixel that shows something
constexpr double kFinestCell = 0.03;  // of the cameras' radius, which is 1
constexpr double kCoarser = 1.4;      // cells grow by this until their surfels are few enough
constexpr double kReach = 0.48;       // farther from anything seen nothing is guessed
constexpr size_t kMostCells = 1u << 20;
constexpr double kOnPlane = 0.02;  // relative depth within which a photo sees the plane itself
constexpr double kThrough = 0.04;  // and beyond which it sees through it
constexpr int kSweeps = 300;
constexpr double kOverrelaxed = 1.8;
constexpr int kLargest = 16;      // cells along the side of a surfel that has no detail to show
constexpr double kBehind = 0.02;  // the plane, so that nothing seen is hidden
constexpr double kCover = 0.75;   // scale of a surfel, of a cell
constexpr float kOpacity = 0.95f;
constexpr float kShows = 0.25f;    // of a guessed surfel's pixels in a photo: most that may show through what was trained
constexpr float kFewPixels = 4.f;  // in a photo: its rim

// A training photo, and the z-depth [h,w] of what was trained, as it sees it; 0 = nothing there.
struct SeenPhoto {
  const PhotoLevel* photo;
  std::vector<float> zdepth;
};

std::vector<SeenPhoto> seen_photos(const SplatLayer& layer, const Capture& capture) {
  DiffusePass pass({.sh_degree = 0, .near_z = capture.near_z});
  const SplatScene diffuse{.diffuse = layer};
  Frame frame;
  std::vector<SeenPhoto> photos;
  for (uint32_t photo : capture.train) {
    const PhotoLevel& level = capture.photos[photo].levels[kLevel];
    frame.view = &level.view;
    pass.forward(diffuse, frame);
    const auto z = frame.diffuse.plane(Aov::ZDepth), alpha = frame.diffuse.plane(Aov::Alpha);
    photos.push_back({&level, std::vector<float>(frame.pixel_count())});
    for (size_t i = 0; i < z.size(); ++i) photos.back().zdepth[i] = alpha[i] > kSolid ? z[i] / alpha[i] : 0;
  }
  return photos;
}

enum class State : uint8_t { Unseen, Seen, Through };

struct Cell {
  State state = State::Unseen;
  bool reached = false;  // seen, or not far from it
  Vec3d linear{};
};

// The part of a plane that photos see, and its surroundings, in square cells.
class PlaneGrid {
 public:
  PlaneGrid(const ScenePlane& plane, double cell, std::span<const SeenPhoto> photos) : cell_(cell) {
    const double side = plane.offset >= 0 ? 1 : -1;  // the middle of the cameras is the origin
    normal_ = -side * plane.normal;
    origin_ = plane.offset * plane.normal;
    const Vec3d helper = std::abs(normal_.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0};
    u_ = normalized(cross(helper, normal_)), v_ = cross(normal_, u_);
    double low_u = 1e300, low_v = 1e300, high_u = -1e300, high_v = -1e300;
    for (const SeenPhoto& seen : photos)
      for_pixels_on_plane(seen, [&](const Vec3d& p) {
        const Vec3d q = p - origin_;
        low_u = std::min(low_u, dot(q, u_)), high_u = std::max(high_u, dot(q, u_));
        low_v = std::min(low_v, dot(q, v_)), high_v = std::max(high_v, dot(q, v_));
      });
    if (!(low_u < high_u) || !(low_v < high_v)) return;
    const double columns = std::ceil((high_u - low_u + 2 * kReach) / cell),
                 rows = std::ceil((high_v - low_v + 2 * kReach) / cell);
    if (columns * rows > double(kMostCells)) return;  // a plane that far out has no neighbourhood
    columns_ = int(columns), rows_ = int(rows);
    origin_ += (low_u - kReach) * u_ + (low_v - kReach) * v_;
    cells_.resize(size_t(columns_) * size_t(rows_));
    parallel_for(cells_.size(), 256,
                 [&](size_t c) { cells_[c] = looked_at(photos, place(int(c) % columns_ + 0.5, int(c) / columns_ + 0.5)); });
    close_gaps();
  }

  // Squares of cells to be guessed, as large as they come: visit(centre, side, linear colour).
  template <class Visit>
  void for_guessed(const Visit& visit) const {
    std::vector<uint8_t> open(cells_.size());
    for (size_t c = 0; c < cells_.size(); ++c) open[c] = cells_[c].state == State::Unseen && cells_[c].reached;
    for (int side = kLargest; side > 0; side /= 2)
      for (int y = 0; y + side <= rows_; y += side)
        for (int x = 0; x + side <= columns_; x += side) {
          const auto all = [&](const auto& body) {
            for (int v = y; v < y + side; ++v)
              for (int u = x; u < x + side; ++u)
                if (!body(size_t(v) * size_t(columns_) + size_t(u))) return false;
            return true;
          };
          if (!all([&](size_t c) { return open[c] != 0; })) continue;
          Vec3d linear{};
          all([&](size_t c) {
            linear += cells_[c].linear / double(side * side);
            open[c] = 0;
            return true;
          });
          visit(place(x + 0.5 * side, y + 0.5 * side), cell_ * side, linear);
        }
  }
  const Vec3d& normal() const { return normal_; }

 private:
  Vec3d place(double column, double row) const { return origin_ + column * cell_ * u_ + row * cell_ * v_; }

  template <class Visit>
  void for_pixels_on_plane(const SeenPhoto& seen, const Visit& visit) const {
    const Intrinsics& k = seen.photo->view.intrinsics;
    const Rigid world_from_cam = inverse(seen.photo->view.cam_from_world);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const double z = double(seen.zdepth[size_t(y) * size_t(k.width) + size_t(x)]);
        if (!(z > 0)) continue;
        const Vec3d p = world_from_cam * (z * k.ray(x + 0.5, y + 0.5));
        if (std::abs(dot(p - origin_, normal_)) < kOnPlane * z) visit(p);
      }
  }

  static Cell looked_at(std::span<const SeenPhoto> photos, const Vec3d& p) {
    Cell cell;
    double weights = 0;
    for (const SeenPhoto& seen : photos) {
      const View& view = seen.photo->view;
      const std::optional<ImagePoint> q = image_point(p, view);
      if (!q) continue;
      const size_t pixel = size_t(q->y) * size_t(view.intrinsics.width) + size_t(q->x);
      const double z = double(seen.zdepth[pixel]);
      if (z == 0 || q->z < (1 - kThrough) * z) {
        if (cell.state == State::Unseen) cell.state = State::Through;
      } else if (q->z < (1 + kOnPlane) * z) {
        const double weight = 1 / (q->z * q->z);
        cell.state = State::Seen;
        cell.linear += weight * cast<double>(linear_at(*seen.photo, pixel));
        weights += weight;
      }
    }
    if (weights > 0) cell.linear = cell.linear / weights;
    return cell;
  }

  template <class Visit>
  void for_neighbours(size_t cell, const Visit& visit) const {
    const int x = int(cell) % columns_, y = int(cell) / columns_;
    if (x > 0) visit(cell - 1);
    if (x + 1 < columns_) visit(cell + 1);
    if (y > 0) visit(cell - size_t(columns_));
    if (y + 1 < rows_) visit(cell + size_t(columns_));
  }

  // Colours of unseen cells: the nearest seen cell's first, then the solution of Laplace's equation.
  void close_gaps() {
    std::vector<size_t> front, gaps;
    for (size_t c = 0; c < cells_.size(); ++c)
      if ((cells_[c].reached = cells_[c].state == State::Seen)) front.push_back(c);
    for (int way = 0; way * cell_ < kReach; ++way) {
      std::vector<size_t> next;
      for (size_t from : front)
        for_neighbours(from, [&](size_t c) {
          if (cells_[c].reached || cells_[c].state != State::Unseen) return;
          cells_[c].reached = true;
          cells_[c].linear = cells_[from].linear;
          next.push_back(c);
        });
      gaps.insert(gaps.end(), next.begin(), next.end());
      front = std::move(next);
    }
    std::sort(gaps.begin(), gaps.end());
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (size_t c : gaps) {
        Vec3d sum{};
        double count = 0;
        for_neighbours(c, [&](size_t n) {
          if (cells_[n].reached) sum += cells_[n].linear, count += 1;
        });
        cells_[c].linear += kOverrelaxed * (sum / count - cells_[c].linear);
      }
  }

  double cell_;
  Vec3d normal_, origin_, u_, v_;  // the normal looks to the middle of the cameras
  int columns_ = 0, rows_ = 0;
  std::vector<Cell> cells_;
};

SplatLayer guessed_layer(std::span<const ScenePlane> planes, double cell, std::span<const SeenPhoto> photos) {
  SplatLayer layer(LayerKind::Diffuse, 0, 0);
  for (const ScenePlane& plane : planes) {
    const PlaneGrid grid(plane, cell, photos);
    const Quatf q = rotation_facing(cast<float>(grid.normal()));
    grid.for_guessed([&](const Vec3d& centre, double side, const Vec3d& linear) {
      const size_t i = layer.size();
      layer.resize(i + 1);
      float* rotation = layer.at(Attribute::Rotation, i);
      rotation[0] = q.w, rotation[1] = q.x, rotation[2] = q.y, rotation[3] = q.z;
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(kCover * side));
      const Vec3d position = centre - kBehind * grid.normal();
      for (size_t c = 0; c < 3; ++c) {
        layer.at(Attribute::Mean, i)[c] = float(position[c]);
        layer.at(Attribute::ShDc, i)[c] = float((std::clamp(linear[c], 0.0, 1e4) - 0.5) / double(kShDc));
      }
      *layer.at(Attribute::Opacity, i) = logit(kOpacity);
      for (Attribute a : {Attribute::F0, Attribute::Roughness})
        std::fill_n(layer.at(a, i), layer.width(a), raw_value(row(a).activation, row(a).initial));
      for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission})
        *layer.at(a, i) = raw_value(row(a).activation, kDull);
    });
  }
  return layer;
}

// Sums of blending weights of the surfels in one photo, pixels.
class PhotoWeights {
 public:
  PhotoWeights(const SplatLayer& layer, const Capture& capture)
      : scene_{.diffuse = layer}, ignored_{.diffuse = layer.zeros_like()}, pass_({.sh_degree = 0, .near_z = capture.near_z}) {}

  const std::vector<float>& in(const View& view) {
    frame_.view = &view;
    pass_.forward(scene_, frame_);
    frame_.grad_linear.assign(3 * frame_.pixel_count(), 0.f);
    pass_.backward(scene_, frame_, ignored_);
    return frame_.statistics.weight;
  }

 private:
  SplatScene scene_, ignored_;
  DiffusePass pass_;
  Frame frame_;
};

// A guess that a photo does see is wrong: that photo shows something else there, or nothing.
std::vector<uint32_t> hidden_from_all(const SplatLayer& diffuse, const SplatLayer& guessed, const Capture& capture) {
  PhotoWeights alone(guessed, capture), together(joined(diffuse, guessed), capture);
  std::vector<uint8_t> shown(guessed.size());
  for (uint32_t photo : capture.train) {
    const View& view = capture.photos[photo].levels[kLevel].view;
    const std::vector<float>&all = alone.in(view), &left = together.in(view);
    for (size_t i = 0; i < guessed.size(); ++i) shown[i] |= all[i] > kFewPixels && left[diffuse.size() + i] > kShows * all[i];
  }
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < guessed.size(); ++i)
    if (!shown[i]) kept.push_back(uint32_t(i));
  return kept;
}

}  // namespace

SplatLayer joined(const SplatLayer& first, const SplatLayer& second) {
  SplatLayer both = first;
  both.resize(first.size() + second.size());
  for (size_t i = 0; i < second.size(); ++i)
    for (const AttributeRow& r : kAttributes)
      std::copy_n(second.at(r.id, i), std::min(second.width(r.id), both.width(r.id)), both.at(r.id, first.size() + i));
  return both;
}

SplatLayer seen_through_glass(const SplatScene& scene) {
  SplatLayer opaque = scene.diffuse;
  keep_surfels(opaque, opaque_surfels(scene.diffuse));
  return joined(opaque, scene.transmittance);
}

SplatLayer unseen_surroundings(const SplatLayer& shown, const Capture& capture, std::span<const ScenePlane> planes, size_t most) {
  const std::vector<SeenPhoto> photos = seen_photos(shown, capture);
  for (double cell = kFinestCell; cell < kReach; cell *= kCoarser)
    if (SplatLayer layer = guessed_layer(planes, cell, photos); layer.size() <= most) {
      if (layer.size() > 0) keep_surfels(layer, hidden_from_all(shown, layer, capture));
      return layer;
    }
  return SplatLayer(LayerKind::Diffuse, 0, 0);
}

}  // namespace vitrine
