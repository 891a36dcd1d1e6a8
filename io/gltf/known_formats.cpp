#include "io/gltf/known_formats.h"

#include <algorithm>
#include <cstddef>

#include "io/ascii.h"

namespace palpate {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kConvert = "export it as glTF 2.0, for example with Blender";
constexpr std::string_view kUnpack = "unpack it, and name the .gltf or .glb file in it";
constexpr std::string_view kImage = "name the .gltf or .glb file that uses it";
constexpr std::string_view kNameAnother = "name a .gltf or .glb file";

struct Signature {
  std::size_t offset;
  std::string_view bytes;
  KnownFormat format;
};

constexpr Signature kSignatures[] = {
    {0, "PK\x03\x04"sv, {"a ZIP archive (.zip, .usdz, .3mf)", kUnpack}},
    {0, "PK\x05\x06"sv, {"an empty ZIP archive", kUnpack}},
    {0, "\x1f\x8b"sv, {"a gzip file", kUnpack}},
    {0, "BZh"sv, {"a bzip2 file", kUnpack}},
    {0, "\xfd\x37zXZ\0"sv, {"an xz file", kUnpack}},
    {0, "\x28\xb5\x2f\xfd"sv, {"a Zstandard file", kUnpack}},
    {0, "7z\xbc\xaf\x27\x1c"sv, {"a 7-Zip archive", kUnpack}},
    {0, "Rar!\x1a\x07"sv, {"a RAR archive", kUnpack}},
    {257, "ustar"sv, {"a tar archive", kUnpack}},
    {0, "\x89PNG\r\n\x1a\n"sv, {"a PNG image", kImage}},
    {0, "\xff\xd8\xff"sv, {"a JPEG image", kImage}},
    {0, "GIF8"sv, {"a GIF image", kImage}},
    {8, "WEBP"sv, {"a WebP image", kImage}},
    {0, "\xabKTX"sv, {"a KTX texture", kImage}},
    {0, "Kaydara FBX Binary"sv, {"an FBX file", kConvert}},
    {0, "; FBX"sv, {"an FBX file", kConvert}},
    {0, "BLENDER"sv, {"a Blender file", kConvert}},
    {0, "ply\n"sv, {"a PLY file", kConvert}},
    {0, "ply\r"sv, {"a PLY file", kConvert}},
    {0, "#usda"sv, {"a USD file", kConvert}},
    {0, "PXR-USDC"sv, {"a USD file", kConvert}},
    {0, "#VRML"sv, {"a VRML file", kConvert}},
    {0, "ISO-10303-21"sv, {"a STEP file", kConvert}},
    {0, "OFF\n"sv, {"an OFF file", kConvert}},
    {0, "b3dm"sv, {"a tile of 3D Tiles", "extract the GLB in it"}},
    {0, "i3dm"sv, {"a tile of 3D Tiles", "extract the GLB in it"}},
    {0, "cmpt"sv, {"a tile of 3D Tiles", "extract the GLB in it"}},
    {0, "SQLite format 3\0"sv, {"an SQLite database", kNameAnother}},
    {0, "%PDF-"sv, {"a PDF document", kNameAnother}},
    {0,
     "\x7f"
     "ELF"sv,
     {"a program", kNameAnother}},
    {0, "MZ"sv, {"a program", kNameAnother}},
    {0,
     "version https://git-lfs.github.com/spec/"sv,
     {"a Git LFS pointer, not the data", "run git lfs pull where the asset came from"}},
};

// The words that begin a line of an OBJ file.
constexpr std::string_view kObjWords[] = {"v", "vn", "vt",     "f",      "o",
                                          "g", "s",  "mtllib", "usemtl", "#"};

std::string_view from_first_word(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == text.npos ? std::string_view() : text.substr(first);
}

// Whether all lines but the last, which may be cut, begin with a word of OBJ, and one is a vertex.
bool is_obj(std::string_view text) {
  bool has_vertex = false;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = from_first_word(text.substr(0, end));
    const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
    const bool is_word =
        word.empty() || word.front() == '#' ||
        std::find(std::begin(kObjWords), std::end(kObjWords), word) != std::end(kObjWords);
    if (!is_word && end != text.npos) return false;
    has_vertex = has_vertex || word == "v";
    text = end == text.npos ? std::string_view() : text.substr(end + 1);
  }
  return has_vertex;
}

}  // namespace

std::optional<KnownFormat> known_format(std::string_view start) {
  for (const Signature& signature : kSignatures) {
    if (start.size() < signature.offset) continue;
    if (start.substr(signature.offset).starts_with(signature.bytes)) return signature.format;
  }
  const std::string_view text = from_first_word(start);
  for (const std::string_view html : {"<!doctype html"sv, "<html"sv}) {
    if (starts_with_ignoring_case(text, html)) {
      return KnownFormat{"an HTML page", "download the file itself, not the page about it"};
    }
  }
  if (text.starts_with("<?xml") || text.starts_with("<COLLADA")) {
    return text.find("COLLADA") != text.npos ? KnownFormat{"a COLLADA file", kConvert}
                                             : KnownFormat{"an XML file", kNameAnother};
  }
  if (text.starts_with("solid") && text.find("facet") != text.npos) {
    return KnownFormat{"an STL file", kConvert};
  }
  if (text.starts_with("[")) {
    return KnownFormat{"a JSON array", "a glTF asset is a JSON object: {\"asset\": ...}"};
  }
  if (is_obj(text)) return KnownFormat{"an OBJ file", kConvert};
  return std::nullopt;
}

}  // namespace palpate
