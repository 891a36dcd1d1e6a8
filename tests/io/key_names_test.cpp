// Tests the search for the key that a misspelt name means.

#include "io/key_names.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/helpers/random.h"

namespace palpate {
namespace {

KeyNames names_for_test() {
  return KeyNames({{"stiffness", kOfMaterial},
                   {"staticFriction", kOfMaterial},
                   {"dynamicFriction", kOfMaterial},
                   {"solid", kOfMaterial},
                   {"viscosity", kOfMaterial | kOfNode},
                   {"radius", kOfNode},
                   {"damping", kOfMaterial},
                   {"vibrationWhen", kOfMaterial},
                   {"vibrationFrequency", kOfMaterial},
                   {"gravity", kOfScene}});
}

// The definition, without a table: the first letters are equal, or one edit is spent on them.
std::size_t distance_by_definition(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return a.size() + b.size();
  std::size_t least = distance_by_definition(a.substr(1), b.substr(1)) + (a[0] == b[0] ? 0 : 1);
  least = std::min(least, distance_by_definition(a.substr(1), b) + 1);
  least = std::min(least, distance_by_definition(a, b.substr(1)) + 1);
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0]) {
    least = std::min(least, distance_by_definition(a.substr(2), b.substr(2)) + 1);
  }
  return least;
}

TEST(KeyNames, DistanceIsTheLeastNumberOfEdits) {
  test::Random random(461);
  const auto word = [&] {
    std::string text;
    const std::uint64_t length = random.index(7);
    for (std::uint64_t i = 0; i < length; ++i) text += "abc"[random.index(3)];
    return text;
  };
  for (int n = 0; n < 500; ++n) {
    const std::string a = word();
    const std::string b = word();
    const std::size_t distance = distance_by_definition(a, b);
    EXPECT_EQ(letter_distance(a, b, 6), std::min<std::size_t>(distance, 7)) << a << " " << b;
    EXPECT_EQ(letter_distance(a, b, 1), std::min<std::size_t>(distance, 2)) << a << " " << b;
  }
}

std::string found(const std::string& name, unsigned owners = kOfMaterial) {
  const KeyNames names = names_for_test();
  KeyNames::Allowance left = KeyNames::kAllowance;
  const auto match = names.find(name, owners, left);
  if (!match) return "";
  constexpr const char* kLikeness[] = {"same", "spelled", "near"};
  return match->key->name + " " + kLikeness[static_cast<std::size_t>(match->likeness)];
}

TEST(KeyNames, FindsOtherSpellings) {
  EXPECT_EQ(found("stiffness"), "stiffness same");
  for (const char* name : {"Stiffness", "STIFFNESS", " stiffness ", "stiff-ness"}) {
    EXPECT_EQ(found(name), "stiffness spelled") << name;
  }
  for (const char* name : {"dynamic_friction", "Dynamic Friction", "dynamic.friction",
                           "friction.dynamic", "FrictionDynamic", "DYNAMIC-FRICTION"}) {
    EXPECT_EQ(found(name), "dynamicFriction spelled") << name;
  }
  for (const char* name : {"stifness", "stiffnes", "sitffness", "stiffnesss", "stffnes"}) {
    EXPECT_EQ(found(name), "stiffness near") << name;
  }
  EXPECT_EQ(found("dinamicFricton"), "dynamicFriction near");
  EXPECT_EQ(found("Solid"), "solid spelled");
  for (const char* name : {"stiffness_N_per_m", "Stiffness (N/m)", "stiffness [N/m]"}) {
    EXPECT_EQ(found(name), "stiffness near") << name;
  }
  EXPECT_EQ(found("stiffness_map"), "");
}

// A key that begins like the name comes before one that has nearly its letters.
TEST(KeyNames, FindsAbbreviationsAndOtherWords) {
  for (const char* name : {"vibrationFreq", "vibration_freq", "vibrationF", "VibrationFrequ",
                           "vibrationFrequencyHz", "vibrationFrequencyOfTheTip"}) {
    EXPECT_EQ(found(name), "vibrationFrequency near") << name;
  }
  EXPECT_EQ(found("vibrationWhe"), "vibrationWhen near");
  EXPECT_EQ(found("vibrationWhenTouched"), "vibrationWhen near");
  EXPECT_EQ(found("vibration"), "");
  EXPECT_EQ(found("dynamicFrictionCoefficient"), "dynamicFriction near");
  EXPECT_EQ(found("staticFric"), "staticFriction near");
  for (const char* name : {"kineticFriction", "kinetic_friction", "Sliding Friction"}) {
    EXPECT_EQ(found(name), "dynamicFriction near") << name;
  }
  EXPECT_EQ(found("dampening"), "damping near");
  EXPECT_EQ(found("springConstant"), "stiffness near");
}

TEST(KeyNames, LeavesOtherWordsAlone) {
  for (const char* name :
       {"", "texture", "name", "density", "friction", "elasticity", "sold", "radiu", "s",
        "targetNames", "static", "stiffnessOfTheWholeObjectHere", "\xff\xfe", "___"}) {
    EXPECT_EQ(found(name), "") << name;
  }
  EXPECT_EQ(found(std::string(100000, 's')), "");
}

TEST(KeyNames, SpendsItsAllowanceOnMisspeltNamesOnly) {
  const KeyNames names = names_for_test();
  KeyNames::Allowance left = 2;
  EXPECT_TRUE(names.find("stiffness", kOfMaterial, left));
  EXPECT_FALSE(names.find("zzzzzzzzz", kOfMaterial, left));
  EXPECT_EQ(left, 2u);
  EXPECT_TRUE(names.find("stifness", kOfMaterial, left));
  EXPECT_LT(left, 2u);
  left = 0;
  EXPECT_FALSE(names.find("stifness", kOfMaterial, left));
  EXPECT_TRUE(names.find("Stiffness", kOfMaterial, left));
}

TEST(KeyNames, SaysWhyAKeyIsUnknown) {
  const KeyNames names = names_for_test();
  EXPECT_EQ(names.why_unknown("colour", kOfMaterial), "the key is unknown");
  EXPECT_EQ(names.why_unknown("stifness", kOfMaterial),
            "the key is unknown; the nearest key is stiffness");
  EXPECT_EQ(names.why_unknown("friction", kOfMaterial),
            "the key is unknown; similar: staticFriction or dynamicFriction");
  EXPECT_EQ(names.why_unknown("gravity", kOfMaterial),
            "the key is unknown here; it belongs to extras.palpate of the scene");
  EXPECT_EQ(names.why_unknown("Gravity", kOfMaterial),
            "the key is unknown; the nearest key is gravity, which belongs to extras.palpate of "
            "the scene");
  EXPECT_EQ(names.why_unknown("stiffness", kOfNode),
            "the key is unknown here; it belongs to extras.palpate of a material");
}

}  // namespace
}  // namespace palpate
