#include "io/gltf/draco.h"

#include <algorithm>
#include <cstring>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/limits.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using Bytes = std::span<const std::uint8_t>;

constexpr const char* kExtension = "KHR_draco_mesh_compression";
constexpr std::uint32_t kFirstVarintVersion = DRACO_BITSTREAM_VERSION(2, 0);
constexpr std::uint32_t kVersion22 = DRACO_BITSTREAM_VERSION(2, 2);

constexpr const char* kDamagedHint = "the data may be damaged";

// What the accessors say of the decoded primitive.
struct Declared {
  std::uint64_t vertices = 0;
  std::uint64_t indices = 0;
  bool strip = false;
  std::uint64_t vertex_bytes = 0;  // of one vertex, in all of its accessors together
  std::uint64_t index_bytes = 0;   // of one index

  // No product wraps: a count is at most 2^53 and an element has at most 64 bytes, and all of them
  // together are no more than a buffer may have.
  std::uint64_t bytes() const { return bytes_of(vertices, indices); }
  std::uint64_t bytes_of(std::uint64_t vertex_count, std::uint64_t index_count) const {
    return vertex_count * vertex_bytes + index_count * index_bytes;
  }
  // A strip may stand for the list that is decoded, or be as long as that list.
  bool agrees_in_triangles(std::uint64_t faces) const {
    return strip ? faces + 2 <= indices : 3 * faces == indices;
  }
};

// How much more may be read.
struct Room {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};

// The numbers at the start of the connectivity.
struct Connectivity {
  std::uint32_t faces = 0;
  std::uint32_t vertices = 0;  // with those of split symbols: of the table the decoder makes
  std::uint32_t attribute_tables = 0;  // connectivities of their own, beside that of the positions
};

std::optional<std::uint32_t> number(draco::DecoderBuffer& stream, bool varint) {
  std::uint32_t value = 0;
  const bool read = varint ? draco::DecodeVarint(&value, &stream) : stream.Decode(&value);
  return read ? std::optional(value) : std::nullopt;
}

// Both take a copy of the stream where the connectivity begins, and leave the original there.
std::optional<Connectivity> peek_sequential(draco::DecoderBuffer stream) {
  const bool varint = stream.bitstream_version() >= kVersion22;
  const auto faces = number(stream, varint);
  const auto points = number(stream, varint);
  if (!faces || !points) return std::nullopt;
  return Connectivity{*faces, *points, 0};
}

std::optional<Connectivity> peek_edgebreaker(draco::DecoderBuffer stream) {
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
  return Connectivity{*faces, *vertices + *splits, attribute_tables};
}

// Says whether the decoder may go on, by what it has read so far, and keeps the reason if not. The
// stream's own counts are what counts: where the accessors say less, they are believed as far as a
// stream of this length can be.
class Gate {
 public:
  Gate(GltfBuffers& buffers, const Declared& declared, const Room& room, std::size_t stream_bytes,
       const std::string& element)
      : buffers_(buffers),
        declared_(declared),
        room_(room),
        stream_bytes_(stream_bytes),
        element_(element) {}

  const std::optional<Error>& error() const { return error_; }

  bool admit(const std::optional<Connectivity>& connectivity) {
    if (!connectivity) return refuse("its stream ends or breaks off in the connectivity");
    faces_ = connectivity->faces;
    if (faces_ == 0) return refuse("its stream holds no triangle");
    if (faces_ > room_.triangles) return refuse_count(faces_, "triangles", room_.triangles);
    // What the decoder keeps per triangle: 3 corners in 4 arrays of 4 bytes, the same once more for
    // the triangles and the order of decoding, up to 6 symbols of the contexts. Per corner and
    // connectivity of an attribute: its vertex, its seams and their order.
    constexpr std::uint64_t kPerFace = 4 * 12 + 2 * 12 + 6 * 4;
    constexpr std::uint64_t kPerVertex = 8 * 4;
    constexpr std::uint64_t kPerTableFace = 4 * 12;
    connectivity_bytes_ =
        faces_ * (kPerFace + kPerTableFace * connectivity->attribute_tables) +
        kPerVertex * connectivity->vertices * (1 + connectivity->attribute_tables);
    return admit_bytes(connectivity_bytes_) && admit_memory(connectivity_bytes_);
  }

  // The vertices and the descriptions of the attributes are known, their values are not.
  bool admit(const draco::PointCloud& points) {
    const std::uint64_t vertices = points.num_points();
    if (vertices > room_.vertices) return refuse_count(vertices, "vertices", room_.vertices);
    if (!admit_decoded(declared_.bytes_of(vertices, 3 * faces_))) return false;
    std::uint64_t per_point = 0;
    for (int i = 0; i < points.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *points.attribute(i);
      // Values, the integers they are made from, and two indices: map and order.
      const auto value = static_cast<std::uint64_t>(draco::DataTypeLength(attribute.data_type()));
      per_point += (value + 4) * static_cast<std::uint8_t>(attribute.num_components()) + 2 * 4;
    }
    return admit_bytes(per_point * vertices) &&
           admit_memory(connectivity_bytes_ + per_point * vertices);
  }

 private:
  bool refuse(std::string problem) {
    error_ = gltf_invalid(element_, std::move(problem), kDamagedHint);
    return false;
  }

  bool refuse_limit(std::string problem) {
    error_ = gltf_error(ErrorCode::kLimitExceeded, element_, std::move(problem));
    return false;
  }

  bool refuse_count(std::uint64_t count, const char* what, std::size_t room) {
    return refuse_limit("its stream holds " + std::to_string(count) + " " + what + "; at most " +
                        std::to_string(room) + " can still be read");
  }

  // What the stream holds beyond the word of the accessors counts like any decoded data.
  bool admit_decoded(std::uint64_t bytes) {
    if (bytes <= declared_.bytes()) return true;
    const std::uint64_t excess = bytes - declared_.bytes();
    if (excess > kDracoUndeclaredBytes + kDracoUndeclaredFactor * stream_bytes_) {
      return refuse_limit("its stream of " + std::to_string(stream_bytes_) + " bytes holds " +
                          std::to_string(bytes) + " bytes, its accessors say " +
                          std::to_string(declared_.bytes()) + "; so much more is not decoded");
    }
    error_ = buffers_.count_decoded(excess, element_);
    return !error_;
  }

  bool admit_bytes(std::uint64_t bytes) {
    const std::uint64_t accounted = std::max(kDracoWorkingFactor * declared_.bytes(),
                                             kDracoWorkingPerStreamByte * stream_bytes_);
    if (bytes <= kDracoWorkingBytes + accounted) return true;
    return refuse("its stream of " + std::to_string(stream_bytes_) + " bytes asks for " +
                  std::to_string(bytes) +
                  " bytes of memory, far more than what its accessors describe takes, " +
                  std::to_string(declared_.bytes()));
  }

  // What is decoded is kept in our own form, which is counted by itself: no more than the tables of
  // the connectivity, which are gone by then.
  bool admit_memory(std::uint64_t bytes) {
    error_ = buffers_.take_memory({0, bytes}, element_);
    return !error_;
  }

  GltfBuffers& buffers_;
  const Declared& declared_;
  Room room_;
  std::size_t stream_bytes_;
  const std::string& element_;
  std::uint64_t faces_ = 0;
  std::uint64_t connectivity_bytes_ = 0;
  std::optional<Error> error_;
};

// A decoder of the library that asks the gate before each part that allocates by numbers.
template <typename Decoder>
class GatedDecoder : public Decoder {
 public:
  using Peek = std::optional<Connectivity> (*)(draco::DecoderBuffer);

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

// Steps over metadata: blocks of entries (name, size, value), nested to any depth, one for each
// attribute named and one for all. Nothing of it is kept, as the library would.
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
  // A block, the blocks inside it, each named, and so on: parents stand before their children.
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

draco::DecoderBuffer stream_of(Bytes bytes) {
  draco::DecoderBuffer stream;
  stream.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return stream;
}

// A stream of which the library knows everything but the numbers in it.
struct CheckedStream {
  bool edgebreaker = false;
  Bytes bytes;
  std::vector<std::uint8_t> storage;  // of bytes, where they are not those of the file
};

Result<CheckedStream> check_stream(Bytes bytes, const std::string& element) {
  constexpr std::size_t kFlagsHighByte = 10;
  draco::DecoderBuffer stream = stream_of(bytes);
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&stream, &header).ok()) {
    return gltf_invalid(element, "its data do not begin like a Draco stream");
  }
  if (header.encoder_type != draco::TRIANGULAR_MESH) {
    return gltf_invalid(element, "its stream holds no triangles, but a cloud of points");
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
  CheckedStream checked{header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING, bytes, {}};
  const bool has_metadata =
      version >= DRACO_BITSTREAM_VERSION(1, 3) && (header.flags & METADATA_FLAG_MASK) != 0;
  if (!has_metadata) return checked;
  stream.set_bitstream_version(static_cast<std::uint16_t>(version));
  const auto header_bytes = static_cast<std::size_t>(stream.decoded_size());
  if (!MetadataSkipper(stream).run()) {
    return gltf_invalid(element, "its stream ends in the metadata", kDamagedHint);
  }
  const Bytes rest = bytes.subspan(static_cast<std::size_t>(stream.decoded_size()));
  checked.storage.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header_bytes));
  checked.storage.insert(checked.storage.end(), rest.begin(), rest.end());
  checked.storage[kFlagsHighByte] &= static_cast<std::uint8_t>(~(METADATA_FLAG_MASK >> 8));
  checked.bytes = checked.storage;
  return checked;
}

template <typename Decoder>
bool decode_with(Decoder&& decoder, Bytes bytes, draco::Mesh& mesh) {
  draco::DecoderBuffer stream = stream_of(bytes);
  const draco::DecoderOptions options;
  return static_cast<draco::MeshDecoder&>(decoder).Decode(options, &stream, &mesh).ok();
}

// element: that of the gate
Result<std::shared_ptr<const draco::Mesh>> decode(Bytes bytes, Gate& gate,
                                                  const std::string& element) {
  const auto stream = check_stream(bytes, element);
  if (!stream) return stream.error();
  const auto mesh = std::make_shared<draco::Mesh>();
  bool decoded = false;
  try {
    using Edgebreaker = GatedDecoder<draco::MeshEdgebreakerDecoder>;
    using Sequential = GatedDecoder<draco::MeshSequentialDecoder>;
    decoded = stream->edgebreaker
                  ? decode_with(Edgebreaker(gate, peek_edgebreaker), stream->bytes, *mesh)
                  : decode_with(Sequential(gate, peek_sequential), stream->bytes, *mesh);
  } catch (const std::length_error&) {
    // A container was asked for more than there can be.
  }
  if (gate.error()) return *gate.error();
  if (!decoded) {
    return gltf_invalid(element, "its stream cannot be decoded", kDamagedHint);
  }
  return std::shared_ptr<const draco::Mesh>(mesh);
}

std::size_t component_count(const tinygltf::Accessor& accessor) {
  return static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
}

std::size_t component_bytes(const tinygltf::Accessor& accessor) {
  return static_cast<std::size_t>(
      tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(accessor.componentType)));
}

// The integers of a type, which are the same in Draco and in glTF; nothing for other types.
struct IntegerType {
  std::int64_t lowest = 0;
  std::int64_t highest = 0;
  std::size_t bytes = 0;
};

template <typename Integer>
constexpr IntegerType integers() {
  return {std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max(),
          sizeof(Integer)};
}

std::optional<IntegerType> integer_type(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return integers<std::int8_t>();
    case draco::DT_UINT8:
      return integers<std::uint8_t>();
    case draco::DT_INT16:
      return integers<std::int16_t>();
    case draco::DT_UINT16:
      return integers<std::uint16_t>();
    case draco::DT_INT32:
      return integers<std::int32_t>();
    case draco::DT_UINT32:
      return integers<std::uint32_t>();
    default:
      return std::nullopt;
  }
}

// The first of its bytes is the lowest.
std::int64_t integer_at(const std::uint8_t* bytes, const IntegerType& type) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, bytes, type.bytes);
  const auto value = static_cast<std::int64_t>(bits);
  return value > type.highest ? value - (std::int64_t{1} << (8 * type.bytes)) : value;
}

// Rewrites integers of one type as those of another. False if the other does not have them all.
bool convert_integers(const std::uint8_t* stored, const IntegerType& from, std::size_t count,
                      const IntegerType& to, std::vector<std::uint8_t>& converted) {
  converted.resize(count * to.bytes);
  for (std::size_t c = 0; c < count; ++c) {
    const std::int64_t value = integer_at(stored + c * from.bytes, from);
    if (value < to.lowest || value > to.highest) return false;
    const auto bits = static_cast<std::uint32_t>(value);
    std::memcpy(converted.data() + c * to.bytes, &bits, to.bytes);
  }
  return true;
}

draco::DataType data_type_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return draco::DT_INT8;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return draco::DT_UINT8;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return draco::DT_INT16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return draco::DT_UINT16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return draco::DT_UINT32;
    default:
      return draco::DT_FLOAT32;
  }
}

}  // namespace

std::size_t DracoPrimitive::vertex_count() const {
  return mesh_->num_points();
}

std::vector<std::uint32_t> DracoPrimitive::indices() const {
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * static_cast<std::size_t>(mesh_->num_faces()));
  for (draco::FaceIndex face(0); face < mesh_->num_faces(); ++face) {
    for (const auto& point : mesh_->face(face)) indices.push_back(point.value());
  }
  return indices;
}

Result<DracoAttribute> DracoPrimitive::attribute(const std::string& semantic) const {
  const Source& source = attributes_.at(semantic);
  const std::string element = element_ + "/attributes/" + shortened(semantic);
  const tinygltf::Accessor& accessor = asset_.model.accessors[source.accessor];
  const draco::PointAttribute* stored = mesh_->GetAttributeByUniqueId(source.unique_id);
  if (stored == nullptr) {
    return gltf_invalid(element, "is " + std::to_string(source.unique_id) +
                                     ", but its stream holds no attribute of this id");
  }
  DracoAttribute attribute{component_count(accessor), {}};
  const draco::DataType declared_type = data_type_of(accessor.componentType);
  const auto from = integer_type(stored->data_type());
  const auto to = integer_type(declared_type);
  const bool same_type = stored->data_type() == declared_type;
  if ((!same_type && (!from || !to)) ||
      static_cast<std::size_t>(stored->num_components()) != attribute.components) {
    return gltf_invalid(element, "its stream holds values of another type than " +
                                     gltf_element("accessors", source.accessor) + " declares");
  }
  attribute.values.reserve(attribute.components * vertex_count());
  std::vector<std::uint8_t> converted;
  for (draco::PointIndex point(0); point < mesh_->num_points(); ++point) {
    const draco::AttributeValueIndex index = stored->mapped_index(point);
    if (index.value() >= stored->size()) {
      return gltf_invalid(
          element, "vertex " + std::to_string(point.value()) + " has no value in its stream");
    }
    const std::uint8_t* value = stored->GetAddress(index);
    if (!same_type) {
      if (!convert_integers(value, *from, attribute.components, *to, converted)) {
        return gltf_invalid(element, "its stream holds integers of another type than " +
                                         gltf_element("accessors", source.accessor) +
                                         " declares, and those of vertex " +
                                         std::to_string(point.value()) + " do not fit into that");
      }
      value = converted.data();
    }
    append_components(accessor, value, attribute.values);
  }
  return attribute;
}

Result<std::vector<Vec3>> DracoPrimitive::positions() const {
  const std::size_t accessor = attributes_.at("POSITION").accessor;
  if (auto error = check_position_type(asset_, accessor)) return *error;
  const auto attribute = this->attribute("POSITION");
  if (!attribute) return attribute.error();
  std::vector<Vec3> positions;
  positions.reserve(vertex_count());
  for (std::size_t i = 0; i < vertex_count(); ++i) {
    positions.emplace_back(attribute->values[3 * i], attribute->values[3 * i + 1],
                           attribute->values[3 * i + 2]);
    if (!positions.back().allFinite()) {
      return gltf_invalid(element_, "position " + std::to_string(i) + " is not finite");
    }
  }
  return positions;
}

// Reads the extension of one primitive and decodes what it names.
class DracoReader {
 public:
  DracoReader(const GltfAsset& asset, std::size_t mesh, std::size_t primitive)
      : asset_(asset),
        primitive_(asset.model.meshes[mesh].primitives[primitive]),
        json_(asset.json["meshes"][mesh]["primitives"][primitive]),
        primitive_element_(gltf_element("meshes", mesh, "primitives/" + std::to_string(primitive))),
        element_(primitive_element_ + "/extensions/" + kExtension) {}

  Result<std::optional<DracoPrimitive>> run(const Room& room) {
    const auto extension = find_extension(json_, primitive_element_, kExtension);
    if (!extension) return extension.error();
    if (*extension == nullptr) return std::optional<DracoPrimitive>();
    if (primitive_.mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      return gltf_invalid(primitive_element_ + "/mode",
                          "is 6, but only lists and strips of triangles can be compressed");
    }
    DracoPrimitive result(asset_, element_);
    if (auto error = read_attributes(**extension, result)) return *error;
    if (auto error = declare_indices()) return *error;
    if (auto error = check_limits(room)) return *error;
    const auto view = required_id(**extension, element_, "bufferView", "/bufferViews",
                                  asset_.model.bufferViews.size());
    if (!view) return view.error();
    const auto bytes = view_bytes(asset_, *view);
    if (!bytes) return bytes.error();
    if (auto error = check_expansion(bytes->size())) return *error;
    Gate gate(asset_.buffers, declared_, room, bytes->size(), element_);
    auto mesh = decode(*bytes, gate, element_);
    if (!mesh) return mesh.error();
    if (auto error = check_corners(**mesh)) return *error;
    result.mesh_ = std::move(*mesh);
    warn(result);
    return std::optional(std::move(result));
  }

 private:
  void warn(DracoPrimitive& result) const {
    const draco::Mesh& mesh = *result.mesh_;
    if (mesh.num_points() != declared_.vertices ||
        !declared_.agrees_in_triangles(mesh.num_faces())) {
      result.warnings_.push_back(
          primitive_element_ + ": its compressed stream holds " +
          std::to_string(mesh.num_points()) + " vertices and " + std::to_string(mesh.num_faces()) +
          " triangles, its accessors say " + std::to_string(declared_.vertices) + " vertices and " +
          std::to_string(declared_.indices) + " indices; the stream is read");
    }
    for (const auto& [semantic, source] : result.attributes_) {
      const tinygltf::Accessor& accessor = asset_.model.accessors[source.accessor];
      const draco::PointAttribute* stored = mesh.GetAttributeByUniqueId(source.unique_id);
      if (!accessor.normalized || stored == nullptr || !integer_type(stored->data_type()) ||
          stored->data_type() == data_type_of(accessor.componentType)) {
        continue;
      }
      result.warnings_.push_back(element_ + "/attributes/" + shortened(semantic) +
                                 ": its stream holds integers of another type than accessor " +
                                 std::to_string(source.accessor) +
                                 " declares, which normalises them; they are divided by the " +
                                 "largest of the accessor's type");
    }
  }

  // The library takes the indices of a sequential stream as they come.
  std::optional<Error> check_corners(const draco::Mesh& mesh) const {
    for (draco::FaceIndex face(0); face < mesh.num_faces(); ++face) {
      for (const auto& point : mesh.face(face)) {
        if (point.value() < mesh.num_points()) continue;
        return gltf_invalid(element_, "its stream names vertex " + std::to_string(point.value()) +
                                          " in triangle " + std::to_string(face.value()) +
                                          ", but holds " + std::to_string(mesh.num_points()));
      }
    }
    return std::nullopt;
  }

  std::optional<Error> read_attributes(const Json& extension, DracoPrimitive& result) {
    const std::string element = element_ + "/attributes";
    const auto attributes = extension.find("attributes");
    if (attributes == extension.end()) return gltf_invalid(element, "is missing");
    if (!attributes->is_object() || attributes->empty()) {
      return gltf_expected(element, *attributes, "an object that is not empty");
    }
    for (const auto& [semantic, value] : attributes->items()) {
      const std::string path = element + "/" + shortened(semantic);
      const auto id = whole_number(value);
      if (!id || *id > std::numeric_limits<std::uint32_t>::max()) {
        return gltf_expected(path, value, "the id of an attribute of the stream");
      }
      const auto accessor = primitive_.attributes.find(semantic);
      if (accessor == primitive_.attributes.end()) {
        return gltf_invalid(path, "is no attribute of the primitive");
      }
      const auto accessor_id = static_cast<std::size_t>(accessor->second);
      if (auto error = declare_attribute(accessor_id)) return error;
      result.attributes_[semantic] = {static_cast<std::uint32_t>(*id), accessor_id};
    }
    return std::nullopt;
  }

  std::optional<Error> declare_attribute(std::size_t accessor_id) {
    const tinygltf::Accessor& accessor = asset_.model.accessors[accessor_id];
    const std::string count = gltf_element("accessors", accessor_id, "count");
    if (accessor.count == 0) return gltf_invalid(count, "is 0; expected 1 or more");
    if (declared_.vertices != 0 && declared_.vertices != accessor.count) {
      return gltf_invalid(count, "is " + std::to_string(accessor.count) + ", but that of another " +
                                     "attribute of " + primitive_element_ + " is " +
                                     std::to_string(declared_.vertices));
    }
    declared_.vertices = accessor.count;
    declared_.vertex_bytes += component_count(accessor) * component_bytes(accessor);
    return count_declared(accessor_id);
  }

  std::optional<Error> declare_indices() {
    if (primitive_.indices < 0) {
      return gltf_invalid(primitive_element_ + "/indices",
                          "is missing, but the compressed primitive has indices");
    }
    const auto accessor_id = static_cast<std::size_t>(primitive_.indices);
    if (auto error = check_index_type(asset_, accessor_id)) return error;
    declared_.indices = asset_.model.accessors[accessor_id].count;
    declared_.index_bytes = component_bytes(asset_.model.accessors[accessor_id]);
    declared_.strip = primitive_.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    return count_declared(accessor_id);
  }

  std::optional<Error> count_declared(std::size_t accessor_id) const {
    const tinygltf::Accessor& accessor = asset_.model.accessors[accessor_id];
    if (accessor.sparse.isSparse) {
      return gltf_error(ErrorCode::kUnsupported, gltf_element("accessors", accessor_id, "sparse"),
                        "replaces values of a compressed primitive");
    }
    return asset_.buffers.count_decoded(
        accessor.count * component_count(accessor) * component_bytes(accessor),
        gltf_element("accessors", accessor_id, "count"));
  }

  std::optional<Error> check_limits(const Room& room) const {
    const std::uint64_t triangles = declared_.strip ? declared_.indices : declared_.indices / 3;
    if (declared_.vertices <= room.vertices && triangles <= room.triangles) return std::nullopt;
    return gltf_error(ErrorCode::kLimitExceeded, primitive_element_,
                      "has more vertices or triangles than can still be read, " +
                          std::to_string(room.vertices) + " and " + std::to_string(room.triangles));
  }

  std::optional<Error> check_expansion(std::size_t stream_bytes) const {
    if (declared_.bytes() / kMaxDracoExpansion <= stream_bytes) return std::nullopt;
    return gltf_error(ErrorCode::kLimitExceeded, element_,
                      "its accessors describe " + std::to_string(declared_.bytes()) +
                          " bytes, its stream has " + std::to_string(stream_bytes) + "; at most " +
                          std::to_string(kMaxDracoExpansion) + " times as many are decoded");
  }

  const GltfAsset& asset_;
  const tinygltf::Primitive& primitive_;
  const Json& json_;
  std::string primitive_element_;
  std::string element_;
  Declared declared_;
};

Result<std::optional<DracoPrimitive>> read_draco_primitive(const GltfAsset& asset, std::size_t mesh,
                                                           std::size_t primitive,
                                                           std::size_t max_vertices,
                                                           std::size_t max_triangles) {
  return DracoReader(asset, mesh, primitive).run({max_vertices, max_triangles});
}

}  // namespace palpate
