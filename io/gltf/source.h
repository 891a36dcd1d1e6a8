#pragma once

// The bytes of an asset, in memory or in a file. A file is read in parts, and only the parts that
// are needed.

#include <cstdint>
#include <span>

#include "geometry/base/memory_ledger.h"
#include "geometry/base/result.h"
#include "io/gltf/file.h"

namespace palpate {

struct GltfRange {
  std::uint64_t begin = 0;
  std::uint64_t length = 0;
};

// Not thread-safe; one per call of read_gltf(). What the constructor gets must outlive this object.
class GltfSource {
 public:
  explicit GltfSource(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  // memory: counts the bytes that are read, in its present step.
  GltfSource(const RegularFile& file, MemoryLedger& memory) : file_(&file), memory_(&memory) {}

  std::uint64_t size() const { return file_ != nullptr ? file_->size() : bytes_.size(); }

  // The bytes of a part; `storage` is empty if they are in memory anyway.
  struct Part {
    FileBytes storage;
    std::span<const std::uint8_t> bytes;
  };
  // Requires range.begin + range.length <= size(). An error if the file cannot be read, for
  // example because it has become shorter.
  Result<Part> part(const GltfRange& range) const;
  // Tells the ledger that the memory of a part is free.
  void give_back(const Part& part) const;

 private:
  std::span<const std::uint8_t> bytes_;
  const RegularFile* file_ = nullptr;
  MemoryLedger* memory_ = nullptr;
};

}  // namespace palpate
