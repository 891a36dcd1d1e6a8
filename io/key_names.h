#pragma once

// The names of the keys of extras.palpate, and the search for the key that a misspelt name means.
// The engine states the keys; io only compares names.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// The elements of a file whose extras.palpate may have a key. A key may have several owners.
enum KeyOwner : unsigned { kOfMaterial = 1u, kOfScene = 2u, kOfNode = 4u };

struct KeyName {
  std::string name;  // "staticFriction"
  unsigned owners;   // KeyOwner bits
};

// How a name differs from the key that it means.
enum class KeyLikeness {
  kSame,     // not at all
  kSpelled,  // in capital letters, signs between words, or the order of words
  kNear      // in a few letters
};

struct KeyMatch {
  const KeyName* key;
  KeyLikeness likeness;
};

// The letters and digits of a name, in lower case: "Static_Friction" gives "staticfriction". Bytes
// beyond ASCII are kept.
std::string plain_name(std::string_view name);

// The number of letters to insert, remove, replace or exchange with a neighbour that turn one text
// into the other; most + 1 if it is larger than `most`.
std::size_t letter_distance(std::string_view a, std::string_view b, std::size_t most);

// Immutable, except for the allowance of find(); thread-safe with an allowance per thread.
class KeyNames {
 public:
  explicit KeyNames(std::vector<KeyName> keys);

  // Work that find() may still spend on names that differ in letters, in compared names. It bounds
  // the time that a file with a million names costs.
  using Allowance = std::size_t;
  static constexpr Allowance kAllowance = std::size_t{1} << 16;

  // The key that a name means; no value if no key is near. Keys with one of the owners are
  // preferred at the same likeness. A key of n letters is near a name that differs in at most n / 4
  // letters, and at most 3, or that has a unit at its end. Before these come other words for a key
  // ("kineticFriction"), and names of which the key is the beginning, or the name of the key,
  // beyond the key's first word ("vibrationFreq"). Keys of less than 7 letters are ordinary words
  // and are near none.
  std::optional<KeyMatch> find(std::string_view name, unsigned owners, Allowance& left) const;

  // Why a key of an extras.palpate group is not known, and which key it means: "the key is unknown;
  // the nearest key is stiffness". owner: of the group.
  std::string why_unknown(std::string_view name, KeyOwner owner) const;

  const std::vector<KeyName>& keys() const { return keys_; }

 private:
  struct Compared {
    std::string plain;
    std::string words;       // its words in lower case, sorted
    std::uint64_t letters;   // a bit for each letter or digit that occurs
    std::size_t first_word;  // its letters
  };

  std::vector<KeyName> keys_;
  std::vector<Compared> compared_;  // one for each key
};

// "a material", "the scene", "a node that has the key medium": where keys with these owners belong.
std::string owners_text(unsigned owners);

}  // namespace palpate
