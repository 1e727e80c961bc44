#include "sample_data/generate/scenes/gallery_layout.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sample_data/generate/scenes/gallery_deck.h"

namespace vitrine::generate {
namespace {

constexpr uint64_t kPiecePurpose = 2, kPlacePurpose = 3;
constexpr float kLeastGap = 0.015f, kWallGap = 0.07f;  // metres

// The circle around the parts becomes centred on the axis; its radius and the height over the table.
void centre_piece(PlacedPiece& placed) {
  Bounds3 bounds;
  for (const Part& part : placed.piece.parts)
    for (const Vec3f& p : part.shape.mesh.positions) bounds.extend(cast<double>(p));
  const Vec3f middle = cast<float>(bounds.centre());
  placed.height = static_cast<float>(bounds.high.z);
  if (placed.piece.hangs) {
    placed.centre = middle;
    return;
  }
  shift(placed.piece, {-middle.x, -middle.y, 0});
  for (const Part& part : placed.piece.parts)
    for (const Vec3f& p : part.shape.mesh.positions) placed.radius = std::max(placed.radius, std::hypot(p.x, p.y));
}

void name_parts(Piece& piece, size_t number) {
  for (Part& part : piece.parts) part.name = fmt::format("{}_{}/{}", piece.name, number, part.name);
}

// A free place for a circle inside the disc, the nearest to the middle of some tries, or nothing.
std::optional<Vec3f> free_place(const std::vector<PlacedPiece>& standing, float radius, float extent, Draw& draw) {
  constexpr int kTries = 400;
  std::optional<Vec3f> best;
  float best_cost = 1e9f;
  for (int i = 0; i < kTries; ++i) {
    const float phi = draw.between(0, 2 * kPi), r = (extent - radius) * std::sqrt(draw.between(0, 1));
    const Vec3f at{r * std::cos(phi), r * std::sin(phi), 0};
    const float cost = r * draw.between(0.85f, 1.15f);
    const bool free = std::all_of(standing.begin(), standing.end(), [&](const PlacedPiece& other) {
      return other.piece.hangs || length(at - other.centre) > radius + other.radius + kLeastGap;
    });
    if (radius > extent || !free || cost >= best_cost) continue;
    best = at;
    best_cost = cost;
  }
  return best;
}

// Moves the middle of the circles to the origin; the extent shrinks to what they need.
void recentre(GalleryPlan& plan) {
  Vec3f middle{};
  const auto reach = [&](const Vec3f& from) {
    float far = 0;
    for (const PlacedPiece& placed : plan.pieces) far = std::max(far, length(placed.centre - from) + placed.radius);
    return far;
  };
  for (float step = 0.1f; step > 1e-3f; step *= 0.5f)
    for (bool better = true; better;) {
      better = false;
      for (const Vec3f& by : {Vec3f{step, 0, 0}, Vec3f{-step, 0, 0}, Vec3f{0, step, 0}, Vec3f{0, -step, 0}})
        if (reach(middle + by) < reach(middle)) {
          middle += by;
          better = true;
        }
    }
  plan.extent = reach(middle);
  for (PlacedPiece& placed : plan.pieces) {
    shift(placed.piece, -middle);
    placed.centre -= middle;
  }
}

std::vector<Piece> drawn_pieces(uint64_t seed) {
  std::vector<Piece> pieces;
  int matt = 0;
  uint64_t number = 0;
  for (const PieceKind* kind : seed_has_gloss(seed) ? dealt_kinds(seed) : std::vector<const PieceKind*>{}) {
    Draw draw(seed, mix64(kPiecePurpose, ++number));
    pieces.push_back(kind->build(draw));
    pieces.back().name = kind->name;
    pieces.back().group = kind->group;
    matt += pieces.back().matt_things;
  }
  Draw draw(seed, kPiecePurpose);
  const int wanted =
      seed_has_gloss(seed) ? std::max(matt + 1, draw.whole(2, 6 - static_cast<int>(pieces.size()))) : draw.whole(4, 5);
  for (; matt < std::min(wanted, 5); ++matt)
    pieces.push_back(matt_thing(draw, draw.between(0.06f, 0.10f), draw.between(0.13f, 0.30f)));
  return pieces;
}

}  // namespace

GalleryPlan gallery_plan(uint64_t seed) { return placed_pieces(drawn_pieces(seed), seed); }

GalleryPlan placed_pieces(std::vector<Piece> pieces, uint64_t seed) {
  GalleryPlan plan;
  Draw draw(seed, kPlacePurpose);
  std::vector<PlacedPiece> waiting;
  for (Piece& piece : pieces) {
    PlacedPiece placed{.piece = std::move(piece)};
    name_parts(placed.piece, waiting.size());
    centre_piece(placed);
    waiting.push_back(std::move(placed));
  }
  std::stable_sort(waiting.begin(), waiting.end(), [](const auto& a, const auto& b) { return a.radius > b.radius; });
  for (const PlacedPiece& placed : waiting) plan.extent = std::max(plan.extent, placed.radius);
  for (PlacedPiece& placed : waiting) {
    if (placed.piece.hangs) continue;
    std::optional<Vec3f> at;
    while (!(at = free_place(plan.pieces, placed.radius, plan.extent, draw))) plan.extent += 0.02f;
    shift(placed.piece, *at, draw.between(0, 2 * kPi));
    placed.centre = *at;
    plan.height = std::max(plan.height, placed.height);
    plan.pieces.push_back(std::move(placed));
  }
  recentre(plan);
  for (PlacedPiece& placed : waiting) {
    if (!placed.piece.hangs) continue;
    plan.wall_y = plan.extent + kWallGap;
    const Vec3f by{draw.between(-0.3f, 0.3f) * plan.extent, *plan.wall_y, 0};
    shift(placed.piece, by);
    placed.centre += by;
    plan.pieces.push_back(std::move(placed));
  }
  return plan;
}

}  // namespace vitrine::generate
