#pragma once

// Primitives compressed by KHR_draco_mesh_compression.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"
#include "io/gltf/accessor.h"

namespace draco {
class Mesh;
}

namespace palpate {

// The values of one attribute; the values of vertex v begin at v * components.
struct DracoAttribute {
  std::size_t components = 0;
  std::vector<double> values;  // normalised integers are converted to fractions
};

// One decoded primitive. All of its attributes come from one decoding and share the codec's order
// of vertices. The asset must outlive this object. Reading is thread-safe.
class DracoPrimitive {
 public:
  std::size_t vertex_count() const;
  // Three indices per triangle, each below vertex_count(), whatever the mode of the primitive.
  std::vector<std::uint32_t> indices() const;

  // Whether the stream contains the attribute of this name, for example "POSITION" or "JOINTS_0".
  // Other attributes of the primitive are not compressed.
  bool has(const std::string& semantic) const { return attributes_.contains(semantic); }
  // The values of an attribute of the stream, in the type that its accessor declares. An integer
  // type in the stream may differ from the accessor's, because exporters let the codec choose a
  // narrower type. Each integer is converted to the accessor's type; an integer out of the range of
  // that type is an error. Any other decoded type must equal the accessor's type.
  Result<DracoAttribute> attribute(const std::string& semantic) const;
  // The attribute POSITION, with the checks of read_positions(). All values are finite.
  Result<std::vector<Vec3>> positions() const;

  // The contradictions between the stream and its accessors, one line each. In each case, the
  // values of the stream are used.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  friend class DracoReader;
  struct Source {
    std::uint32_t unique_id = 0;
    std::size_t accessor = 0;
  };

  DracoPrimitive(const GltfAsset& asset, std::string element) : asset_(asset), element_(element) {}

  const GltfAsset& asset_;
  std::string element_;                       // JSON path of the extension, for messages
  std::map<std::string, Source> attributes_;  // one source per semantic
  std::vector<std::string> warnings_;
  std::shared_ptr<const draco::Mesh> mesh_;
};

// Decodes the primitive; no value if the primitive is not compressed. An uncompressed fallback of
// the primitive is not read.
//
// If the numbers of vertices and triangles in the stream differ from those of its accessors, the
// numbers of the stream are used, with a warning. The accessors must agree with each other.
//
// The counts in the stream that determine the decoder's allocations are checked beforehand. The
// decoder's memory is proportional to the data that the accessors describe or, if the stream
// contains more, to the length of the stream (see gltf/limits.h). The tables of the entropy coder
// cannot be checked here. For each byte of the stream, the library limits these tables to 64
// symbols, which take about 750 bytes during decoding. A stream with more than max_vertices or
// max_triangles is an error (kLimitExceeded).
Result<std::optional<DracoPrimitive>> read_draco_primitive(const GltfAsset& asset, std::size_t mesh,
                                                           std::size_t primitive,
                                                           std::size_t max_vertices,
                                                           std::size_t max_triangles);

}  // namespace palpate
