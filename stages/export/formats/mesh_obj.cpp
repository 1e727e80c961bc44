// mesh-obj: the mesh as Wavefront OBJ text with a material library and the baked textures beside it. Two groups, "opaque" and
// "glass". Colour is the texture alone (Kd 1 1 1, no vertex colours): readers multiply the two. OBJ counts v from below.
#include "core/base/file.h"
#include "core/image/ldr.h"
#include "stages/export/formats/format.h"

namespace vitrine {
namespace {

Image8 channel(const Image8& image, int c) {
  Image8 out(image.width(), image.height(), 1);
  for (size_t i = 0; i < out.pixel_count(); ++i) out.data()[i] = image.data()[i * size_t(image.channels()) + size_t(c)];
  return out;
}

// The extensions Pr, Pm and norm for physically based materials are those that Blender and assimp write and read.
std::string mtl_of(const std::string& name, bool glass) {
  std::string out = fmt::format("newmtl {}", name) + "\nKd 1 1 1\nKs 0.04 0.04 0.04\nNi 1.5\n";
  out += "map_Kd textures/obj/base_color.png\nPr 1\nmap_Pr textures/obj/roughness.png\nPm 1\nmap_Pm textures/obj/metallic.png\n";
  out += "norm textures/obj/normal.png\n";
  // Tf: light goes through unfiltered. Readers that do not know it see the dissolve: a pane that hides little.
  out += glass ? "Tf 1 1 1\nd 0.2\nillum 7\n" : "d 1\nillum 2\n";
  return out;
}

std::vector<std::string> write_mesh_obj(ExportSource& source, const std::filesystem::path& folder) {
  const PbrMesh& pbr = source.pbr_mesh();
  const TriMesh mesh = in_frame(source.mesh(), source.frame());
  const bool mirrored = source.frame().mirrored();
  std::string out = fmt::format("# {}\nmtllib mesh.mtl\n", color_note(source));
  for (const Vec3f& p : mesh.positions) out += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
  for (const Vec3f& n : mesh.normals) out += fmt::format("vn {:.4f} {:.4f} {:.4f}\n", n.x, n.y, n.z);
  for (const Vec2f& t : pbr.uv) out += fmt::format("vt {:.6f} {:.6f}\n", t.x, 1 - t.y);
  for (const bool glass : {false, true}) {
    const auto& faces = glass ? pbr.glass : pbr.opaque;
    if (faces.empty()) continue;
    out += glass ? "g glass\nusemtl glass\n" : "g opaque\nusemtl opaque\n";
    for (const auto& f : faces) {
      out += "f";
      for (size_t k : {size_t(0), size_t(mirrored ? 2 : 1), size_t(mirrored ? 1 : 2)}) {
        const uint32_t v = pbr.source_vertex[f[k]] + 1;
        out += fmt::format(" {}/{}/{}", v, f[k] + 1, v);
      }
      out += "\n";
    }
  }
  write_file(folder / "mesh.obj", out);
  write_file(folder / "mesh.mtl", mtl_of("opaque", false) + (pbr.glass.empty() ? std::string() : mtl_of("glass", true)));

  std::vector<std::string> files{"mesh.obj", "mesh.mtl"};
  const auto texture = [&](const char* name, const Image8& image) {
    files.push_back(fmt::format("textures/obj/{}.png", name));
    make_folders(folder / "textures/obj");
    write_ldr(folder / files.back(), image);
  };
  const PbrTextures& t = pbr.textures;
  texture("base_color", t.base_color);
  texture("roughness", channel(t.metallic_roughness, 1));
  texture("metallic", channel(t.metallic_roughness, 2));
  texture("normal", t.normal);
  if (!pbr.glass.empty()) texture("transmission", t.transmission);
  return files;
}

}  // namespace

ExportFormat mesh_obj_format() {
  return {.name = "mesh-obj",
          .summary = "the mesh as OBJ text with MTL and textures",
          .holds =
              "triangles, normals, texture coordinates; textures of base colour, roughness, metalness and normals; a group each "
              "for opaque faces and glass",
          .loses =
              "view dependence, colours above 1; MTL has no texture for transmission (the picture lies beside it, the material "
              "is one for all glass) nor for the colour of reflections; large and slow to read",
          .write = write_mesh_obj};
}

}  // namespace vitrine
