// Export format mesh-obj: the mesh as Wavefront OBJ text with a material library and the baked textures. One OBJ object per scene
// object; without objects, a group per face class: "opaque", "glass", "solid_glass". Colour is only in the texture (Kd 1 1 1, no
// vertex colours), because readers multiply both. OBJ texture v starts at the bottom.
#include "core/foundation/base/file.h"
#include "core/scene/image/ldr.h"
#include "stages/export/formats/source.h"

namespace vitrine {
namespace {

Image8 channel(const Image8& image, int c) {
  Image8 out(image.width(), image.height(), 1);
  for (size_t i = 0; i < out.pixel_count(); ++i) out.data()[i] = image.data()[i * size_t(image.channels()) + size_t(c)];
  return out;
}

// The PBR extensions Pr, Pm and norm are those of Blender and assimp.
std::string mtl_of(FaceClass kind, float ior) {
  std::string out = fmt::format("newmtl {}\nKd 1 1 1\nKs 0.04 0.04 0.04\nNi {}\n", name(kind), ior);
  out += "map_Kd textures/obj/base_color.png\nPr 1\nmap_Pr textures/obj/roughness.png\nPm 1\nmap_Pm textures/obj/metallic.png\n";
  out += "norm textures/obj/normal.png\n";
  // Tf: light passes unfiltered. Readers without it use the dissolve: a mostly transparent pane.
  out += kind != FaceClass::Opaque ? "Tf 1 1 1\nd 0.2\nillum 7\n" : "d 1\nillum 2\n";
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
  std::string materials;
  for (const FaceClass kind : kFaceClasses)
    if (pbr.has(kind)) materials += mtl_of(kind, kind == FaceClass::SolidGlass ? pbr.ior : 1.5f);
  for (size_t i = 0; i < pbr.parts.size(); ++i) {
    const auto& [object, kind, faces] = pbr.parts[i];
    // Readers accept either keyword for a name.
    if (!pbr.has_objects())
      out += fmt::format("g {}\n", name(kind));
    else if (i == 0 || pbr.parts[i - 1].object != object)
      out += fmt::format("o {}\n", source.object_name(object));
    out += fmt::format("usemtl {}\n", name(kind));
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
  write_file(folder / "mesh.mtl", materials);

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
  if (pbr.has_glass()) texture("transmission", t.transmission);
  return files;
}

}  // namespace

ExportFormat mesh_obj_format() {
  return {.name = "mesh-obj",
          .summary = "the mesh as OBJ text with MTL and textures",
          .holds =
              "the objects by name; triangles, normals, texture coordinates; textures of base colour, roughness, metalness and "
              "normals; a material each for opaque faces, panes of glass and solid glass, which has its index of refraction",
          .loses =
              "view dependence, colours above 1; MTL has no texture for transmission (the picture lies beside it, the material "
              "is one for all glass of a group) nor for the colour of reflections; it cannot say that panes bend no light; large "
              "and slow to read",
          .write = write_mesh_obj};
}

}  // namespace vitrine
