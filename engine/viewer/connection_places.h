#pragma once

// How many connections of one kind the server holds.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>

namespace palpate {

// The connections of one kind, of which there are at most so many: for a new one, the oldest is
// dropped. A newcomer is therefore never refused, and has the time in which as many others come
// after it. Not thread-safe.
class ConnectionPlaces {
 public:
  // A place, which is free again when this object ends. The ConnectionPlaces must outlive it.
  class Place {
   public:
    Place() = default;
    ~Place() { free(); }
    Place(Place&& other) noexcept;
    Place& operator=(Place&& other) noexcept;
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    friend class ConnectionPlaces;
    Place(ConnectionPlaces& places, std::uint64_t number) : places_(&places), number_(number) {}
    void free() noexcept;

    ConnectionPlaces* places_ = nullptr;
    std::uint64_t number_ = 0;
  };

  explicit ConnectionPlaces(std::size_t most) : most_(most) {}

  void set_most(std::size_t most) { most_ = most; }
  // drop: closes the connection at once; called once at most, and not after the place is free.
  Place take(std::function<void()> drop);
  // Returns false if there is none.
  bool drop_oldest();
  std::size_t size() const { return drops_.size(); }
  bool is_full() const { return drops_.size() >= most_; }

 private:
  std::size_t most_;
  std::uint64_t next_ = 0;
  std::map<std::uint64_t, std::function<void()>> drops_;  // by age
};

}  // namespace palpate
