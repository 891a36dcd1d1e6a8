#pragma once

#include <optional>

namespace palpate::bench {

// Keeps one value and rebuilds it when the key of get() differs from the key of the last call.
template <typename Key, typename Value>
class LastBuilt {
 public:
  template <typename Build>
  const std::optional<Value>& get(const Key& key, Build build) {
    if (key_ != key) {
      value_.reset();  // first, so that no two large values are in memory together
      value_ = build();
      key_ = key;
    }
    return value_;
  }

 private:
  std::optional<Key> key_;
  std::optional<Value> value_;
};

}  // namespace palpate::bench
