#pragma once

// The largest asset read_gltf() takes. Beyond them it returns ErrorCode::kLimitExceeded. They bound
// the memory and the time that a hostile file can cost; every one of them is checked before the
// allocation it bounds. What an asset costs in memory, at most:
//
//   the file, as it stands            its size                        kMaxGltfFileBytes
//   external buffers and data URIs    what they declare               kMaxGltfBufferBytes
//   compressed data, while decoded    see gltf/draco.h; views stay    the same, counted with them
//   the JSON, parsed                  140 bytes a value               kMaxGltfJsonValues
//   sections of the JSON, in the      2 KiB an element, however       kMaxGltfElements
//   model of tinygltf                 short its text
//   positions, while decoded          2 x 24 bytes a vertex           kMaxGltfVertices
//   texture coordinates, as they are  2 x 24 bytes a vertex and map   kMaxGltfVertices
//   triangles, while decoded          2 x 12 bytes, and the indices   kMaxGltfTriangles
//   zeros that no view holds          as positions or indices         kMaxGltfUnstored
//   a pose, while it is made          120 bytes a vertex              kMaxGltfVertices
//   joints                            250 bytes each                  kMaxGltfJoints
//   instances                         300 bytes each                  kMaxGltfInstances
//   images that are called for        their file, and 6 bytes a       kMaxGltfImageBytes,
//                                     pixel, 16 while decoded         kMaxGltfPixels
//   entries of extras.palpate         400 bytes each, and their text  kMaxGltfParameters
//
// That is what reading costs. Height maps, which the engine makes of images afterwards, have a
// bound of their own: kMostMapTexels (engine/scene/surface_attributes.h).
//
// A real asset costs less than 64 MiB and 40 times the bytes that it refers to, as
// tests/engine/cli/corpus_test.py checks; tests/io/gltf/hostile_gltf_test.cpp checks the same of hostile ones, but for
// elements, zeros and images of one colour, whose text is next to nothing.

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace palpate {

inline constexpr std::uint64_t kMaxGltfFileBytes = std::uint64_t{1} << 30;  // per file
inline constexpr std::uint64_t kMaxGltfBufferBytes = std::uint64_t{1} << 31;
inline constexpr std::uint64_t kMaxGltfJsonBytes = std::uint64_t{1} << 29;  // data URIs included
inline constexpr std::size_t kMaxGltfJsonValues = std::size_t{1} << 24;
inline constexpr std::size_t kMaxGltfJsonDepth = 256;
// Scenes, nodes, meshes, primitives, morph targets, accessors, buffer views and buffers, together.
inline constexpr std::size_t kMaxGltfElements = std::size_t{1} << 20;
// Of a short text there are fewer: one with a meaning takes 12 bytes and more, "{}," three.
constexpr std::size_t most_gltf_elements(std::size_t text_bytes) {
  constexpr std::size_t kOfAnyText = std::size_t{1} << 14;
  return std::min(kMaxGltfElements, kOfAnyText + text_bytes / 12);
}
inline constexpr std::size_t kMaxGltfNodes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxGltfNodeDepth = 1024;  // 1: a root
// By which a node may scale a mesh, with its ancestors. Beyond them products of three lengths, such
// as volumes, overflow or vanish.
inline constexpr double kMaxGltfScale = 1e100;
inline constexpr double kMinGltfScale = 1e-100;
inline constexpr std::size_t kMaxGltfVertices = std::size_t{1} << 25;  // all meshes of the scene
// Elements of sparse accessors without a buffer view, which cost the file nothing.
inline constexpr std::size_t kMaxGltfUnstored = std::size_t{1} << 20;
inline constexpr std::size_t kMaxGltfTriangles = std::size_t{1} << 25;  // each mesh counted once
inline constexpr std::size_t kMaxGltfHapticMaterials = std::size_t{1} << 16;  // per extension
inline constexpr std::uint64_t kMaxGltfImageBytes = std::uint64_t{1} << 29;   // per file or URI
inline constexpr std::uint32_t kMaxGltfImageSide = 8192;                      // width and height
inline constexpr std::uint64_t kMaxGltfPixels = std::uint64_t{1} << 24;       // all images decoded
inline constexpr std::size_t kMaxGltfHapticMaps = 256;                        // per material
// Of extras.palpate: used materials, the scene and its nodes together.
inline constexpr std::size_t kMaxGltfParameters = std::size_t{1} << 16;
inline constexpr std::size_t kMaxGltfJoints = std::size_t{1} << 18;     // all skins of the scene
inline constexpr std::size_t kMaxGltfInstances = std::size_t{1} << 20;  // all nodes of the scene
// For every pose of a mesh: 16 for each primitive, 1 for each attribute, target and weight, and the
// vertices of the morph targets that are decoded, and the numbers of the sets of joints. For the
// animation that poses the scene: the elements of its samplers.
inline constexpr std::size_t kMaxGltfPoseWork = std::size_t{1} << 27;
// Times of keys that are looked at to tell how long animations are.
inline constexpr std::size_t kMaxGltfKeyTimes = std::size_t{1} << 24;
// What a Draco stream may decode to, per byte of it. Its arithmetic coder writes what repeats in
// almost no space, so the format has no bound of its own; a million triangles in a flat grid, the
// most regular mesh there is, come to less than 500.
inline constexpr std::uint64_t kMaxDracoExpansion = 1024;
// Its decoder may use this many bytes, and so many for each that its accessors describe, or for
// each of the stream if that is more. A triangle takes it some 130 bytes and real streams one or
// two.
inline constexpr std::uint64_t kDracoWorkingBytes = std::uint64_t{1} << 24;
inline constexpr std::uint64_t kDracoWorkingFactor = 16;
inline constexpr std::uint64_t kDracoWorkingPerStreamByte = 128;
// What a stream may decode to beyond what its accessors describe: so many bytes, and so many for
// each of it. Real streams decode to some ten times their length.
inline constexpr std::uint64_t kDracoUndeclaredBytes = std::uint64_t{1} << 20;
inline constexpr std::uint64_t kDracoUndeclaredFactor = 32;
inline constexpr std::size_t kMaxGltfExtensionNames = std::size_t{1} << 16;  // per list
inline constexpr std::size_t kMaxGltfWarnings = 100;  // further ones are counted, not listed

}  // namespace palpate
