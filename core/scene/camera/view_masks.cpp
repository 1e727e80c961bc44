#include "core/scene/camera/view_masks.h"

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace fs = std::filesystem;

fs::path view_mask_path(const fs::path& artifact, MaskClass kind, const View& view) {
  return artifact / "masks" / name(kind) / (view.stem() + ".png");
}

std::optional<ImageF> read_view_mask(const fs::path& artifact, MaskClass kind, const View& view) {
  const fs::path path = view_mask_path(artifact, kind, view);
  std::error_code ec;
  if (!fs::exists(path, ec)) return std::nullopt;
  ImageF file = read_unchanged(path);
  const Intrinsics& k = view.intrinsics;
  if (file.width() != k.width || file.height() != k.height)
    throw Error(
        ErrorKind::Input, "a mask and its photo have different sizes",
        {.where = path.string(),
         .why = fmt::format("the mask has {} x {} pixels, the photo {} x {}", file.width(), file.height(), k.width, k.height),
         .hint = "run the masks stage again",
         .code = "MASK_SIZE"});
  if (file.channels() == 1) return file;
  // Masks edited and saved in colour: all channels are equal.
  ImageF grey(file.width(), file.height(), 1);
  for (size_t i = 0; i < grey.pixel_count(); ++i) grey.data()[i] = file.data()[i * size_t(file.channels())];
  return grey;
}

namespace {

fs::path origin_path(const fs::path& artifact) { return artifact / "masks" / "origin.json"; }

}  // namespace

MaskOrigin mask_origin(const fs::path& artifact, MaskClass kind) {
  MaskOrigin out;
  if (!fs::exists(origin_path(artifact))) return out;
  read_json_file(origin_path(artifact), "list of the origins of masks", [&](const nlohmann::json& j) {
    const JsonAt root(j);
    const std::string word(name(kind));
    if (!root.has(word.c_str())) return;
    const JsonAt row = root.at(word.c_str());
    out = {row.at("source").text(), row.at("trust").text(), row.at("propagated").value().get<bool>()};
  });
  return out;
}

std::vector<std::string> marked_objects(const fs::path& artifact) {
  std::vector<std::string> out;
  if (!fs::exists(origin_path(artifact))) return out;
  read_json_file(origin_path(artifact), "list of the origins of masks",
                 [&](const nlohmann::json& j) { out = j.value("things", out); });
  return out;
}

fs::path marked_objects_path(const fs::path& artifact, const View& view) {
  return artifact / "masks" / "marked" / (view.stem() + ".png");
}

void write_mask_origins(const fs::path& artifact, const std::map<MaskClass, MaskOrigin>& origins,
                        const std::vector<std::string>& objects) {
  nlohmann::json j = nlohmann::json::object();
  for (const auto& [kind, origin] : origins)
    j[std::string(name(kind))] = {{"source", origin.source}, {"trust", origin.trust}, {"propagated", origin.propagated}};
  if (!objects.empty()) j["things"] = objects;
  make_folders(origin_path(artifact).parent_path());
  write_json_file(origin_path(artifact), j);
}

}  // namespace vitrine
