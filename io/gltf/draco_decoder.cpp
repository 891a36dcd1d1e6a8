#include "io/gltf/draco_decoder.h"

#include <algorithm>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <optional>
#include <stdexcept>
#include <utility>

#include "io/gltf/draco_stream.h"
#include "io/gltf/error.h"
#include "io/gltf/limits.h"

namespace palpate {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Decides from the counts read so far whether the decoder may continue, and keeps the reason if
// not. The counts of the stream are used; if the accessors describe less, they are accepted up to a
// limit that depends on the length of the stream.
class Gate {
 public:
  Gate(GltfBuffers& buffers, const DracoDeclared& declared, const DracoLimits& remaining,
       std::size_t stream_bytes, const std::string& element)
      : buffers_(buffers),
        declared_(declared),
        remaining_(remaining),
        stream_bytes_(stream_bytes),
        element_(element) {}

  const std::optional<Error>& error() const { return error_; }

  bool admit(const std::optional<DracoConnectivity>& connectivity) {
    if (!connectivity) return refuse("its stream ends within the connectivity");
    faces_ = connectivity->faces;
    if (faces_ == 0) return refuse("its stream has no triangle");
    if (faces_ > remaining_.triangles)
      return refuse_count(faces_, "triangles", remaining_.triangles);
    // The decoder's memory per triangle: 3 corners in 4 arrays of 4 bytes; 3 corners in 2 arrays
    // for the triangles and the order of decoding; up to 6 symbols of the contexts. For each corner
    // and attribute connectivity: the vertex, the seams and their order.
    constexpr std::uint64_t kPerFace = 4 * 12 + 2 * 12 + 6 * 4;
    constexpr std::uint64_t kPerVertex = 8 * 4;
    constexpr std::uint64_t kPerTableFace = 4 * 12;
    connectivity_bytes_ =
        faces_ * (kPerFace + kPerTableFace * connectivity->attribute_tables) +
        kPerVertex * connectivity->vertices * (1 + connectivity->attribute_tables);
    return admit_bytes(connectivity_bytes_) && admit_memory(connectivity_bytes_);
  }

  // Called when the vertices and the descriptions of the attributes are decoded, but not the
  // values.
  bool admit(const draco::PointCloud& points) {
    const std::uint64_t vertices = points.num_points();
    if (vertices > remaining_.vertices)
      return refuse_count(vertices, "vertices", remaining_.vertices);
    if (!admit_decoded(declared_.bytes_of(vertices, 3 * faces_))) return false;
    std::uint64_t per_point = 0;
    for (int i = 0; i < points.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *points.attribute(i);
      // Per vertex: the values, the integers from which they are computed, and two indices (map and
      // order).
      const auto value = static_cast<std::uint64_t>(draco::DataTypeLength(attribute.data_type()));
      per_point += (value + 4) * static_cast<std::uint8_t>(attribute.num_components()) + 2 * 4;
    }
    return admit_bytes(per_point * vertices) &&
           admit_memory(connectivity_bytes_ + per_point * vertices);
  }

 private:
  bool refuse(std::string problem) {
    error_ = gltf_invalid(element_, std::move(problem), kDracoDamagedHint);
    return false;
  }

  bool refuse_limit(std::string problem) {
    error_ = gltf_error(ErrorCode::kLimitExceeded, element_, std::move(problem));
    return false;
  }

  bool refuse_count(std::uint64_t count, const char* what, std::size_t remaining) {
    return refuse_limit("its stream has " + std::to_string(count) + " " + what + "; at most " +
                        std::to_string(remaining) + " can still be read");
  }

  // Data beyond the size that the accessors describe are counted as decoded data.
  bool admit_decoded(std::uint64_t bytes) {
    if (bytes <= declared_.bytes()) return true;
    const std::uint64_t excess = bytes - declared_.bytes();
    if (excess > kDracoUndeclaredBytes + kDracoUndeclaredFactor * stream_bytes_) {
      return refuse_limit("its stream of " + std::to_string(stream_bytes_) + " bytes decodes to " +
                          std::to_string(bytes) + " bytes, far more than the " +
                          std::to_string(declared_.bytes()) + " bytes that its accessors describe");
    }
    error_ = buffers_.count_decoded(excess, element_);
    return !error_;
  }

  bool admit_bytes(std::uint64_t bytes) {
    const std::uint64_t accounted = std::max(kDracoWorkingFactor * declared_.bytes(),
                                             kDracoWorkingPerStreamByte * stream_bytes_);
    if (bytes <= kDracoWorkingBytes + accounted) return true;
    return refuse("its stream of " + std::to_string(stream_bytes_) + " bytes requires " +
                  std::to_string(bytes) + " bytes of memory, far more than the " +
                  std::to_string(declared_.bytes()) + " bytes that its accessors describe");
  }

  // The decoded data are later copied to vectors, which are counted separately. They need no more
  // memory than the tables of the connectivity, which are freed before.
  bool admit_memory(std::uint64_t bytes) {
    error_ = buffers_.take_memory({0, bytes}, element_);
    return !error_;
  }

  GltfBuffers& buffers_;
  const DracoDeclared& declared_;
  DracoLimits remaining_;
  std::size_t stream_bytes_;
  const std::string& element_;
  std::uint64_t faces_ = 0;
  std::uint64_t connectivity_bytes_ = 0;
  std::optional<Error> error_;
};

// A decoder of the library that calls the gate before each part in which counts determine
// allocations.
template <typename Decoder>
class GatedDecoder : public Decoder {
 public:
  using Peek = std::optional<DracoConnectivity> (*)(draco::DecoderBuffer);

  GatedDecoder(Gate& gate, Peek peek) : gate_(gate), peek_(peek) {}

 protected:
  bool DecodeConnectivity() override {
    return gate_.admit(peek_(*this->buffer())) && Decoder::DecodeConnectivity();
  }
  bool DecodeAllAttributes() override {
    return gate_.admit(*this->point_cloud()) && Decoder::DecodeAllAttributes();
  }

 private:
  Gate& gate_;
  Peek peek_;
};

template <typename Decoder>
bool decode_with(Decoder&& decoder, Bytes bytes, draco::Mesh& mesh) {
  draco::DecoderBuffer stream = draco_buffer(bytes);
  const draco::DecoderOptions options;
  return static_cast<draco::MeshDecoder&>(decoder).Decode(options, &stream, &mesh).ok();
}

}  // namespace

Result<std::shared_ptr<const draco::Mesh>> decode_draco(Bytes bytes, GltfBuffers& buffers,
                                                        const DracoDeclared& declared,
                                                        const DracoLimits& remaining,
                                                        const std::string& element) {
  Gate gate(buffers, declared, remaining, bytes.size(), element);
  const auto stream = check_draco_stream(bytes, element);
  if (!stream) return stream.error();
  const auto mesh = std::make_shared<draco::Mesh>();
  bool decoded = false;
  try {
    using Edgebreaker = GatedDecoder<draco::MeshEdgebreakerDecoder>;
    using Sequential = GatedDecoder<draco::MeshSequentialDecoder>;
    decoded = stream->edgebreaker
                  ? decode_with(Edgebreaker(gate, peek_edgebreaker_draco), stream->bytes, *mesh)
                  : decode_with(Sequential(gate, peek_sequential_draco), stream->bytes, *mesh);
  } catch (const std::length_error&) {
    // A container cannot have the requested size.
  }
  if (gate.error()) return *gate.error();
  if (!decoded) {
    return gltf_invalid(element, "its stream cannot be decoded", kDracoDamagedHint);
  }
  return std::shared_ptr<const draco::Mesh>(mesh);
}

}  // namespace palpate
