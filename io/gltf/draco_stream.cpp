#include "io/gltf/draco_stream.h"

#include <cstddef>
#include <draco/compression/config/compression_shared.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <limits>

#include "io/gltf/error.h"

namespace palpate {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kFirstVarintVersion = DRACO_BITSTREAM_VERSION(2, 0);
constexpr std::uint32_t kVersion22 = DRACO_BITSTREAM_VERSION(2, 2);

std::optional<std::uint32_t> number(draco::DecoderBuffer& stream, bool varint) {
  std::uint32_t value = 0;
  const bool read = varint ? draco::DecodeVarint(&value, &stream) : stream.Decode(&value);
  return read ? std::optional(value) : std::nullopt;
}

// Skips metadata: blocks of entries (name, size, value), nested to any depth, one for each named
// attribute and one for the whole stream. Unlike the library, it stores none of them.
class MetadataSkipper {
 public:
  explicit MetadataSkipper(draco::DecoderBuffer& stream) : stream_(stream) {}

  bool run() {
    const auto attributes = number(stream_, true);
    if (!attributes) return false;
    for (std::uint32_t i = 0; i < *attributes; ++i) {
      if (!number(stream_, true) || !skip_tree()) return false;
    }
    return skip_tree();
  }

 private:
  // Skips a block and the named blocks inside it, recursively; parents precede their children.
  bool skip_tree() {
    std::uint64_t pending = 1;
    for (bool named = false; pending > 0; named = true, --pending) {
      if (named && !skip_name()) return false;
      const auto entries = number(stream_, true);
      if (!entries) return false;
      for (std::uint32_t i = 0; i < *entries; ++i) {
        if (!skip_name()) return false;
        const auto size = number(stream_, true);
        if (!size || !skip(*size)) return false;
      }
      const auto children = number(stream_, true);
      if (!children) return false;
      pending += *children;
    }
    return true;
  }

  bool skip_name() {
    std::uint8_t length = 0;
    return stream_.Decode(&length) && skip(length);
  }

  bool skip(std::int64_t bytes) {
    if (bytes > stream_.remaining_size()) return false;
    stream_.Advance(bytes);
    return true;
  }

  draco::DecoderBuffer& stream_;
};

}  // namespace

draco::DecoderBuffer draco_buffer(Bytes bytes) {
  draco::DecoderBuffer stream;
  stream.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return stream;
}

Result<CheckedDracoStream> check_draco_stream(Bytes bytes, const std::string& element) {
  constexpr std::size_t kFlagsHighByte = 10;
  draco::DecoderBuffer stream = draco_buffer(bytes);
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&stream, &header).ok()) {
    return gltf_invalid(element, "its data do not begin with a Draco header");
  }
  if (header.encoder_type != draco::TRIANGULAR_MESH) {
    return gltf_invalid(element, "its stream contains a point cloud, not triangles");
  }
  const auto version = DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor);
  if (header.version_major < 1 || version > draco::kDracoMeshBitstreamVersion ||
      header.encoder_method > draco::MESH_EDGEBREAKER_ENCODING) {
    return gltf_error(ErrorCode::kUnsupported, element,
                      "its stream is of Draco bitstream version " +
                          std::to_string(header.version_major) + "." +
                          std::to_string(header.version_minor) + ", method " +
                          std::to_string(header.encoder_method) +
                          "; versions 1.0 to 2.2 and methods 0 and 1 are supported");
  }
  CheckedDracoStream checked{header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING, bytes, {}};
  const bool has_metadata =
      version >= DRACO_BITSTREAM_VERSION(1, 3) && (header.flags & METADATA_FLAG_MASK) != 0;
  if (!has_metadata) return checked;
  stream.set_bitstream_version(static_cast<std::uint16_t>(version));
  const auto header_bytes = static_cast<std::size_t>(stream.decoded_size());
  if (!MetadataSkipper(stream).run()) {
    return gltf_invalid(element, "its stream ends in the metadata", kDracoDamagedHint);
  }
  const Bytes rest = bytes.subspan(static_cast<std::size_t>(stream.decoded_size()));
  checked.storage.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header_bytes));
  checked.storage.insert(checked.storage.end(), rest.begin(), rest.end());
  checked.storage[kFlagsHighByte] &= static_cast<std::uint8_t>(~(METADATA_FLAG_MASK >> 8));
  checked.bytes = checked.storage;
  return checked;
}

std::optional<DracoConnectivity> peek_sequential_draco(draco::DecoderBuffer stream) {
  const bool varint = stream.bitstream_version() >= kVersion22;
  const auto faces = number(stream, varint);
  const auto points = number(stream, varint);
  if (!faces || !points) return std::nullopt;
  return DracoConnectivity{*faces, *points, 0};
}

std::optional<DracoConnectivity> peek_edgebreaker_draco(draco::DecoderBuffer stream) {
  const bool varint = stream.bitstream_version() >= kFirstVarintVersion;
  if (stream.bitstream_version() < kVersion22 && !number(stream, varint)) return std::nullopt;
  const auto vertices = number(stream, varint);
  const auto faces = number(stream, varint);
  std::uint8_t attribute_tables = 0;
  if (!vertices || !faces || !stream.Decode(&attribute_tables)) return std::nullopt;
  const auto symbols = number(stream, varint);
  const auto splits = number(stream, varint);
  if (!symbols || !splits || *symbols > *faces || *splits > *symbols) return std::nullopt;
  if (*vertices > std::numeric_limits<std::uint32_t>::max() - *splits) return std::nullopt;
  return DracoConnectivity{*faces, *vertices + *splits, attribute_tables};
}

}  // namespace palpate
