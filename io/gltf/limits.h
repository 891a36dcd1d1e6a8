#pragma once

// The limits of read_gltf(). Above a limit it returns ErrorCode::kLimitExceeded. The limits bound
// the memory and the time that a hostile file can cost; each limit is checked before the allocation
// that it bounds. The largest memory cost of an asset:
//
//   the file, as it stands            its size                        kMaxGltfFileBytes
//   external buffers and data URIs    what they declare               kMaxGltfBufferBytes
//   compressed data, while decoded    see gltf/draco.h; views stay    kMaxGltfBufferBytes for both
//   the JSON, parsed: elements        1200 bytes each                 kMaxGltfElements
//   the JSON, parsed: other values    16 to 96 bytes each             kMaxGltfJsonMemory
//   sections of the JSON, in the      2 KiB an element, however       kMaxGltfElements
//   model of tinygltf                 short its text
//   positions, while decoded          2 x 24 bytes a vertex           kMaxGltfVertices
//   texture coordinates, as they are  2 x 24 bytes a vertex and map   kMaxGltfVertices
//   triangles, while decoded          2 x 12 bytes, and the indices   kMaxGltfTriangles
//   zeros that no view holds          as positions or indices         kMaxGltfUnstored
//   a pose, while it is made          120 bytes a vertex              kMaxGltfVertices
//   joints                            250 bytes each                  kMaxGltfJoints
//   instances                         600 bytes each                  kMaxGltfInstances
//   images that are decoded           their file, and 6 bytes a       kMaxGltfImageBytes,
//                                     pixel, 16 while decoded         kMaxGltfPixels
//   entries of extras.palpate         400 bytes each, and their text  kMaxGltfParameters
//   extras.palpate_contour            1200 bytes each                 kMaxGltfContours
//
// The table covers reading only. Height maps, which the engine computes from images afterwards,
// have a separate limit: kMostMapTexels (engine/scene/surface_attributes.h).
//
// tests/engine/cli/corpus_test.py checks that a real asset costs less than 64 MiB plus 40 times the
// bytes that it refers to. tests/io/gltf/hostile_gltf_test.cpp checks the same for hostile assets,
// except for elements, zeros and images of one colour, which take almost no bytes in the file.

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace palpate {

inline constexpr std::uint64_t kMaxGltfFileBytes = std::uint64_t{1} << 30;  // per file
inline constexpr std::uint64_t kMaxGltfBufferBytes = std::uint64_t{1} << 31;
inline constexpr std::uint64_t kMaxGltfJsonBytes = std::uint64_t{1} << 29;  // data URIs included
inline constexpr std::size_t kMaxGltfChunks = std::size_t{1} << 12;         // of a GLB
inline constexpr std::size_t kMaxGltfJsonValues = std::size_t{1} << 24;
inline constexpr std::size_t kMaxGltfStringBytes = std::size_t{1} << 24;  // data URIs excepted
// All strings together, without long data of data URIs: the names of nodes are held up to four
// times.
inline constexpr std::size_t kMaxGltfStringBytesInAll = std::size_t{1} << 26;
inline constexpr std::size_t kMaxGltfJsonDepth = 256;
// Scenes, nodes, meshes, primitives, morph targets, accessors, buffer views and buffers, together.
inline constexpr std::size_t kMaxGltfElements = std::size_t{1} << 20;
// The limit is lower for a short text, because a meaningful element takes at least 12 bytes,
// whereas an empty one ("{},") takes three.
constexpr std::size_t most_gltf_elements(std::size_t text_bytes) {
  constexpr std::size_t kOfAnyText = std::size_t{1} << 14;
  return std::min(kMaxGltfElements, kOfAnyText + text_bytes / 12);
}
// The most memory of the JSON library for one text: enough for five million numbers, or for 1.7
// million keys, in extras. Not counted are the elements of glTF, which other limits bound, and the
// text of strings.
inline constexpr std::uint64_t kMaxGltfJsonMemory = std::uint64_t{160} << 20;
inline constexpr std::size_t kMaxGltfNodes = std::size_t{1} << 20;
// The limit is lower for a small file. A node takes about 1 KiB: half of it while the JSON is read,
// and half in a compiled scene. Further nodes must therefore bring as much, for example with
// meshes.
constexpr std::size_t most_gltf_nodes(std::uint64_t file_bytes) {
  constexpr std::uint64_t kOfAnyFile = std::uint64_t{1} << 17;
  constexpr std::uint64_t kBytesPerNode = 1024;
  return std::min<std::uint64_t>(kMaxGltfNodes, kOfAnyFile + file_bytes / kBytesPerNode);
}
// A scene or an animation takes about 1 KiB while it is read, and one byte or more in a file.
inline constexpr std::size_t kMaxGltfScenes = std::size_t{1} << 16;
inline constexpr std::size_t kMaxGltfAnimations = std::size_t{1} << 16;
inline constexpr std::size_t kMaxGltfNodeDepth = 1024;  // 1: a root
// Limits of the factor by which a node and its ancestors scale a mesh. Outside these limits,
// products of three lengths, such as volumes, overflow or underflow.
inline constexpr double kMaxGltfScale = 1e100;
inline constexpr double kMinGltfScale = 1e-100;
inline constexpr std::size_t kMaxGltfVertices = std::size_t{1} << 25;  // all meshes of the scene
// Elements of sparse accessors without a buffer view, which take no bytes in the file.
inline constexpr std::size_t kMaxGltfUnstored = std::size_t{1} << 20;
inline constexpr std::size_t kMaxGltfTriangles = std::size_t{1} << 25;  // each mesh counted once
// Triangles of meshes that are equal to others in all that the file says (see also
// kGltfTrianglesPerMesh); further ones are read once. Hand-made scenes with equal meshes have
// fewer.
inline constexpr std::size_t kMaxGltfRepeatedTriangles = std::size_t{1} << 17;
// A mesh is read again for each further pose, and for each mesh that refers to the same accessors,
// so that a small file can describe any number of triangles. The limit of all triangles is
// therefore lower for a file with little mesh data. A triangle takes about 240 bytes in a compiled
// scene: those of any file fit into 256 MiB.
inline constexpr std::uint64_t kGltfTrianglesOfAnyFile = std::uint64_t{1} << 20;
// Triangles of meshes without a skin and morph weights. A real triangle has four bytes of mesh data
// or more, even in a strip of quantised positions.
constexpr std::size_t most_gltf_triangles(std::uint64_t mesh_bytes) {
  return std::min<std::uint64_t>(kMaxGltfTriangles, kGltfTrianglesOfAnyFile + mesh_bytes / 2);
}
// Triangles of meshes with a skin or morph weights, in all poses. A crowd of 100 characters in
// different poses, which share one mesh, has two to four triangles for each byte of the mesh and
// its skin.
constexpr std::size_t most_gltf_posed_triangles(std::uint64_t mesh_bytes) {
  return std::min<std::uint64_t>(kMaxGltfTriangles, kGltfTrianglesOfAnyFile + 4 * mesh_bytes);
}
// A mesh counts as this many triangles in addition to its own: it takes about 12 kB in a compiled
// scene, however few triangles it has.
inline constexpr std::size_t kGltfTrianglesPerMesh = 50;
// A byte of a compressed stream counts as this many bytes of mesh data. Real streams decode to
// about ten times their length.
inline constexpr std::uint64_t kGltfBytesPerCompressedByte = 8;
inline constexpr std::size_t kMaxGltfHapticMaterials = std::size_t{1} << 16;  // per extension
inline constexpr std::uint64_t kMaxGltfImageBytes = std::uint64_t{1} << 29;   // per file or URI
inline constexpr std::uint32_t kMaxGltfImageSide = 8192;                      // width and height
inline constexpr std::uint64_t kMaxGltfPixels = std::uint64_t{1} << 24;       // all images decoded
inline constexpr std::size_t kMaxGltfHapticMaps = 256;                        // per material
// All entries of extras.palpate together: those of used materials, of the scene and of its nodes.
inline constexpr std::size_t kMaxGltfParameters = std::size_t{1} << 16;
// Nodes of the scene with extras.palpate_contour.
inline constexpr std::size_t kMaxGltfContours = std::size_t{1} << 16;
inline constexpr std::size_t kMaxGltfJoints = std::size_t{1} << 18;  // all skins of the scene
// Instances of EXT_mesh_gpu_instancing and nodes with meshes, together. An instance takes about 600
// bytes in a compiled scene, and 12 bytes in a file.
inline constexpr std::size_t kMaxGltfInstances = std::size_t{1} << 17;
// The limit of the work for poses, in counted units. Each pose of a mesh costs 16 units for each
// primitive, 1 for each attribute and weight, 64 for each target, 1 for each vertex of the decoded
// morph targets, and 1 for each value in the sets of joints. The animation that poses the scene
// costs 1 unit for each element of its samplers.
inline constexpr std::size_t kMaxGltfPoseWork = std::size_t{1} << 27;
// Key times that are read to determine the lengths of the animations.
inline constexpr std::size_t kMaxGltfKeyTimes = std::size_t{1} << 24;
// The largest number of decoded bytes for each byte of a Draco stream. The arithmetic coder stores
// repetition in almost no space, so the format itself has no bound. A flat grid is the most regular
// mesh; a million triangles in such a grid decode to less than 500 bytes for each byte.
inline constexpr std::uint64_t kMaxDracoExpansion = 1024;
// The memory of the Draco decoder is limited to kDracoWorkingBytes plus the larger of two amounts:
// kDracoWorkingFactor for each byte that the accessors describe, or kDracoWorkingPerStreamByte for
// each byte of the stream. A triangle needs about 130 bytes in the decoder, and takes one or two
// bytes in a real stream.
inline constexpr std::uint64_t kDracoWorkingBytes = std::uint64_t{1} << 24;
inline constexpr std::uint64_t kDracoWorkingFactor = 16;
inline constexpr std::uint64_t kDracoWorkingPerStreamByte = 128;
// The decoded size of a stream may exceed the size that its accessors describe. The limit of the
// excess is kDracoUndeclaredBytes, plus kDracoUndeclaredFactor for each byte of the stream. Real
// streams decode to about ten times their length.
inline constexpr std::uint64_t kDracoUndeclaredBytes = std::uint64_t{1} << 20;
inline constexpr std::uint64_t kDracoUndeclaredFactor = 32;
inline constexpr std::size_t kMaxGltfExtensionNames = std::size_t{1} << 16;  // per list
inline constexpr std::size_t kMaxGltfWarnings = 100;  // further warnings are only counted

}  // namespace palpate
