#include "io/gltf/meshopt.h"

#include <algorithm>
#include <meshoptimizer.h>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

// EXT first: an asset may have both, and KHR allows newer codecs.
constexpr const char* kExtensionNames[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

enum class Mode { kAttributes, kTriangles, kIndices };
enum class Filter { kNone, kOctahedral, kQuaternion, kExponential };

// One checked extension object.
struct CompressedView {
  std::size_t buffer = 0;
  std::uint64_t byte_offset = 0;
  std::uint64_t byte_length = 0;
  std::uint64_t stride = 0;
  std::uint64_t count = 0;
  Mode mode = Mode::kAttributes;
  Filter filter = Filter::kNone;
};

// The first byte of a stream: the codec in the upper half, its version in the lower.
constexpr unsigned kCodecMask = 0xf0;
struct Codec {
  unsigned first_byte;
  unsigned newest_version;  // supported by the library
};
constexpr Codec codec_of(Mode mode) {
  switch (mode) {
    case Mode::kAttributes:
      return {0xa0, 0};
    case Mode::kTriangles:
      return {0xe0, 1};
    default:
      return {0xd0, 1};
  }
}

// The least number of bytes in which the codec of the mode can encode the view. It bounds the
// allocation for a stream: 64 decoded bytes for each byte of vertices, 12 of triangles, 4 of single
// indices.
std::uint64_t fewest_bytes(const CompressedView& view) {
  constexpr std::uint64_t kHeader = 1;
  switch (view.mode) {
    case Mode::kAttributes: {
      // For each byte of the element, every 16 elements have a code of 2 bits, in whole bytes for
      // each block of at most 256 elements. One element, padded to 32 bytes, follows the last
      // block.
      constexpr std::uint64_t kElementsPerCodeByte = 64;
      constexpr std::uint64_t kSmallestTail = 32;
      const std::uint64_t code_bytes =
          view.count / kElementsPerCodeByte + (view.count % kElementsPerCodeByte != 0 ? 1 : 0);
      return kHeader + view.stride * code_bytes + std::max(view.stride, kSmallestTail);
    }
    case Mode::kTriangles: {
      constexpr std::uint64_t kCodeTable = 16;
      return kHeader + view.count / 3 + kCodeTable;
    }
    default: {
      constexpr std::uint64_t kTail = 4;
      return kHeader + view.count + kTail;
    }
  }
}

// Reads and checks one extension object.
class ViewParser {
 public:
  ViewParser(const Json& object, std::string element, std::size_t buffer_count)
      : object_(object), element_(std::move(element)), buffer_count_(buffer_count) {}

  Result<CompressedView> run() {
    const auto buffer = required_id(object_, element_, "buffer", "/buffers", buffer_count_);
    if (!buffer) return buffer.error();
    view_.buffer = *buffer;
    view_.byte_offset = 0;
    if (object_.contains("byteOffset")) {
      if (auto error = read_whole("byteOffset", view_.byte_offset)) return *error;
    }
    if (auto error = read_whole("byteLength", view_.byte_length)) return *error;
    if (auto error = read_whole("byteStride", view_.stride)) return *error;
    if (auto error = read_whole("count", view_.count)) return *error;
    if (auto error = read_mode()) return *error;
    if (auto error = read_filter()) return *error;
    if (auto error = check_stride()) return *error;
    if (auto error = check_count()) return *error;
    return view_;
  }

 private:
  std::optional<Error> read_whole(const char* name, std::uint64_t& number) const {
    const auto value = object_.find(name);
    if (value == object_.end()) return gltf_invalid(element_ + "/" + name, "is missing");
    const auto whole = whole_number(*value);
    if (!whole || *whole > kMaxGltfWhole) {
      return gltf_expected(element_ + "/" + name, *value,
                           "a whole number from 0 to " + std::to_string(kMaxGltfWhole));
    }
    number = *whole;
    return std::nullopt;
  }

  std::optional<Error> read_mode() {
    constexpr std::pair<const char*, Mode> kModes[] = {{"ATTRIBUTES", Mode::kAttributes},
                                                       {"TRIANGLES", Mode::kTriangles},
                                                       {"INDICES", Mode::kIndices}};
    const auto value = object_.find("mode");
    if (value == object_.end()) return gltf_invalid(element_ + "/mode", "is missing");
    for (const auto& [name, mode] : kModes) {
      if (*value != name) continue;
      view_.mode = mode;
      return std::nullopt;
    }
    return gltf_expected(element_ + "/mode", *value, "ATTRIBUTES, TRIANGLES or INDICES");
  }

  std::optional<Error> read_filter() {
    constexpr std::pair<const char*, Filter> kFilters[] = {{"NONE", Filter::kNone},
                                                           {"OCTAHEDRAL", Filter::kOctahedral},
                                                           {"QUATERNION", Filter::kQuaternion},
                                                           {"EXPONENTIAL", Filter::kExponential}};
    const auto value = object_.find("filter");
    if (value == object_.end()) return std::nullopt;
    const std::string element = element_ + "/filter";
    for (const auto& [name, filter] : kFilters) {
      if (*value != name) continue;
      view_.filter = filter;
      if (filter == Filter::kNone || view_.mode == Mode::kAttributes) return std::nullopt;
      return gltf_expected(element, *value, "NONE, because the mode is not ATTRIBUTES");
    }
    if (*value == "COLOR") {
      return gltf_error(ErrorCode::kUnsupported, element, "is COLOR, which is not supported",
                        "export the colours without a filter");
    }
    return gltf_expected(element, *value, "NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  }

  std::optional<Error> check_stride() const {
    const std::uint64_t stride = view_.stride;
    const auto expect = [&](bool right, const char* expected) -> std::optional<Error> {
      if (right) return std::nullopt;
      return gltf_expected(element_ + "/byteStride", object_["byteStride"], expected);
    };
    if (view_.mode != Mode::kAttributes) {
      return expect(stride == 2 || stride == 4, "2 or 4 for indices");
    }
    if (view_.filter == Filter::kOctahedral) {
      return expect(stride == 4 || stride == 8, "4 or 8 for the filter OCTAHEDRAL");
    }
    if (view_.filter == Filter::kQuaternion) {
      return expect(stride == 8, "8 for the filter QUATERNION");
    }
    return expect(stride >= 4 && stride <= 256 && stride % 4 == 0, "a multiple of 4 from 4 to 256");
  }

  std::optional<Error> check_count() const {
    const std::string element = element_ + "/count";
    if (view_.count == 0) return gltf_invalid(element, "is 0; expected 1 or more");
    if (view_.mode == Mode::kTriangles && view_.count % 3 != 0) {
      return gltf_expected(element, object_["count"], "a multiple of 3 for the mode TRIANGLES");
    }
    // Neither the product nor the sum overflows: the count is at most 2^53, the stride at most 256.
    const std::uint64_t fewest = fewest_bytes(view_);
    if (view_.byte_length < fewest) {
      return gltf_invalid(element, "is " + std::to_string(view_.count) + ", which takes at least " +
                                       std::to_string(fewest) +
                                       " compressed bytes, but byteLength is " +
                                       std::to_string(view_.byte_length));
    }
    return std::nullopt;
  }

  const Json& object_;
  std::string element_;
  std::size_t buffer_count_;
  CompressedView view_;
};

std::optional<Error> check_parent(const Json& parent, const std::string& parent_element,
                                  const CompressedView& view) {
  const std::uint64_t bytes = view.count * view.stride;
  if (whole_number(parent["byteLength"]) != bytes) {
    return gltf_expected(parent_element + "/byteLength", parent["byteLength"],
                         std::to_string(bytes) +
                             ", the count of its compressed data times their "
                             "byteStride");
  }
  if (parent.contains("byteStride") && whole_number(parent["byteStride"]) != view.stride) {
    return gltf_expected(parent_element + "/byteStride", parent["byteStride"],
                         std::to_string(view.stride) + ", the byteStride of its compressed data");
  }
  return std::nullopt;
}

std::optional<Error> check_codec(const CompressedView& view, std::uint8_t first_byte,
                                 const std::string& element) {
  const Codec codec = codec_of(view.mode);
  if ((first_byte & kCodecMask) != codec.first_byte) {
    return gltf_invalid(element, "its data do not begin with the header of its mode",
                        "the data may be damaged");
  }
  const unsigned version = first_byte & ~kCodecMask;
  if (version > codec.newest_version) {
    return gltf_error(ErrorCode::kUnsupported, element,
                      "its data are of codec version " + std::to_string(version) +
                          "; versions up to " + std::to_string(codec.newest_version) +
                          " are supported",
                      "export the asset with EXT_meshopt_compression");
  }
  return std::nullopt;
}

// True if the codec consumed all of the data.
bool decode(const CompressedView& view, std::span<const std::uint8_t> source,
            std::vector<std::uint8_t>& bytes) {
  switch (view.mode) {
    case Mode::kAttributes:
      return meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride, source.data(),
                                        source.size()) == 0;
    case Mode::kTriangles:
      return meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride, source.data(),
                                       source.size()) == 0;
    default:
      return meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride, source.data(),
                                         source.size()) == 0;
  }
}

void apply_filter(const CompressedView& view, std::vector<std::uint8_t>& bytes) {
  switch (view.filter) {
    case Filter::kNone:
      return;
    case Filter::kOctahedral:
      return meshopt_decodeFilterOct(bytes.data(), view.count, view.stride);
    case Filter::kQuaternion:
      return meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride);
    case Filter::kExponential:
      return meshopt_decodeFilterExp(bytes.data(), view.count, view.stride);
  }
}

Result<GltfDecodedView> decode_view(GltfBuffers& buffers, const Json& parent,
                                    const std::string& parent_element, const Json& extension,
                                    const std::string& element, std::size_t buffer_count) {
  const auto view = ViewParser(extension, element, buffer_count).run();
  if (!view) return view.error();
  if (auto error = check_parent(parent, parent_element, *view)) return *error;
  const auto source = buffers.part(view->buffer, view->byte_offset, view->byte_length, element);
  if (!source) return source.error();
  buffers.note_mesh_data(view->buffer, view->byte_offset, view->byte_length, true);
  if (auto error = check_codec(*view, source->front(), element)) return *error;
  if (auto error = buffers.count_decoded(view->count * view->stride, element)) return *error;
  GltfDecodedView decoded{std::vector<std::uint8_t>(view->count * view->stride), view->stride};
  if (!decode(*view, *source, decoded.bytes)) {
    return gltf_invalid(element, "its data cannot be decoded", "the data may be damaged");
  }
  apply_filter(*view, decoded.bytes);
  return decoded;
}

}  // namespace

Result<const GltfDecodedView*> GltfMeshoptViews::decoded(std::size_t view) {
  if (const auto known = decoded_.find(view); known != decoded_.end()) return &known->second;
  const Json& parent = root_["bufferViews"][view];
  const std::string parent_element = gltf_element("bufferViews", view);
  for (const char* name : kExtensionNames) {
    const auto extension = find_extension(parent, parent_element, name);
    if (!extension) return extension.error();
    if (*extension == nullptr) continue;
    auto decoded = decode_view(buffers_, parent, parent_element, **extension,
                               parent_element + "/extensions/" + name, root_["buffers"].size());
    if (!decoded) return decoded.error();
    return &decoded_.emplace(view, std::move(*decoded)).first->second;
  }
  return nullptr;
}

}  // namespace palpate
