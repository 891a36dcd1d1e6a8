#include "io/gltf/source.h"

namespace palpate {

Result<GltfSource::Part> GltfSource::part(const GltfRange& range) const {
  if (file_ == nullptr) return Part{{}, bytes_.subspan(range.begin, range.length)};
  if (auto error = memory_->take(range.length)) return *error;
  auto storage = file_->read(range.begin, range.length);
  if (!storage) return storage.error();
  Part part{std::move(*storage), {}};
  part.bytes = part.storage.span();
  return part;
}

void GltfSource::give_back(const Part& part) const {
  if (memory_ != nullptr) memory_->give_back(part.storage.size());
}

}  // namespace palpate
