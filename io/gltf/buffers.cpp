#include "io/gltf/buffers.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "io/base64.h"
#include "io/gltf/error.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

constexpr std::string_view kDataScheme = "data:";
constexpr std::string_view kBase64Marker = ";base64";
constexpr std::string_view kLfsPointerStart = "version https://git-lfs.github.com/spec/";

// A clone without Git LFS contains pointers in place of large files; a pointer is long enough to be
// mistaken for the buffer of a small mesh.
bool is_lfs_pointer(const FileBytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with(kLfsPointerStart);
}

Result<FileBytes> data_uri_bytes(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(kBase64Marker)) {
    return gltf_invalid(
        {}, "the data URI is not marked as base64; expected data:MEDIA/TYPE;base64,...");
  }
  const auto decoded = base64_decoded(uri.substr(comma + 1));
  if (!decoded) return gltf_invalid({}, "the data URI is not valid base64");
  FileBytes bytes(decoded->size());
  std::copy(decoded->begin(), decoded->end(), bytes.data());
  return bytes;
}

}  // namespace

GltfBuffers::GltfBuffers(std::vector<GltfBufferDeclaration> declarations,
                         std::optional<std::span<const std::uint8_t>> bin_chunk, std::string folder,
                         MemoryLedger* memory)
    : bin_chunk_(bin_chunk), folder_(std::move(folder)), memory_(memory) {
  buffers_.reserve(declarations.size());
  for (auto& declaration : declarations) buffers_.push_back({std::move(declaration), {}, false});
}

Result<std::span<const std::uint8_t>> GltfBuffers::bytes(std::size_t index) {
  const auto source = source_bytes(index);
  if (!source) return source.error();
  const std::uint64_t expected = buffers_[index].declaration.byte_length;
  if (expected == 0) {
    return gltf_invalid(gltf_element("buffers", index, "byteLength"), "is 0; expected 1 or more");
  }
  if (expected > source->size()) {
    return gltf_invalid(gltf_element("buffers", index, "byteLength"),
                        "is " + std::to_string(expected) + ", but its data have " +
                            std::to_string(source->size()) + " bytes",
                        "the data may be truncated");
  }
  return source->first(static_cast<std::size_t>(expected));
}

bool GltfBuffers::take_unstored(std::size_t elements) {
  if (elements > unstored_left_) return false;
  unstored_left_ -= elements;
  return true;
}

std::optional<Error> GltfBuffers::count_decoded(std::uint64_t bytes, const std::string& element) {
  if (bytes > kMaxGltfBufferBytes - std::min(loaded_bytes_, kMaxGltfBufferBytes)) {
    return gltf_error(ErrorCode::kLimitExceeded, element,
                      "brings the buffers to more than " + std::to_string(kMaxGltfBufferBytes) +
                          " bytes, the most that are read");
  }
  if (auto error = take_memory({bytes, bytes}, element)) return error;
  loaded_bytes_ += bytes;
  return std::nullopt;
}

std::optional<Error> GltfBuffers::take_memory(const MemoryNeed& need, const std::string& element) {
  if (memory_ == nullptr) return std::nullopt;
  memory_->begin("decoding the data", element);
  return memory_->take(need);
}

Result<std::span<const std::uint8_t>> GltfBuffers::part(std::size_t index,
                                                        std::uint64_t byte_offset,
                                                        std::uint64_t byte_length,
                                                        const std::string& element) {
  const auto whole = bytes(index);
  if (!whole) return whole.error();
  if (byte_offset > whole->size() || byte_length > whole->size() - byte_offset) {
    return gltf_invalid(element, "its byteOffset " + std::to_string(byte_offset) +
                                     " and byteLength " + std::to_string(byte_length) +
                                     " reach beyond buffer " + std::to_string(index) + " of " +
                                     std::to_string(whole->size()) + " bytes");
  }
  return whole->subspan(byte_offset, byte_length);
}

Result<std::span<const std::uint8_t>> GltfBuffers::source_bytes(std::size_t index) {
  Buffer& buffer = buffers_[index];
  const auto& uri = buffer.declaration.uri;
  if (!uri) {
    if (index == 0 && bin_chunk_) return *bin_chunk_;
    return gltf_invalid(gltf_element("buffers", index),
                        "has no uri and is not the BIN chunk of a GLB (buffer 0): it has no data");
  }
  if (!buffer.loaded) {
    // A data URI may contain more bytes than declared; they are bounded as part of the JSON.
    const std::uint64_t left = kMaxGltfBufferBytes - std::min(loaded_bytes_, kMaxGltfBufferBytes);
    if (buffer.declaration.byte_length > left) {
      return gltf_error(ErrorCode::kLimitExceeded, gltf_element("buffers", index),
                        "brings the buffers to more than " + std::to_string(kMaxGltfBufferBytes) +
                            " bytes, the most that are read");
    }
    const std::uint64_t length = buffer.declaration.byte_length;
    if (auto error = take_memory({length, length}, gltf_element("buffers", index))) return *error;
    auto loaded = read_uri(*uri, kMaxGltfFileBytes, length);
    if (!loaded) {
      Error error = loaded.error();
      error.element = gltf_element("buffers", index, "uri");
      return error;
    }
    loaded_bytes_ += loaded->size();
    buffer.storage = std::move(*loaded);
    buffer.loaded = true;
  }
  return buffer.storage.span();
}

Result<FileBytes> GltfBuffers::read_uri(const std::string& uri, std::uint64_t max_bytes,
                                        std::uint64_t wanted_bytes) {
  if (std::string_view(uri).starts_with(kDataScheme)) return data_uri_bytes(uri);
  const auto file = resolve_inside(folder_, uri);
  if (!file) return file.error();
  // The first line identifies a pointer, so it is read even if fewer bytes are wanted.
  auto bytes = read_regular_file(*file, max_bytes,
                                 std::max<std::uint64_t>(wanted_bytes, kLfsPointerStart.size()));
  if (bytes && is_lfs_pointer(*bytes)) {
    return gltf_error(ErrorCode::kFileUnreadable, {},
                      "the file " + in_quotes(uri) + " is a Git LFS pointer, not the data",
                      "run git lfs pull where the asset came from");
  }
  if (bytes) {
    if (std::find(files_read_.begin(), files_read_.end(), *file) == files_read_.end()) {
      files_read_.push_back(*file);
    }
    return bytes;
  }
  Error error = bytes.error();
  error.problem = "the file " + in_quotes(uri) + " " + error.problem;
  if (error.hint.empty()) error.hint = "put the file beside the asset";
  return error;
}

}  // namespace palpate
