// What programs that work on a trained scene answer to mistakes: training, mesh, pictures, lights, edits, export.
#include "tests/core/render/relight/relit_ball.h"
#include "tests/golden/told.h"

namespace vitrine {
namespace {

class GoldenMessagesOfScenes : public Told {
 protected:
  GoldenMessagesOfScenes() {
    for (const auto& [name, path] : capture_.inputs(false)) fs::copy(path, folder.path() / name, fs::copy_options::recursive);
    make_folders(folder.path() / "decompose/decompose");
    write_decomposed_materials(folder.path() / "decompose", test::relit_ball({0.8f, 0.4f, 0.2f}).materials);
    write_environment(decomposed_environment_path(folder.path() / "decompose"), Environment(ImageF(16, 8, 3, 1.f)));
  }
  static Words words(const std::string& program, const std::vector<std::string>& inputs, const Words& more) {
    Words all = {program, "-o", "result", "-q"};
    for (const std::string& input : inputs) all.insert(all.end(), {"-i", input});
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static Words relit(const Words& more) {
    return words("vitrine-relight", {"sfm=sfm", "optimize=optimize", "mesh=mesh", "decompose=decompose"}, more);
  }
  static Words edit(const std::string& list) {
    return words("vitrine-edit", {"sfm=sfm", "optimize=optimize", "mesh=mesh", "decompose=decompose", "edits=" + list}, {});
  }
  static Words render(const Words& more) { return words("vitrine-render", {"sfm=sfm", "optimize=optimize"}, more); }
  static Words optimize(const Words& more) { return words("vitrine-optimize", {"sfm=sfm"}, more); }
  static Words exported(const Words& more) {
    return words("vitrine-export", {"sfm=sfm", "optimize=optimize", "mesh=mesh"}, more);
  }
  // A copy of an input with one file replaced.
  std::string damaged(const std::string& input, const std::string& file, const std::string& bytes) const {
    const std::string name = "damaged " + input;
    fs::remove_all(folder.path() / name);
    fs::copy(folder.path() / input, folder.path() / name, fs::copy_options::recursive);
    return put(name + "/" + file, bytes), name;
  }

  test::TinyCapture capture_;
};

TEST_F(GoldenMessagesOfScenes, InTrainingAndMesh) {
  told("no photo left to train on", optimize({"--set", "holdout_every=1"}));
  told("no room for the photos", optimize({"--set", "iterations=3", "--max-memory", "20MiB"}));
  const std::string one = "linear/view_1.exr";
  fs::copy(folder.path() / "sfm", folder.path() / "small", fs::copy_options::recursive);
  write_exr_rgb(folder.path() / "small" / one, ImageF(8, 6, 3, 0.5f));
  told("a photo of another size than its camera", words("vitrine-optimize", {"sfm=small"}, {}));
  told("a photo that cannot be read", words("vitrine-optimize", {"sfm=" + damaged("sfm", one, "no picture")}, {}));
  told("a photo without its gain",
       words("vitrine-optimize", {"sfm=" + damaged("sfm", "sfm/gains.json", R"({"view_0.png": [1, 1, 1]})")}, {}));
  const auto mesh = [](const std::string& scene, const Words& more) {
    return words("vitrine-mesh", {"sfm=sfm", "optimize=" + scene}, more);
  };
  told("surfels that cannot be read", mesh(damaged("optimize", "gaussians/diffuse.ply", "ply\nformat ascii 1.0\n"), {}));
  told("no list of views", mesh(damaged("optimize", "optimize/views.json", "{"), {}));
  told("a mesh that is too fine", mesh("optimize", {"--set", "voxel=0.00002"}));
  told("a mesh of what is not there", mesh("optimize", {"--set", "resolution=16", "--set", "region.box=5,5,5,6,6,6"}));
  golden::expect_golden("in_training_and_mesh.txt", all());
}

TEST_F(GoldenMessagesOfScenes, AboutPicturesAndLights) {
  told("views that there are not", render({"--set", "views=some"}));
  told("a path without a file", render({"--set", "views=path"}));
  told("a picture of absurd size", render({"--set", "width=1000000", "--set", "height=1000000"}));
  const std::string flat = R"({"w": 9, "h": 9, "fl_x": 9, "frames": [{"file_path": "a", "transform_matrix":
    [[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]}]})";
  told("a camera that flattens space", render({"-i", "path=" + put("flat.json", flat), "--set", "views=path"}));
  const auto env = [](const std::string& file) { return relit({"-i", "env=" + file}); };
  told("no environment", env("nowhere.exr"));
  told("an environment that is none", env(put("e.hdr", "no picture")));
  fs::copy_file(photos() / "img_0001.png", folder.path() / "e.png");
  told("a photo as environment", env("e.png"));
  write_exr_rgb(folder.path() / "square.exr", ImageF(16, 16, 3, 1.f));
  told("an environment of another shape", env("square.exr"));
  ImageF poisoned(16, 8, 3, 1.f);
  poisoned.at(3, 2, 1) = std::numeric_limits<float>::quiet_NaN();
  write_exr_rgb(folder.path() / "nan.exr", poisoned, ExrPrecision::Float);
  told("an environment with texels that are no light", env("nan.exr"));
  told("mistakes in lights", relit({"-i", "lights=" + put("lights.yaml",
                                                          "lights:\n  - {type: pont, position: [0, 0, 2]}\n"
                                                          "  - {type: point, position: [0, 0], intensity: -1}\n")}));
  told("no lamp in the lights", relit({"-i", "lights=" + put("none.yaml", "lights: []\n")}));
  told("a lamp that is off",
       relit({"-i", "lights=" + put("off.yaml", "lights:\n  - {type: point, position: [0, 0, 2], intensity: 0}\n")}));
  write_exr_rgb(folder.path() / "black.exr", ImageF(16, 8, 3));
  told("a black environment", env("black.exr"));
  told("materials of another scene", words("vitrine-relight",
                                           {"sfm=sfm", "optimize=optimize", "mesh=mesh",
                                            "decompose=" + damaged("decompose", "decompose/materials.ply", "ply\n")},
                                           {}));
  told("a mesh that cannot be read",
       words("vitrine-relight",
             {"sfm=sfm", "optimize=optimize", "mesh=" + damaged("mesh", "mesh/mesh.ply", "ply\nformat"), "decompose=decompose"},
             {}));
  golden::expect_golden("about_pictures_and_lights.txt", all());
}

TEST_F(GoldenMessagesOfScenes, AboutEditsAndExport) {
  told("no list of edits", edit("nowhere.yaml"));
  told("a list that is none", edit(put("words.yaml", "make it golden\n")));
  told("mistakes in edits",
       edit(put("wrong.yaml",
                "edits:\n  - name: gold\n    select: {clas: specular}\n    set: {tint: 12, colour: red}\n  - select: everything\n"
                "    delete: no\n  - select: {box: [1, 2, 3]}\n")));
  told("an edit that finds nothing",
       edit(put("far.yaml", "edits:\n  - name: far\n    select: {box: [8, 8, 8, 9, 9, 9]}\n    delete: true\n")));
  told("an edit that deletes all", edit(put("all.yaml", "edits:\n  - select: all\n    delete: true\n")));
  told("a part that there is not", edit(put("part.yaml", "edits:\n  - select: {component: 7}\n    set: {roughness: 0.5}\n")));
  told("masks that there are not", edit(put("class.yaml", "edits:\n  - select: {class: specular}\n    set: {tint: 0.5}\n")));
  told("a format that there is not", exported({"--set", "formats=mesh-gbl"}));
  told("albedo that nobody found", exported({"--set", "formats=ply-albedo"}));
  told("no length", exported({"--set", "scale=long"}));
  told("a frame that there is not", exported({"--set", "axes=up"}));
  told("an output folder without its pictures", exported({}));
  const auto evaluate = [](const std::string& truth) {
    return words("vitrine-evaluate", {"sfm=sfm", "optimize=optimize", "mesh=mesh", "truth=" + truth}, {});
  };
  told("truth that is a file", evaluate(put("truth.txt", "true")));
  golden::expect_golden("about_edits_and_export.txt", all());
}

}  // namespace
}  // namespace vitrine
