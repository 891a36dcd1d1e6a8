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

// The values of one attribute: those of vertex v begin at v * components.
struct DracoAttribute {
  std::size_t components = 0;
  std::vector<double> values;  // normalised integers stand for fractions, as in any accessor
};

// One decoded primitive. All of its attributes come from one decoding and share the order of their
// vertices, which is the codec's. The asset must outlive it. Reading is thread-safe.
class DracoPrimitive {
 public:
  std::size_t vertex_count() const;
  // Three per triangle, each below vertex_count(), whatever the mode of the primitive.
  std::vector<std::uint32_t> indices() const;

  // Whether the stream holds the attribute of this name: "POSITION", "JOINTS_0". The others of the
  // primitive, if any, are not compressed.
  bool has(const std::string& semantic) const { return attributes_.contains(semantic); }
  // An attribute that it has, as its accessor declares it. Integers of the stream may be of another
  // type, narrower or wider, signed or not: each is the same number in the accessor's type, and it
  // is refused if that does not have it. (Exporters let the codec choose a narrower one.) Of other
  // types the decoded one must be that of the accessor.
  Result<DracoAttribute> attribute(const std::string& semantic) const;
  // The attribute POSITION, checked like read_positions() does it. All finite.
  Result<std::vector<Vec3>> positions() const;

  // Where the stream is at odds with its accessors, one line each. The stream is what is read.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  friend class DracoReader;
  struct Source {
    std::uint32_t unique_id = 0;
    std::size_t accessor = 0;
  };

  DracoPrimitive(const GltfAsset& asset, std::string element) : asset_(asset), element_(element) {}

  const GltfAsset& asset_;
  std::string element_;                       // of the extension, for messages
  std::map<std::string, Source> attributes_;  // by semantic
  std::vector<std::string> warnings_;
  std::shared_ptr<const draco::Mesh> mesh_;
};

// Decodes the primitive; nothing if it is not compressed. A version that is not compressed, which
// may lie beside it, is not read.
//
// The stream may hold other numbers of vertices and triangles than its accessors say: it is what is
// read, with a warning. The accessors must agree with each other.
//
// The numbers in the stream, by which the decoder allocates, are read and checked before it does;
// its memory stays in proportion to what the accessors describe or, where the stream holds more, to
// its length (see gltf/limits.h). What remains out of reach are the tables of its entropy coder:
// the library checks that they have no more than 64 symbols for each byte of the stream, and takes
// about 750 bytes for those while it decodes. Not more than max_vertices and max_triangles are
// read, of the stream's own (kLimitExceeded).
Result<std::optional<DracoPrimitive>> read_draco_primitive(const GltfAsset& asset, std::size_t mesh,
                                                           std::size_t primitive,
                                                           std::size_t max_vertices,
                                                           std::size_t max_triangles);

}  // namespace palpate
