#pragma once

#include <optional>

namespace palpate::bench {

// One value, built anew when the key that it is asked for is not that of the last time.
template <typename Key, typename Value>
class LastBuilt {
 public:
  template <typename Build>
  const std::optional<Value>& get(const Key& key, Build build) {
    if (key_ != key) {
      value_.reset();  // first, so that two large ones never share the memory
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
