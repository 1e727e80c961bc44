#include "stages/masks/boxes/outlines.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

constexpr int kIterations = 4;
constexpr size_t kFewestPixels = 40;
constexpr double kMargin = 0.12;  // of the silhouette's width: uncertain up to there, background beyond
constexpr double kLeast = 0.2;    // share of the silhouette that must be segmented

constexpr float kObjectCost = 1;  // cost of an object pixel; a background pixel costs its squared error
constexpr float kMostSquared = 4;
constexpr float kSmooth = 1;  // cost per pixel of outline between similar pixels
constexpr float kDiagonal = 0.7f;

// Flow network with two terminals and one node per pixel, with arcs in both directions.
class FlowNetwork {
 public:
  explicit FlowNetwork(size_t pixels) : pixels_(pixels) {}

  void join(size_t a, size_t b, float forth, float back) {
    arcs_.push_back({a, b, forth, arcs_.size() + 1});
    arcs_.push_back({b, a, back, arcs_.size() - 1});
  }
  // Costs of the two labels of a pixel.
  void terminals(size_t pixel, float as_thing, float as_background) {
    join(object(), pixel, as_background, 0);
    join(pixel, background(), as_thing, 0);
  }
  // [pixel] 1 on the source (object) side of the minimum cut.
  std::vector<uint8_t> cut() const {
    std::vector<size_t> order(arcs_.size()), place(arcs_.size());  // arcs sorted by start node
    std::iota(order.begin(), order.end(), size_t(0));
    std::ranges::stable_sort(order, {}, [&](size_t arc) { return arcs_[arc].from; });
    std::vector<std::pair<size_t, size_t>> ends;
    std::vector<float> capacity;
    for (size_t i = 0; i < order.size(); ++i) {
      const Arc& arc = arcs_[order[i]];
      place[order[i]] = i;
      ends.emplace_back(arc.from, arc.to);
      capacity.push_back(arc.capacity);
    }
    const size_t vertices = pixels_ + 2;
    const Graph graph(boost::edges_are_unsorted_multi_pass, ends.begin(), ends.end(), vertices);
    std::vector<Graph::edge_descriptor> reverse, predecessor(vertices);
    for (const size_t arc : order) reverse.push_back(boost::edge_from_index(place[arcs_[arc].reverse], graph));
    std::vector<float> residual(capacity.size());
    std::vector<long> distance(vertices);
    std::vector<boost::default_color_type> colour(vertices);
    const auto edge = boost::get(boost::edge_index, graph);
    const auto vertex = boost::get(boost::vertex_index, graph);
    const auto by = [](auto& values, const auto& index) { return boost::make_iterator_property_map(values.begin(), index); };
    boost::boykov_kolmogorov_max_flow(graph, by(capacity, edge), by(residual, edge), by(reverse, edge), by(predecessor, vertex),
                                      by(colour, vertex), by(distance, vertex), vertex, object(), background());
    std::vector<uint8_t> inside(pixels_);
    for (size_t i = 0; i < inside.size(); ++i) inside[i] = colour[i] == boost::black_color;  // source tree
    return inside;
  }

 private:
  using Graph = boost::compressed_sparse_row_graph<boost::directedS>;
  struct Arc {
    size_t from, to;
    float capacity;
    size_t reverse;  // reverse arc
  };
  size_t object() const { return pixels_; }
  size_t background() const { return pixels_ + 1; }
  size_t pixels_;
  std::vector<Arc> arcs_;
};

// Segmentation of an object against a predicted background: minimum cut over the pixels of the hull's silhouette. Data cost:
// prediction error; smoothness cost: lower along image edges (Boykov, Jolly, "Interactive Graph Cuts for Optimal Boundary and
// Region Segmentation", 2001; minimum cut of Boost.Graph).
//
// Returns [h,w] 1 = object. `error`: unexplained() of core/observe/stereo/background.h; pixels without an error follow their
// neighbours. `about`: the silhouette; no pixel outside it is labelled as object.
std::vector<uint8_t> outline_cut(const EdgePhoto& photo, std::span<const float> error, std::span<const uint8_t> about) {
  const int width = photo.srgb.width(), height = photo.srgb.height();
  constexpr size_t kNone = size_t(-1);
  std::vector<size_t> node(about.size(), kNone);
  size_t count = 0;
  for (size_t i = 0; i < about.size(); ++i)
    if (about[i]) node[i] = count++;
  std::vector<uint8_t> inside(about.size(), 0);
  if (count == 0) return inside;

  const float* const srgb = photo.srgb.data().data();
  const auto apart = [&](size_t i, size_t j) {
    float sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += (srgb[3 * i + c] - srgb[3 * j + c]) * (srgb[3 * i + c] - srgb[3 * j + c]);
    return sum;
  };
  const auto each_pair = [&](const auto& visit) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t i = size_t(y) * size_t(width) + size_t(x);
        if (node[i] == kNone) continue;
        for (const auto& [dx, dy, weight] : {std::tuple{1, 0, 1.f}, {0, 1, 1.f}, {1, 1, kDiagonal}, {-1, 1, kDiagonal}}) {
          if (x + dx < 0 || x + dx >= width || y + dy >= height) continue;
          const size_t j = size_t(y + dy) * size_t(width) + size_t(x + dx);
          if (node[j] != kNone) visit(i, j, weight);
        }
      }
  };
  double sum = 0, pairs = 0;
  each_pair([&](size_t i, size_t j, float) { sum += double(apart(i, j)), ++pairs; });
  const auto typical = float(std::max(1e-5, pairs > 0 ? sum / pairs : 0));
  FlowNetwork network(count);
  for (size_t i = 0; i < about.size(); ++i)
    if (node[i] != kNone)
      network.terminals(node[i], kObjectCost, error[i] < 0 ? kObjectCost : std::min(error[i] * error[i], kMostSquared));
  each_pair([&](size_t i, size_t j, float weight) {
    const float cost = kSmooth * weight * std::exp(-apart(i, j) / (2 * typical));
    network.join(node[i], node[j], cost, cost);
  });
  const std::vector<uint8_t> cut = network.cut();
  for (size_t i = 0; i < about.size(); ++i) inside[i] = node[i] != kNone && cut[node[i]];
  return inside;
}

}  // namespace

std::vector<uint8_t> grab_cut(const SmallPhoto& photo, const std::vector<uint8_t>& about, bool tight) {
  const Intrinsics& k = photo.view.intrinsics;
  const size_t pixels = about.size(), inside = size_t(std::count(about.begin(), about.end(), 1));
  if (inside < kFewestPixels) return {};
  cv::Mat bgr(k.height, k.width, CV_8UC3), hull(k.height, k.width, CV_8UC1), wide, core;
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c)
      bgr.data[3 * i + c] = uint8_t(std::lround(255 * std::clamp(photo.srgb[(2 - c) * pixels + i], 0.f, 1.f)));
    hull.data[i] = about[i];
  }
  const int reach = std::max(2, int(std::lround(kMargin * std::sqrt(double(inside)))));
  cv::dilate(hull, wide, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  if (tight) cv::erode(hull, core, cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  cv::Mat labels(k.height, k.width, CV_8UC1);
  for (size_t i = 0; i < pixels; ++i)
    labels.data[i] = uint8_t(tight && core.data[i] ? cv::GC_FGD
                             : about[i]            ? cv::GC_PR_FGD
                             : wide.data[i]        ? cv::GC_PR_BGD
                                                   : cv::GC_BGD);
  if (size_t(cv::countNonZero(wide)) + kFewestPixels > pixels) return {};  // no certain background
  cv::setRNGSeed(1);  // for its k-means initialisation; the generator is local to this thread
  cv::Mat background, foreground;
  cv::grabCut(bgr, labels, {}, background, foreground, kIterations, cv::GC_INIT_WITH_MASK);
  std::vector<uint8_t> found(pixels);
  size_t kept = 0;
  for (size_t i = 0; i < pixels; ++i) {
    found[i] = labels.data[i] == cv::GC_PR_FGD || labels.data[i] == cv::GC_FGD;
    kept += found[i] && about[i];
  }
  if (double(kept) < kLeast * double(inside)) return {};
  return found;
}

std::vector<HalfSpace> PastOutlines::sides(const VisualHull& hull) const {
  return sides_of_cameras(stereo_.surroundings().planes, stereo_.views(), hull.bounds());
}

std::vector<std::vector<uint8_t>> PastOutlines::hidden(const VisualHull& around) const {
  const Surroundings scene = stereo_.surroundings();
  const std::span<const View> views = stereo_.views();
  std::vector<std::vector<uint8_t>> hidden(views.size());
  parallel_for(views.size(), 1, [&](size_t v) { hidden[v] = hidden_pixels(scene.maps[v], hull_depths(around, views[v])); });
  return hidden;
}

std::vector<Silhouette> PastOutlines::outlines(const VisualHull& hull, std::span<const std::vector<uint8_t>> hidden) const {
  const Surroundings scene = stereo_.surroundings();
  const std::span<const View> views = stereo_.views();
  const std::vector<std::vector<uint8_t>> about = silhouettes_of(hull, views);
  std::vector<HullDepths> passed(views.size());
  parallel_for(views.size(), 1, [&](size_t v) { passed[v] = hull_depths(hull, views[v]); });
  std::vector<Silhouette> found(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    found[v] = silhouette(views[v], outline_cut(scene.photos[v], unexplained(scene, hull, passed, v), about[v]));
    for (size_t i = 0; i < hidden[v].size(); ++i)
      if (hidden[v][i]) found[v].value.data()[i] = -1;
  });
  throw_if_interrupted();
  return found;
}

}  // namespace vitrine
