// Every file format that vitrine reads, as a function of bytes: the real parser is called, and only two ends are allowed, success
// or vitrine::Error that is not our own bug. Everything else (another exception, a signal, memory out of proportion, a hang) is a
// defect. Several files that belong together (a COLMAP model) are one input: kPartMark stands between them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

inline constexpr std::string_view kPartMark = "\n=part=\n";

struct FuzzFormat {
  std::string_view name;
  void (*entry)(std::span<const uint8_t>);
  std::vector<std::string> (*corpus)();  // small valid inputs, made by vitrine's own writers where there are some
  std::vector<std::string_view> words;   // what such files are made of
};

std::span<const FuzzFormat> fuzz_formats();
const FuzzFormat& fuzz_format(std::string_view name);  // Throws Error{Usage} with all names.

void fuzz_yaml(std::span<const uint8_t> bytes);
void fuzz_lights(std::span<const uint8_t> bytes);
void fuzz_marks(std::span<const uint8_t> bytes);
void fuzz_edits(std::span<const uint8_t> bytes);
void fuzz_compositions(std::span<const uint8_t> bytes);
void fuzz_scans(std::span<const uint8_t> bytes);
void fuzz_objects(std::span<const uint8_t> bytes);
void fuzz_colmap_binary(std::span<const uint8_t> bytes);
void fuzz_colmap_text(std::span<const uint8_t> bytes);
void fuzz_transforms(std::span<const uint8_t> bytes);
void fuzz_metashape(std::span<const uint8_t> bytes);
void fuzz_opensfm(std::span<const uint8_t> bytes);
void fuzz_openmvg(std::span<const uint8_t> bytes);
void fuzz_matrices(std::span<const uint8_t> bytes);
void fuzz_records(std::span<const uint8_t> bytes);
void fuzz_mesh_ply(std::span<const uint8_t> bytes);
void fuzz_surfel_ply(std::span<const uint8_t> bytes);
void fuzz_materials(std::span<const uint8_t> bytes);
void fuzz_exr(std::span<const uint8_t> bytes);
void fuzz_hdr(std::span<const uint8_t> bytes);
void fuzz_photo(std::span<const uint8_t> bytes);
void fuzz_tiff(std::span<const uint8_t> bytes);
void fuzz_heif(std::span<const uint8_t> bytes);
void fuzz_raw(std::span<const uint8_t> bytes);
void fuzz_gpano(std::span<const uint8_t> bytes);
void fuzz_film_text(std::span<const uint8_t> bytes);
void fuzz_film(std::span<const uint8_t> bytes);
void fuzz_icc(std::span<const uint8_t> bytes);
void fuzz_depth(std::span<const uint8_t> bytes);
void fuzz_onnx(std::span<const uint8_t> bytes);
void fuzz_weights(std::span<const uint8_t> bytes);

}  // namespace vitrine
