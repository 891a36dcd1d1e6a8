#include "io/gltf/buffers.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "io/gltf/error.h"
#include "io/gltf/file.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

constexpr std::string_view kLfsPointerStart = "version https://git-lfs.github.com/spec/";

// A clone without Git LFS contains pointers in place of large files; a pointer is long enough to be
// mistaken for the buffer of a small mesh.
bool is_lfs_pointer(const FileBytes& bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with(kLfsPointerStart);
}

// The error of a file that a URI names.
Error of_file(const std::string& uri, Error error) {
  error.problem = "the file " + in_quotes(uri) + " " + error.problem;
  if (error.hint.empty()) error.hint = "put the file beside the asset";
  return error;
}

Error too_short(std::size_t buffer, std::uint64_t bytes, std::uint64_t expected) {
  return gltf_invalid(
      gltf_element("buffers", buffer, "byteLength"),
      "is " + std::to_string(expected) + ", but its data have " + std::to_string(bytes) + " bytes",
      "the data may be truncated");
}

}  // namespace

GltfBuffers::GltfBuffers(std::vector<GltfBufferDeclaration> declarations, const GltfSource& source,
                         std::optional<GltfRange> bin_chunk, std::string folder,
                         MemoryLedger* memory, GltfDataUris data_uris)
    : source_(source),
      bin_chunk_(bin_chunk),
      folder_(std::move(folder)),
      memory_(memory),
      data_uris_(std::move(data_uris)) {
  buffers_.reserve(declarations.size());
  for (auto& declaration : declarations) buffers_.push_back({std::move(declaration), {}, false});
}

Result<std::span<const std::uint8_t>> GltfBuffers::bytes(std::size_t index) {
  Buffer& buffer = buffers_[index];
  if (!buffer.loaded) {
    auto loaded = load(index);
    if (!loaded) return loaded.error();
    buffer.part = std::move(*loaded);
    buffer.loaded = true;
  }
  const std::uint64_t expected = buffer.declaration.byte_length;
  if (expected == 0) {
    return gltf_invalid(gltf_element("buffers", index, "byteLength"), "is 0; expected 1 or more");
  }
  if (expected > buffer.part.bytes.size())
    return too_short(index, buffer.part.bytes.size(), expected);
  return buffer.part.bytes.first(static_cast<std::size_t>(expected));
}

bool GltfBuffers::take_unstored(std::size_t elements) {
  if (elements > unstored_left_) return false;
  unstored_left_ -= elements;
  return true;
}

void GltfBuffers::note_mesh_data(std::size_t buffer, std::uint64_t byte_offset,
                                 std::uint64_t byte_length, bool compressed) {
  ByteRanges& ranges = mesh_data_[{buffer, compressed}];
  const std::uint64_t before = ranges.total();
  ranges.add(byte_offset, byte_offset + byte_length);
  mesh_bytes_ += (compressed ? kGltfBytesPerCompressedByte : 1) * (ranges.total() - before);
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

Result<GltfSource::Part> GltfBuffers::load(std::size_t index) {
  const GltfBufferDeclaration& declaration = buffers_[index].declaration;
  const std::uint64_t length = declaration.byte_length;
  if (!declaration.uri) {
    if (index != 0 || !bin_chunk_) {
      return gltf_invalid(
          gltf_element("buffers", index),
          "has no uri and is not the BIN chunk of a GLB (buffer 0): it has no data");
    }
    if (length > bin_chunk_->length) return too_short(index, bin_chunk_->length, length);
    return source_.part({bin_chunk_->begin, length});
  }
  // A data URI may contain more bytes than declared; they are bounded as part of the JSON.
  const std::uint64_t left = kMaxGltfBufferBytes - std::min(loaded_bytes_, kMaxGltfBufferBytes);
  if (length > left) {
    return gltf_error(ErrorCode::kLimitExceeded, gltf_element("buffers", index),
                      "brings the buffers to more than " + std::to_string(kMaxGltfBufferBytes) +
                          " bytes, the most that are read");
  }
  const auto of_uri = [&](Error error) {
    error.element = gltf_element("buffers", index, "uri");
    return error;
  };
  std::optional<RegularFile> file;
  if (!GltfDataUris::is_data_uri(*declaration.uri)) {
    auto opened = open_uri(*declaration.uri, kMaxGltfFileBytes);
    if (!opened) return of_uri(opened.error());
    file = std::move(*opened);
    if (length > file->size()) return too_short(index, file->size(), length);
  }
  if (!data_uris_.is_in_text(*declaration.uri)) {
    if (auto error = take_memory({length, length}, gltf_element("buffers", index))) return *error;
  }
  if (!file) {
    auto decoded = data_uris_.bytes(*declaration.uri);
    if (!decoded) return of_uri(decoded.error());
    loaded_bytes_ += decoded->bytes.size();
    return decoded;
  }
  auto loaded = file->read(0, length);
  if (!loaded) return of_uri(of_file(*declaration.uri, loaded.error()));
  loaded_bytes_ += loaded->size();
  GltfSource::Part part{std::move(*loaded), {}};
  part.bytes = part.storage.span();
  return part;
}

// Opens the file that a URI names, and notes that it is read.
Result<RegularFile> GltfBuffers::open_uri(const std::string& uri, std::uint64_t max_bytes) {
  const auto path = resolve_inside(folder_, uri);
  if (!path) return path.error();
  auto file = RegularFile::open(*path);
  if (!file) return of_file(uri, file.error());
  if (auto error = file->check_size(max_bytes)) return of_file(uri, *error);
  const auto start = file->read(0, std::min<std::uint64_t>(file->size(), kLfsPointerStart.size()));
  if (!start) return of_file(uri, start.error());
  if (is_lfs_pointer(*start)) {
    return gltf_error(ErrorCode::kFileUnreadable, {},
                      "the file " + in_quotes(uri) + " is a Git LFS pointer, not the data",
                      "run git lfs pull where the asset came from");
  }
  if (std::find(files_read_.begin(), files_read_.end(), *path) == files_read_.end()) {
    files_read_.push_back(*path);
  }
  return file;
}

Result<GltfSource::Part> GltfBuffers::read_uri(const std::string& uri, std::uint64_t max_bytes) {
  if (GltfDataUris::is_data_uri(uri)) return data_uris_.bytes(uri);
  const auto file = open_uri(uri, max_bytes);
  if (!file) return file.error();
  auto bytes = file->read(0, file->size());
  if (!bytes) return of_file(uri, bytes.error());
  GltfSource::Part part{std::move(*bytes), {}};
  part.bytes = part.storage.span();
  return part;
}

}  // namespace palpate
