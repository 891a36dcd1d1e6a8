#pragma once

// An array of fixed size whose elements are not initialised.

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

namespace palpate {

// Unlike the constructor of std::vector, this constructor does not initialise the elements. The
// pages of a large array are therefore written once only, by the thread that fills the array.
template <typename T>
class FixedArray {
 public:
  FixedArray() = default;
  explicit FixedArray(std::size_t size)
      : elements_(std::make_unique_for_overwrite<T[]>(size)), size_(size) {}
  FixedArray(FixedArray&& other) noexcept
      : elements_(std::move(other.elements_)), size_(std::exchange(other.size_, 0)) {}
  FixedArray& operator=(FixedArray&& other) noexcept {
    elements_ = std::move(other.elements_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T* data() { return elements_.get(); }
  const T* data() const { return elements_.get(); }
  T& operator[](std::size_t i) { return elements_[i]; }
  const T& operator[](std::size_t i) const { return elements_[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  std::span<const T> span() const { return {data(), size_}; }

 private:
  std::unique_ptr<T[]> elements_;
  std::size_t size_ = 0;
};

}  // namespace palpate
