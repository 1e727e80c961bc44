// Where the pieces of a gallery stand. Each stands in a circle of its own on the table; circles do not touch, and together they
// are packed around the middle. What hangs has a wall behind the table, and the cameras then look from the other side.
#pragma once

#include <optional>

#include "sample_data/generate/scenes/gallery_pieces.h"

namespace vitrine::generate {

struct PlacedPiece {
  Piece piece;        // parts in the world, called <kind>_<number>/<part>
  Vec3f centre = {};  // of the circle; of the bounds where it hangs
  float radius = 0, height = 0;
};

struct GalleryPlan {
  std::vector<PlacedPiece> pieces;
  float extent = 0;             // radius around the origin that holds all circles
  float height = 0;             // of the tallest standing piece
  std::optional<float> wall_y;  // of the wall that something hangs on
};

// seed >= 1. The same pieces for the same seed; cheap: no lights, no pictures of the room.
GalleryPlan gallery_plan(uint64_t seed);

// These pieces, placed by the seed.
GalleryPlan placed_pieces(std::vector<Piece> pieces, uint64_t seed);
// The plan of filled_gallery: vessels and matt things (filled_gallery.cpp).
GalleryPlan filled_plan(uint64_t seed);

// Views of the plan: one to three rings (arcs in front of a wall), as near as the pieces leave the pictures' edges free.
void add_gallery_views(Scene& scene, const GalleryPlan& plan, uint64_t seed);

}  // namespace vitrine::generate
