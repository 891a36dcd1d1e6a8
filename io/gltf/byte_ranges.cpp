#include "io/gltf/byte_ranges.h"

#include <algorithm>
#include <iterator>

namespace palpate {

void ByteRanges::add(std::uint64_t begin, std::uint64_t end) {
  if (begin >= end) return;
  auto next = ends_.upper_bound(begin);
  if (next != ends_.begin() && std::prev(next)->second >= begin) --next;
  // The ranges that the new one touches become a part of it.
  while (next != ends_.end() && next->first <= end) {
    begin = std::min(begin, next->first);
    end = std::max(end, next->second);
    total_ -= next->second - next->first;
    next = ends_.erase(next);
  }
  ends_.emplace_hint(next, begin, end);
  total_ += end - begin;
}

}  // namespace palpate
