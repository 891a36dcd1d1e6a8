#pragma once

// The bytes of the buffers of one glTF asset, loaded when first asked for: a buffer that no
// geometry uses may be missing.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"

namespace palpate {

struct GltfBufferDeclaration {
  std::optional<std::string> uri;
  std::uint64_t byte_length = 0;
};

// Not thread-safe; one per call of read_gltf().
class GltfBuffers {
 public:
  // folder: that of the asset, which external buffers must not leave. bin_chunk must outlive this,
  // and so must memory, if there is one.
  GltfBuffers(std::vector<GltfBufferDeclaration> declarations,
              std::optional<std::span<const std::uint8_t>> bin_chunk, std::string folder,
              MemoryLedger* memory = nullptr);

  // Exactly byteLength bytes, from the BIN chunk, a data URI (base64, any media type) or a file, of
  // which no more is read. Valid while this lives.
  Result<std::span<const std::uint8_t>> bytes(std::size_t buffer);

  // A part of them. element: what asks for it, for the message when it reaches beyond.
  Result<std::span<const std::uint8_t>> part(std::size_t buffer, std::uint64_t byte_offset,
                                             std::uint64_t byte_length, const std::string& element);

  // Takes from kMaxGltfUnstored; false, and nothing is taken, if fewer are left.
  bool take_unstored(std::size_t elements);

  // Counts what is about to be decoded, beside all that has been: the error if that is more than
  // may be taken. element: what it is made of, "/accessors/3".
  std::optional<Error> take_memory(const MemoryNeed& need, const std::string& element);

  // What a URI of the asset holds, a data URI (base64, any media type) or a file in its folder of
  // at most max_bytes, or its beginning if no more than wanted_bytes are called for. Not counted.
  // Error::element is empty.
  Result<FileBytes> read_uri(
      const std::string& uri, std::uint64_t max_bytes,
      std::uint64_t wanted_bytes = std::numeric_limits<std::uint64_t>::max()) const;

  // Counts bytes that are about to be decoded from a buffer like those of a buffer of their own:
  // the error if that makes more than kMaxGltfBufferBytes. element: for messages.
  std::optional<Error> count_decoded(std::uint64_t bytes, const std::string& element);

 private:
  struct Buffer {
    GltfBufferDeclaration declaration;
    FileBytes storage;
    bool loaded = false;
  };

  Result<std::span<const std::uint8_t>> source_bytes(std::size_t index);

  std::vector<Buffer> buffers_;
  std::optional<std::span<const std::uint8_t>> bin_chunk_;
  std::string folder_;
  MemoryLedger* memory_;
  std::uint64_t loaded_bytes_ = 0;
  std::size_t unstored_left_ = kMaxGltfUnstored;
};

}  // namespace palpate
