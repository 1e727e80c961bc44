// The things that a scene of the gallery may hold. A piece is built in its own frame: it stands on z = 0 around the z axis
// (metres); what hangs on a wall has the wall behind it at y = 0, looks along -y, and z = 0 is the height of the table top.
#pragma once

#include <span>

#include "sample_data/generate/revolve.h"
#include "sample_data/generate/scene.h"
#include "sample_data/generate/scenes/gallery_draw.h"

namespace vitrine::generate {

enum class PieceGroup { Glass, Metal, Coat, Matt };

struct Piece {
  std::string name = {};  // of its kind; the parts are called <name>_<number in the scene>/<part>
  PieceGroup group = PieceGroup::Matt;
  bool hangs = false;            // on a wall
  int matt_things = 0;           // painted things in it, e.g. under a dome
  std::vector<Part> parts = {};  // own frame
};

struct PieceKind {
  const char* name;
  PieceGroup group;
  bool hangs;
  Piece (*build)(Draw& draw);
};
// Glass, metal and mirrors, coats: what the decks of gallery_deck.h deal.
std::span<const PieceKind> glossy_kinds();

Piece box_case(Draw& draw);
Piece dome(Draw& draw);
Piece bottle(Draw& draw);
Piece jar(Draw& draw);
Piece wine_glass(Draw& draw);
Piece glazed_picture(Draw& draw);
Piece glass_ball(Draw& draw);
Piece flat_paperweight(Draw& draw);

Piece polished_sphere(Draw& draw);
Piece spoon(Draw& draw);
Piece statue(Draw& draw);
Piece metal_vase(Draw& draw);
Piece metal_kettle(Draw& draw);
Piece wall_mirror(Draw& draw);

Piece glazed_pot(Draw& draw);
Piece toy_car(Draw& draw);
Piece lacquered_box(Draw& draw);

// A painted thing that stays in a cylinder of this radius and height.
Piece matt_thing(Draw& draw, float radius, float height);

// Shapes that several groups share.
struct Blobs {  // smoothly joined ellipsoids, cut flat at the foot
  DistanceFunction distance;
  Bounds3 bounds;
};
Blobs drawn_blobs(Draw& draw, float radius, float height);
std::vector<Vec2f> drawn_vase_knots(Draw& draw, float radius, float height);  // the outer wall, foot to rim
// The wall of an open vessel: from the middle of its foot up the outer wall, over the rim and down inside.
Shape vessel(std::span<const Vec2f> outer_knots, float thickness, int steps, int around);

// A quarter of an ellipse from (radius, low) up to the axis.
void close_above(Profile& profile, float radius, float low, float rise, int steps);

void add_part(Piece& piece, const char* name, Shape shape, Material material);
// The parts of another piece, moved up by `lift`, as parts of this one.
void add_content(Piece& piece, Piece content, float lift);
void shift(Piece& piece, const Vec3f& by, float turn = 0, float scale = 1);  // scaled, then turned about z, then moved

}  // namespace vitrine::generate
