#include "engine/viewer/connection_places.h"

#include <utility>

namespace palpate {

ConnectionPlaces::Place::Place(Place&& other) noexcept
    : places_(std::exchange(other.places_, nullptr)), number_(other.number_) {}

ConnectionPlaces::Place& ConnectionPlaces::Place::operator=(Place&& other) noexcept {
  if (this == &other) return *this;
  free();
  places_ = std::exchange(other.places_, nullptr);
  number_ = other.number_;
  return *this;
}

void ConnectionPlaces::Place::free() noexcept {
  if (places_ != nullptr) std::exchange(places_, nullptr)->drops_.erase(number_);
}

ConnectionPlaces::Place ConnectionPlaces::take(std::function<void()> drop) {
  while (is_full() && drop_oldest()) {
  }
  drops_.emplace(next_, std::move(drop));
  return Place(*this, next_++);
}

bool ConnectionPlaces::drop_oldest() {
  if (drops_.empty()) return false;
  const auto drop = std::move(drops_.begin()->second);
  drops_.erase(drops_.begin());
  drop();
  return true;
}

}  // namespace palpate
