#pragma once

// Grouping of items by a small integer key, in linear time.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace palpate {

// The items of group k are items[first[k]] .. items[first[k + 1] - 1], in increasing order.
struct Buckets {
  std::vector<std::uint32_t> first;
  std::vector<std::uint32_t> items;
};

// Groups the items 0 .. item_count - 1 by key_of(item). Requires every key to be less than
// key_count and item_count < 2^32.
template <typename KeyOf>
Buckets group_by_key(std::size_t item_count, std::size_t key_count, KeyOf key_of) {
  Buckets buckets;
  buckets.first.assign(key_count + 1, 0);
  for (std::size_t i = 0; i < item_count; ++i) ++buckets.first[key_of(i) + 1];
  for (std::size_t k = 0; k < key_count; ++k) buckets.first[k + 1] += buckets.first[k];
  buckets.items.resize(item_count);
  std::vector<std::uint32_t> next(buckets.first.begin(), buckets.first.end() - 1);
  for (std::size_t i = 0; i < item_count; ++i) {
    buckets.items[next[key_of(i)]++] = static_cast<std::uint32_t>(i);
  }
  return buckets;
}

}  // namespace palpate
