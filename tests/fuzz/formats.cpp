#include "tests/fuzz/formats.h"

#include "core/foundation/base/error.h"

namespace vitrine {

// Beside their entry functions.
std::vector<std::string> yaml_corpus(), lights_corpus(), marks_corpus(), edits_corpus(), compositions_corpus(), records_corpus(), scans_corpus();
std::vector<std::string> colmap_binary_corpus(), colmap_text_corpus(), transforms_corpus(), matrices_corpus();
std::vector<std::string> metashape_corpus(), opensfm_corpus(), openmvg_corpus();
std::vector<std::string> mesh_ply_corpus(), surfel_ply_corpus(), materials_corpus(), exr_corpus(), hdr_corpus(), photo_corpus(),
    tiff_corpus(), depth_corpus(), onnx_corpus(), weights_corpus(), objects_corpus();
std::vector<std::string> icc_corpus(), tagged_photo_corpus(), heif_corpus(), raw_corpus(), gpano_corpus(), film_text_corpus(),
    film_corpus();

std::span<const FuzzFormat> fuzz_formats() {
  using namespace std::string_view_literals;
  static const std::vector<std::string_view> yaml = {"[",   "]",     "{",   "}",    ": ",  "- ",   "\n", "  ",   "\t", "#",
                                                     "&a",  "*a",    "!!",  "|",    ">",   "? ",   "~",  "null", "\"", "'",
                                                     "\\x", "---\n", "...", "<<: ", "nan", "-inf", ",",  "1e999"};
  static const std::vector<std::string_view> json = {"[",
                                                     "]",
                                                     "{",
                                                     "}",
                                                     ",",
                                                     ":",
                                                     "null",
                                                     "true",
                                                     "\"\"",
                                                     "\"..\"",
                                                     "-1",
                                                     "1e999",
                                                     "1e-9",
                                                     "\"\\ud800\"",
                                                     "\"/etc\"",
                                                     "[[",
                                                     "{}",
                                                     "[]",
                                                     "18446744073709551616"};
  static const std::vector<std::string_view> numbers = {
      "-1", "nan", "inf", "1e308", "1e-320", "0", " ", "\n", "18446744073709551615", "4294967296", "../"};
  static const std::vector<std::string_view> ply = {"list ",
                                                    "uchar ",
                                                    "int ",
                                                    "float ",
                                                    "double ",
                                                    "property ",
                                                    "element face ",
                                                    "ascii",
                                                    "-1",
                                                    "4294967295",
                                                    "binary_big_endian",
                                                    "vertex_index",
                                                    "nan",
                                                    "end_header\n",
                                                    "18446744073709551615"};
  static const std::vector<FuzzFormat> all = {
      {"yaml", fuzz_yaml, yaml_corpus, yaml},
      {"lights", fuzz_lights, lights_corpus, yaml},
      {"marks", fuzz_marks, marks_corpus, yaml},
      {"edits", fuzz_edits, edits_corpus, yaml},
      {"compositions", fuzz_compositions, compositions_corpus, yaml},
      {"scans", fuzz_scans, scans_corpus, yaml},
      {"records", fuzz_records, records_corpus, json},
      {"objects", fuzz_objects, objects_corpus, json},
      {"colmap_binary", fuzz_colmap_binary, colmap_binary_corpus, {kPartMark, "../", "\0"sv}},
      {"colmap_text", fuzz_colmap_text, colmap_text_corpus, numbers},
      {"transforms", fuzz_transforms, transforms_corpus, json},
      {"metashape",
       fuzz_metashape,
       metashape_corpus,
       {"<", "/>", "</", "<!--", "<![CDATA[", "<!DOCTYPE a [", "&#0;", "&amp;", "<transform>", "<camera ", "nan", "inf", "1e999",
        "component_id=\"1\"", "sensor_id=\"9\"", "<group>", "<component id=\"1\">"}},
      {"opensfm", fuzz_opensfm, opensfm_corpus, json},
      {"openmvg", fuzz_openmvg, openmvg_corpus, json},
      {"matrices", fuzz_matrices, matrices_corpus, numbers},
      {"mesh_ply", fuzz_mesh_ply, mesh_ply_corpus, ply},
      {"surfel_ply", fuzz_surfel_ply, surfel_ply_corpus, ply},
      {"materials",
       fuzz_materials,
       materials_corpus,
       {"element subsurface 7\n", "element brushed 7\n", "element behind_glass 0\n", "end_header\n"}},
      {"exr",
       fuzz_exr,
       exr_corpus,
       {"tiles\0tiledesc\0"sv, "dataWindow\0box2i\0"sv, "chlist\0"sv, "\x76\x2f\x31\x01"sv, "\2\2\0\0"sv}},
      {"hdr",
       fuzz_hdr,
       hdr_corpus,
       {"-Y ", "+X ", "-X ", "+Y ", "2147483647", "\2\2", "\1\1\1\xff", "FORMAT=", "EXPOSURE=", "1e-320", "\n\n"}},
      {"photo",
       fuzz_photo,
       photo_corpus,
       {"\xff\xd9", "\xff\xda", "\xff\xc0", "\xff\xc2", "\xff\xc4", "IHDR", "IDAT", "PLTE", "tRNS", "eXIf", "IEND", "Exif\0\0"sv,
        "\xff\xd8"}},
      {"tiff",
       fuzz_tiff,
       tiff_corpus,
       {"II*\0"sv, "MM\0*"sv, "II+\0\x08\0\0\0"sv, "\x00\x01\x03\x00\x01\x00\x00\x00"sv, "\x01\x01\x04\x00\x01\x00\x00\x00"sv,
        "\x02\x01\x03\x00"sv, "\x03\x01\x03\x00"sv, "\x06\x01\x03\x00"sv, "\x11\x01\x04\x00"sv, "\x15\x01\x03\x00"sv,
        "\x16\x01\x04\x00"sv, "\x17\x01\x04\x00"sv, "\x1c\x01\x03\x00\x01\x00\x00\x00\x02"sv, "\x3d\x01\x03\x00"sv,
        "\x42\x01\x03\x00"sv, "\x4a\x01\x04\x00"sv, "\x52\x01\x03\x00"sv, "\x53\x01\x03\x00"sv, "\xff\xff\xff\x7f"sv}},
      {"depth",
       fuzz_depth,
       depth_corpus,
       {"depth_file_path", "depth_path", "integer_depth_scale", "-1", "1e999", "\"..\"", "IHDR", "IDAT", "\x10\x00\x00\x00\x00"sv, "\x76\x2f\x31\x01"sv,
        "chlist\0"sv, "Z\0"sv, "{}", "[]", kPartMark}},
      {"heif", fuzz_heif, heif_corpus, {"ftypheic", "ftypavif", "meta",       "iinf",      "infe\2"sv,       "iloc\1\0\0\0\x44"sv,
                                        "iref\1"sv, "iprp",     "ipco",       "ipma",      "ispe\0\0\0\0"sv, "irot",
                                        "imir",     "clap",     "colrnclx",   "colrprof",  "grid",           "iden",
                                        "auxl",     "dimg",     "\0\0\0\1"sv, "\0\0\0\0"sv}},
      {"raw",
       fuzz_raw,
       raw_corpus,
       {"II*\0"sv, "MM\0*"sv, "\x00\x01\x04\x00\x01\x00\x00\x00"sv, "\x03\x01\x03\x00"sv, "\x11\x01\x04\x00"sv,
        "\x17\x01\x04\x00"sv, "\x12\xc6\x01\x00"sv, "\x4a\x01\x04\x00"sv, "\xff\xff\xff\x7f"sv, "FUJIFILMCCD-RAW ", "IIRO",
        "Canon", "NIKON", "SONY"}},
      {"gpano", fuzz_gpano, gpano_corpus, {"xmlns:", "panorama/", "GPano:", "=\"", "'", "><", "1e9", "99999999999"}},
      {"film_text", fuzz_film_text, film_text_corpus, json},
      {"film",
       fuzz_film,
       film_corpus,
       {"moov", "mdat", "trak", "tkhd", "stsd", "stsz", "stco", "stts", "ctts", "avcC", "edts", "moof", "\xff\xff\xff\x7f"sv,
        "\x1a\x45\xdf\xa3"sv, "\x1f\x43\xb6\x75"sv}},
      {"icc",
       fuzz_icc,
       icc_corpus,
       {"acsp", "RGB ", "GRAY", "CMYK", "XYZ ", "Lab ", "curv", "para", "mft2", "mAB ", "rTRC", "A2B0"}},
      {"tagged_photo",
       fuzz_photo,
       tagged_photo_corpus,
       {"ICC_PROFILE\0"sv, "\xff\xe2", "iCCP", "cICP", "gAMA", "cHRM", "sRGB", "acsp", "\x73\x87"}},
      {"onnx",
       fuzz_onnx,
       onnx_corpus,
       {"Conv", "Resize", "Slice", "Concat", "Reshape", "Constant", "Gemm", "Pad", "Split", "Upsample"}},
      {"weights", fuzz_weights, weights_corpus, json},
  };
  return all;
}

const FuzzFormat& fuzz_format(std::string_view name) {
  std::string names;
  for (const FuzzFormat& f : fuzz_formats()) {
    if (f.name == name) return f;
    names += fmt::format("{}{}", names.empty() ? "" : " ", f.name);
  }
  throw Error(ErrorKind::Usage, fmt::format("there is no format '{}'", name),
              {.why = "the formats are: " + names, .code = "USAGE"});
}

}  // namespace vitrine
