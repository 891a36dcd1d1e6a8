#include "io/key_names.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "io/ascii.h"

namespace palpate {
namespace {

// Longer names are near no key, and are not compared.
constexpr std::size_t kLongestCompared = 40;
constexpr std::size_t kShortestNear = 7;
constexpr std::size_t kLettersPerError = 4;
constexpr std::size_t kMostErrors = 3;

bool is_beyond_ascii(char c) {
  return (static_cast<unsigned char>(c) & 0x80u) != 0;
}
bool is_sign(char c) {
  return !is_upper(c) && !is_lower(c) && !is_digit(c) && !is_beyond_ascii(c);
}

// "staticFriction", "friction.static" and "Friction Static" all give "friction static ".
std::string sorted_words(std::string_view name) {
  std::vector<std::string> words(1);
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    const bool begins_word = i > 0 && is_upper(c) && !is_upper(name[i - 1]);
    if ((is_sign(c) || begins_word) && !words.back().empty()) words.emplace_back();
    if (!is_sign(c)) words.back() += lower(c);
  }
  std::sort(words.begin(), words.end());
  std::string text;
  for (const std::string& word : words) text += word.empty() ? "" : word + " ";
  return text;
}

// One bit for each letter and digit, and one for everything else.
std::uint64_t letters_of(std::string_view plain) {
  std::uint64_t letters = 0;
  for (const char c : plain) {
    const int bit = is_lower(c) ? c - 'a' : is_digit(c) ? 26 + (c - '0') : 36;
    letters |= std::uint64_t{1} << bit;
  }
  return letters;
}

// The name without the units at its end: "stiffness_N_per_m" and "Stiffness (N/m)" give the word.
std::string_view without_units(std::string_view name) {
  constexpr std::string_view kUnits[] = {"n",  "m", "mm", "cm", "per", "s",
                                         "ms", "g", "kg", "hz", "deg", "rad"};
  while (true) {
    while (!name.empty() && is_sign(name.back())) name.remove_suffix(1);
    std::size_t begin = name.size();
    while (begin > 0 && !is_sign(name[begin - 1])) --begin;
    const std::string word = plain_name(name.substr(begin));
    if (begin == 0 || std::find(std::begin(kUnits), std::end(kUnits), word) == std::end(kUnits)) {
      return name;
    }
    name = name.substr(0, begin);
  }
}

// Other words for a key, and the key, in plain letters.
constexpr std::pair<std::string_view, std::string_view> kSynonyms[] = {
    {"kineticfriction", "dynamicfriction"},
    {"slidingfriction", "dynamicfriction"},
    {"dampening", "damping"},
    {"springconstant", "stiffness"},
    {"springstiffness", "stiffness"},
};

std::string_view synonym_of(std::string_view plain) {
  for (const auto& [word, key] : kSynonyms) {
    if (word == plain) return key;
  }
  return {};
}

// Whether one of the names begins with the other, and they share more than the key's first word:
// "vibrationFreq" and "dynamicFrictionMax" are meant for keys, "static" and "stiffness_map" may be
// anything. first_word: the number of letters of the key's first word; all of them if it has one.
bool is_abbreviation(std::string_view key, std::size_t first_word, std::string_view plain) {
  constexpr std::size_t kLeastShared = 5;
  const std::size_t shared = std::min(key.size(), plain.size());
  return shared >= kLeastShared && shared > first_word &&
         key.substr(0, shared) == plain.substr(0, shared);
}

std::size_t letters_of_first_word(std::string_view name) {
  return static_cast<std::size_t>(std::find_if(name.begin(), name.end(), is_upper) - name.begin());
}

std::size_t most_errors(std::size_t letters) {
  return letters < kShortestNear ? 0 : std::min(kMostErrors, letters / kLettersPerError);
}

}  // namespace

std::string plain_name(std::string_view name) {
  std::string plain;
  plain.reserve(name.size());
  for (const char c : name) {
    if (!is_sign(c)) plain += lower(c);
  }
  return plain;
}

// Optimal string alignment, in three rows of the table.
std::size_t letter_distance(std::string_view a, std::string_view b, std::size_t most) {
  const std::size_t difference = a.size() > b.size() ? a.size() - b.size() : b.size() - a.size();
  if (difference > most) return most + 1;
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), next(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({last[j] + 1, next[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        next[j] = std::min(next[j], before[j - 2] + 1);
      }
    }
    before.swap(last);
    last.swap(next);
  }
  return std::min(last[b.size()], most + 1);
}

KeyNames::KeyNames(std::vector<KeyName> keys) : keys_(std::move(keys)) {
  for (const KeyName& key : keys_) {
    const std::string plain = plain_name(key.name);
    compared_.push_back(
        {plain, sorted_words(key.name), letters_of(plain), letters_of_first_word(key.name)});
  }
}

std::optional<KeyMatch> KeyNames::find(std::string_view name, unsigned owners,
                                       Allowance& left) const {
  if (name.size() > 2 * kLongestCompared) return std::nullopt;
  const std::string plain = plain_name(name);
  if (plain.empty() || plain.size() > kLongestCompared) return std::nullopt;
  const std::uint64_t letters = letters_of(plain);
  // The best match has the least rank: likeness, errors, whether it has another owner.
  using Rank = std::array<std::size_t, 3>;
  std::optional<std::pair<Rank, KeyMatch>> best;
  const auto offer = [&](const KeyName& key, KeyLikeness likeness, std::size_t errors) {
    const Rank rank{static_cast<std::size_t>(likeness), errors, (key.owners & owners) ? 0u : 1u};
    if (!best || rank < best->first) best = {rank, {&key, likeness}};
  };
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Compared& key = compared_[i];
    if (key.letters != letters) continue;
    if (keys_[i].name == name) {
      offer(keys_[i], KeyLikeness::kSame, 0);
    } else if (key.plain == plain || key.words == sorted_words(name)) {
      offer(keys_[i], KeyLikeness::kSpelled, 0);
    }
  }
  if (best) return best->second;
  const std::string_view synonym = synonym_of(plain);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::string& key = compared_[i].plain;
    if (key == synonym) offer(keys_[i], KeyLikeness::kNear, 0);
    if (!is_abbreviation(key, compared_[i].first_word, plain)) continue;
    offer(keys_[i], KeyLikeness::kNear,
          std::max(key.size(), plain.size()) - std::min(key.size(), plain.size()));
  }
  if (best) return best->second;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const Compared& key = compared_[i];
    const std::size_t most = most_errors(key.plain.size());
    // An error changes the set of letters by at most two.
    const auto differing = static_cast<std::size_t>(__builtin_popcountll(key.letters ^ letters));
    if (most == 0 || differing > 2 * most || left == 0) continue;
    --left;
    const std::size_t errors = letter_distance(key.plain, plain, most);
    if (errors <= most) offer(keys_[i], KeyLikeness::kNear, errors);
  }
  if (best) return best->second;
  const std::string_view bare = without_units(name);
  if (bare.size() == name.size()) return std::nullopt;
  auto match = find(bare, owners, left);
  if (match) match->likeness = KeyLikeness::kNear;
  return match;
}

std::string KeyNames::why_unknown(std::string_view name, KeyOwner owner) const {
  constexpr std::string_view kUnknown = "the key is unknown";
  constexpr std::size_t kShortestPart = 4;
  Allowance left = kAllowance;
  if (const auto match = find(name, owner, left)) {
    std::string why(kUnknown);
    if (match->likeness != KeyLikeness::kSame) why += "; the nearest key is " + match->key->name;
    if (match->key->owners & owner) return why;
    return why + (match->likeness == KeyLikeness::kSame ? " here; it" : ", which") +
           " belongs to extras.palpate of " + owners_text(match->key->owners);
  }
  std::string similar;
  const std::string plain = plain_name(name);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::string& key = compared_[i].plain;
    if (!(keys_[i].owners & owner) || plain.size() < kShortestPart) continue;
    if (key.find(plain) == key.npos && plain.find(key) == plain.npos) continue;
    similar += (similar.empty() ? "" : " or ") + keys_[i].name;
  }
  return std::string(kUnknown) + (similar.empty() ? "" : "; similar: " + similar);
}

std::string owners_text(unsigned owners) {
  std::string text;
  const auto add = [&](unsigned owner, const char* name) {
    if (owners & owner) text += (text.empty() ? "" : " or of ") + std::string(name);
  };
  add(kOfMaterial, "a material");
  add(kOfScene, "the scene");
  add(kOfNode, "a node that has the key medium");
  return text;
}

}  // namespace palpate
