// Binary files: meshes, surfels, pictures, networks.
#include <cmath>
#include <cstring>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>

#include "core/intake/depth/depth_files.h"
#include "core/intake/masks/mask_files.h"
#include "core/learn/loss/feature_network.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/light/environment.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/ingest/develop.h"
#include "stages/normals/normals.h"
#include "tests/fuzz/entry.h"
#include "tests/stages/normals/tiny_onnx.h"
#include "tests/support/feature_network_file.h"
#include "tests/support/tiff_file.h"
#include "tests/support/gps_exif.h"

namespace vitrine {

void fuzz_mesh_ply(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("mesh.ply", text_of(bytes));
  refuses_or_reads([&] { read_mesh_ply(path); });
}

void fuzz_surfel_ply(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("surfels.ply", text_of(bytes));
  refuses_or_reads([&] { read_layer(path); });
}

void fuzz_materials(std::span<const uint8_t> bytes) {
  make_folders(fuzz_folder() / "decompose");
  input_file("decompose/materials.ply", text_of(bytes));
  refuses_or_reads([&] { read_decomposed_materials(fuzz_folder()); });
}

void fuzz_exr(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("picture.exr", text_of(bytes));
  refuses_or_reads([&] { read_exr(path); });
  refuses_or_reads([&] { ingest::develop(path, 64); });
}

void fuzz_hdr(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("sky.hdr", text_of(bytes));
  refuses_or_reads([&] {
    const Environment sky = read_environment(path);
    (void)sky.sample({0.3f, 0.7f});
  });
}

// PNG and JPEG as photos; the same bytes as a mask.
void fuzz_photo(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("photo.png", text_of(bytes));
  refuses_or_reads([&] { ingest::develop(path, 64); });
  refuses_or_reads([&] { read_mask({path, "b.*"}); });
}

// The same, and twice: no byte of the picture may come from elsewhere than the file.
void fuzz_tiff(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("photo.tif", text_of(bytes));
  refuses_or_reads([&] { ingest::develop(path, 64); });
  refuses_or_reads([&] {
    const ImageF first = read_unchanged(path), again = read_unchanged(path);
    if (first.data().size_bytes() != again.data().size_bytes() ||
        std::memcmp(first.data().data(), again.data().data(), first.data().size_bytes()) != 0)
      throw std::logic_error("two readings of a TIFF differ");
  });
}

// One file under the names of all types, and as the list that names it.
void fuzz_depth(std::span<const uint8_t> bytes) {
  const auto parts = parts_of(bytes, 2);
  for (const char* name : {"depth.png", "depth.exr"}) {
    const fs::path path = input_file(name, parts[1]);
    refuses_or_reads([&] { read_depth(path); });
  }
  const fs::path list = input_file("transforms.json", parts[0]);
  refuses_or_reads([&] {
    const DepthFolder folder(list);
    const std::vector<std::string> photos{"images/a.jpg", "b.jpg"};
    for (const auto& file : folder.match(photos))
      if (file) read_depth(*file, folder.unit());
  });
}

void fuzz_onnx(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("network.onnx", text_of(bytes));
  refuses_or_reads([&] {
    OnnxConfig config;
    config.input.width = config.input.height = 16;
    NormalNetwork network(path, config);
    network.predict(ImageF(16, 16, 3, 0.5f));
  });
}

void fuzz_weights(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("vgg.safetensors", text_of(bytes));
  refuses_or_reads([&] { FeatureNetwork{path}; });
}

namespace {

std::string bytes_of(const char* name, const std::function<void(const fs::path&)>& write) {
  const fs::path path = fuzz_folder() / name;
  write(path);
  return read_file(path);
}

ImageF gradient(int width, int height, int channels) {
  ImageF image(width, height, channels);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = float(i % 97) / 96.f;
  return image;
}

Image8 gradient8(int width, int height, int channels) {
  Image8 image(width, height, channels);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = static_cast<uint8_t>(i * 37);
  return image;
}

}  // namespace

std::vector<std::string> depth_corpus() {
  const std::string list =
      R"({"depth_unit_scale_factor": 0.001, "frames": [{"file_path": "images/a.jpg", "depth_file_path": "depth.png"},)"
      R"( {"file_path": "images/b.jpg", "depth_path": "/other/set/depth.exr"}]})";
  Image16 steps(9, 7, 1);
  for (size_t i = 0; i < steps.data().size(); ++i) steps.data()[i] = static_cast<uint16_t>(i * 331);
  const ExrImage layers{.pixels = gradient(9, 7, 2), .channels = {"ViewLayer.Depth.Z", "Y"}, .attributes = {}};
  return {list + std::string(kPartMark) + bytes_of("made.png", [&](const fs::path& p) { write_png16(p, steps); }),
          list + std::string(kPartMark) + bytes_of("made.exr", [&](const fs::path& p) { write_exr(p, layers, ExrPrecision::Float); }),
          list + std::string(kPartMark) + bytes_of("made.png", [&](const fs::path& p) { write_ldr(p, gradient8(9, 7, 3)); })};
}

std::vector<std::string> mesh_ply_corpus() {
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.normals.assign(4, {0, 0, 1});
  mesh.colors.assign(4, {0.2f, 0.5f, 0.7f});
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return {
      bytes_of("made.ply", [&](const fs::path& p) { write_mesh_ply(p, mesh); }),
      "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty double x\nproperty float y\nproperty float z\n"
      "property ushort red\nproperty ushort green\nproperty ushort blue\nelement face 1\nproperty list uchar int vertex_index\n"
      "property float quality\nelement edge 1\nproperty list int int ends\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n1 1 0 1 2 3\n"
      "0 1 0 1 2 3\n4 0 1 2 3 0.5\n2 0 1\n"};
}

std::vector<std::string> materials_corpus() {
  TemporaryFolder folder;
  const auto written = [&](const DecomposedMaterials& materials) {
    write_decomposed_materials(folder.path(), materials);
    return read_file(decomposed_materials_path(folder.path()));
  };
  DecomposedMaterials materials;
  materials.resize(7);
  std::vector<std::string> out{written(materials)};
  materials.albedo_behind_glass.resize(3);
  materials.scatter.resize(7, {0.1f, 0.2f, 0.3f});
  materials.marks.resize(7, {0, 0.5f, -1});
  out.push_back(written(materials));
  return out;
}

std::vector<std::string> surfel_ply_corpus() {
  std::vector<std::string> all;
  for (LayerKind kind : kAllLayers) {
    SplatLayer layer(kind, 1, 3);
    for (const AttributeRow& r : kAttributes)
      for (float& v : layer.values(r.id)) v = 0.25f;
    all.push_back(bytes_of("made.ply", [&](const fs::path& p) { write_layer(p, layer); }));
  }
  return all;
}

namespace {

std::string made_exr_parts() {
  return bytes_of("made.exr", [](const fs::path& p) {
    std::vector<Imf::Header> headers(2, Imf::Header({{2, 3}, {21, 15}}, {{0, 5}, {30, 14}}));
    std::vector<float> plane(31 * 10, 0.5f);
    Imf::FrameBuffer buffer;
    const auto slice = Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(plane.data() - 5 * 31), 4, 31 * 4);
    headers[0].channels().insert("Z", Imf::Channel(Imf::FLOAT));
    for (const char* name : {"R", "G", "B"})
      headers[1].channels().insert(name, Imf::Channel(Imf::FLOAT)), buffer.insert(name, slice);
    buffer.insert("Z", slice);
    for (size_t i = 0; i < 2; ++i) headers[i].setType(Imf::SCANLINEIMAGE), headers[i].setName(i == 0 ? "depth" : "rgb");
    Imf::MultiPartOutputFile file(p.c_str(), headers.data(), 2);
    for (int i = 0; i < 2; ++i) {
      Imf::OutputPart part(file, i);
      part.setFrameBuffer(buffer);
      part.writePixels(10);
    }
  });
}

std::string made_exr_luminance_chroma() {
  return bytes_of("made.exr", [](const fs::path& p) {
    std::vector<Imf::Rgba> pixels(24 * 18, Imf::Rgba(0.5f, 0.25f, 0.125f, 1.f));
    Imf::RgbaOutputFile file(p.c_str(), 24, 18, Imf::WRITE_YC);
    file.setFrameBuffer(pixels.data(), 1, 24);
    file.writePixels(18);
  });
}

}  // namespace

std::vector<std::string> exr_corpus() {
  const auto rgb = [](ExrPrecision precision) {
    return bytes_of("made.exr", [&](const fs::path& p) {
      write_exr_rgb(p, gradient(20, 13, 3), precision, {{"vitrine:stage", "x"}});
    });
  };
  return {rgb(ExrPrecision::Half),
          rgb(ExrPrecision::Float),
          bytes_of(
              "made.exr",
              [](const fs::path& p) {
                write_exr(p, {.pixels = gradient(9, 40, 2), .channels = {"depth.Z", "Y"}, .attributes = {}}, ExrPrecision::Float);
              }),
          bytes_of("made.exr",
                   [](const fs::path& p) {
                     write_exr(p, {.pixels = gradient(24, 18, 5),
                                   .channels = {"V.Combined.R", "V.Combined.G", "V.Combined.B", "V.Combined.A", "V.Depth.Z"},
                                   .attributes = {}});
                   }),
          made_exr_parts(),
          made_exr_luminance_chroma()};
}

std::vector<std::string> hdr_corpus() {
  std::string flat = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
  for (int i = 0; i < 7; ++i) flat += std::string{char(100 + i), char(90), char(80), char(129)};
  flat += std::string("\1\1\1\1", 4);
  std::string coded = "#?RADIANCE\nEXPOSURE=1\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
  for (int y = 0; y < 8; ++y) {
    coded += std::string("\2\2\0\20", 4);
    for (int c = 0; c < 4; ++c) coded += std::string("\212", 1) + char(130) + std::string("\6", 1) + "abcdef";
  }
  std::string turned =
      "#?RADIANCE\nEXPOSURE=2\nEXPOSURE=0.5\nCOLORCORR=1 2 3\nPRIMARIES=.6 .3 .3 .6 .1 .1 .3 .3\nFORMAT=32-bit_rle_xyze\n\n+X 4 "
      "+Y 2\n";
  for (int i = 0; i < 8; ++i) turned += std::string{char(100 + i), char(90), char(80), char(129)};
  return {flat, coded, turned};
}

std::vector<std::string> photo_corpus() {
  using namespace test;
  const auto file = [](const char* name, int channels) {
    return bytes_of(name, [&](const fs::path& p) { write_ldr(p, gradient8(24, 18, channels)); });
  };
  const std::string exif = exif_bytes({{0x010f, 'a', 0, 1, "Maker"}, {0x0112, 's', 6}},
                                      {{0x829a, 'r', 1, 125}, {0x829d, 'r', 28, 10}, {0x8827, 's', 200}, {0xa405, 's', 35}});
  Image16 deep(10, 9, 3);
  for (size_t i = 0; i < deep.data().size(); ++i) deep.data()[i] = static_cast<uint16_t>(i * 1237);
  return {bytes_of("made.jpg",
                   [&](const fs::path& p) {
                     write_ldr(p, gradient8(24, 18, 3));
                     add_exif(p, exif);
                   }),
          bytes_of("made.jpg",
                   [&](const fs::path& p) {
                     write_ldr(p, gradient8(24, 18, 3));
                     add_exif(p, exif_with_gps(place_tags(-47.5, 8.25, 431)));
                   }),
          file("made.jpg", 1),
          file("made.png", 3),
          file("made.png", 1),
          bytes_of("made.png", [&](const fs::path& p) { write_png16(p, deep); }),
          file("made.jpg", 3) + std::string("\0\0\0\x18", 4) + "ftypmp42" + file("made.jpg", 1) + std::string(64, '\0'),
          jpeg_bytes(gradient8(24, 18, 3), 80)};
}

std::vector<std::string> tiff_corpus() {
  using test::TiffDesc;
  std::vector<std::string> all;
  const auto add = [&](const std::vector<TiffDesc>& pages) {
    all.push_back(bytes_of("made.tif", [&](const fs::path& p) {
      TIFF* const tiff = test::open_tiff(p, pages[0]);
      for (const TiffDesc& d : pages) test::add_tiff_page(tiff, d.subfile ? 9 : 37, d.subfile ? 7 : 29, d);
      TIFFClose(tiff);
    }));
  };
  add({{}});
  add({{.bits = 16, .planar = true}});
  add({{.bits = 32,
        .format = SAMPLEFORMAT_IEEEFP,
        .compression = COMPRESSION_ADOBE_DEFLATE,
        .predictor = 3,
        .planar = true,
        .big = true}});
  add({{.bits = 16, .compression = COMPRESSION_LZW, .predictor = 2, .tiled = true, .big_endian = true}});
  add({{.subfile = FILETYPE_REDUCEDIMAGE},
       {.samples = 4, .compression = COMPRESSION_PACKBITS, .extra = {EXTRASAMPLE_ASSOCALPHA}}});
  add({{.bits = 4, .samples = 1, .photometric = PHOTOMETRIC_PALETTE}});
  add({{.bits = 1, .samples = 1, .photometric = PHOTOMETRIC_MINISWHITE, .compression = COMPRESSION_CCITTFAX4}});
  add({{.compression = COMPRESSION_JPEG}});
  add({{.photometric = PHOTOMETRIC_YCBCR, .compression = COMPRESSION_LZW, .tiled = false}});
  add({{.bits = 12, .compression = COMPRESSION_LZW}});
  all.push_back(bytes_of("made.tif", [&](const fs::path& p) { write_ldr(p, gradient8(24, 18, 3)); }));
  return all;
}

std::vector<std::string> onnx_corpus() {
  return {test::one_operator_network("Relu", 16, 16), test::one_operator_network("Sigmoid", 16, 16),
          test::one_operator_network("Identity", 16, 16),
          read_file(fs::path(VITRINE_SOURCE_DIR) / "stages/normals/network/rooms.onnx")};
}

std::vector<std::string> weights_corpus() {
  return {bytes_of("made.safetensors", [](const fs::path& p) { testing::write_network(p, testing::small_network()); })};
}

}  // namespace vitrine
