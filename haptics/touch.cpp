#include "haptics/touch.h"

#include <array>
#include <compare>
#include <cstddef>
#include <span>

namespace palpate {

// The shares are computed only if they decide something: an edge mostly lies between faces of one
// body and one material.
void TouchState::name_largest(const ContactView& contact, const Vec3& lag_m,
                              TickRecord& record) const noexcept {
  const std::span<const FaceContact> contacts = contact.contacts();
  record.body = record.material = kNothingTouched;
  record.contacts = static_cast<std::uint16_t>(contacts.size());
  if (contacts.empty()) return;

  struct Name {
    std::int32_t body, material;
    auto operator<=>(const Name&) const = default;
  };
  std::array<Name, 3> names;
  bool are_equal = true;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const FaceRef& face = contacts[i].face;
    names[i] = {static_cast<std::int32_t>(face.body), material_of(face)};
    are_equal = are_equal && names[i] == names[0];
  }
  std::size_t largest = 0;
  if (!are_equal) {
    std::array<Vec3, 3> normals;
    for (std::size_t i = 0; i < contacts.size(); ++i) normals[i] = contact.plane_normal(i);
    const auto parts_m = bearing_parts(lag_m, std::span(normals).first(contacts.size()));
    for (std::size_t i = 1; i < contacts.size(); ++i) {
      const bool is_larger = parts_m[i] > parts_m[largest];
      const bool is_equal = parts_m[i] == parts_m[largest];
      if (is_larger || (is_equal && names[i] < names[largest])) largest = i;
    }
  }
  record.body = names[largest].body;
  record.material = names[largest].material;
}

}  // namespace palpate
