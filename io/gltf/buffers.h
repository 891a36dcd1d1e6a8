#pragma once

// The bytes of the buffers of one glTF asset. Each buffer is loaded at its first access. A buffer
// that nothing uses may therefore be missing.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/gltf/byte_ranges.h"
#include "io/gltf/data_uris.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"
#include "io/gltf/source.h"

namespace palpate {

struct GltfBufferDeclaration {
  std::optional<std::string> uri;
  std::uint64_t byte_length = 0;
};

// Not thread-safe; one per call of read_gltf().
class GltfBuffers {
 public:
  // folder: the folder of the asset, which must contain all external buffers. bin_chunk: the part
  // of the source that is the BIN chunk. source and memory must outlive this object; memory may be
  // null.
  GltfBuffers(std::vector<GltfBufferDeclaration> declarations, const GltfSource& source,
              std::optional<GltfRange> bin_chunk, std::string folder,
              MemoryLedger* memory = nullptr, GltfDataUris data_uris = {});

  // The byteLength bytes of a buffer, from the BIN chunk, a data URI (base64, any media type) or a
  // file; no further bytes of the file are read, and none if the file has fewer. Valid for the
  // lifetime of this object.
  Result<std::span<const std::uint8_t>> bytes(std::size_t buffer);

  // A part of the bytes of a buffer. element: the element that uses the part, for the error if the
  // part exceeds the buffer.
  Result<std::span<const std::uint8_t>> part(std::size_t buffer, std::uint64_t byte_offset,
                                             std::uint64_t byte_length, const std::string& element);

  // Reserves elements from the limit kMaxGltfUnstored. Returns false, and reserves nothing, if
  // fewer are left.
  bool take_unstored(std::size_t elements);

  // Reserves memory for data about to be decoded, in addition to all earlier reservations; an error
  // if the total exceeds the limit. element: the source of the data, for example "/accessors/3".
  std::optional<Error> take_memory(const MemoryNeed& need, const std::string& element);

  // The content of a URI of the asset: a data URI (base64, any media type), or a file of at most
  // max_bytes in the asset's folder. The bytes do not count as buffer bytes. Error::element is
  // empty.
  Result<GltfSource::Part> read_uri(const std::string& uri, std::uint64_t max_bytes);

  // The paths of the files that were read so far, each once, in the order of their first use.
  const std::vector<std::string>& files_read() const { return files_read_; }

  // Counts bytes that are about to be decoded from a buffer, as if they were bytes of a buffer. An
  // error if the total exceeds kMaxGltfBufferBytes. element: for messages.
  std::optional<Error> count_decoded(std::uint64_t bytes, const std::string& element);

  // Notes that meshes, poses or instances use this part of a buffer, which part() has given;
  // compressed: as a compressed stream. Bytes that are noted more than once count once.
  void note_mesh_data(std::size_t buffer, std::uint64_t byte_offset, std::uint64_t byte_length,
                      bool compressed);
  // The number of bytes noted so far, for most_gltf_triangles().
  std::uint64_t mesh_bytes() const { return mesh_bytes_; }

 private:
  struct Buffer {
    GltfBufferDeclaration declaration;
    GltfSource::Part part;
    bool loaded = false;
  };

  Result<GltfSource::Part> load(std::size_t index);
  Result<RegularFile> open_uri(const std::string& uri, std::uint64_t max_bytes);

  std::vector<Buffer> buffers_;
  const GltfSource& source_;
  std::optional<GltfRange> bin_chunk_;
  std::string folder_;
  MemoryLedger* memory_;
  GltfDataUris data_uris_;
  std::uint64_t loaded_bytes_ = 0;
  // The mesh data, by buffer and whether they are compressed.
  std::map<std::pair<std::size_t, bool>, ByteRanges> mesh_data_;
  std::uint64_t mesh_bytes_ = 0;
  std::vector<std::string> files_read_;
  std::size_t unstored_left_ = kMaxGltfUnstored;
};

}  // namespace palpate
