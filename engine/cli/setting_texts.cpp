#include "engine/cli/setting_texts.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

namespace palpate {
namespace {

// Finite numbers separated by blanks or commas; no value if the text contains anything else, or a
// comma that is not between two numbers.
std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::string dense = text;
  std::erase_if(dense, [](char c) { return c == ' ' || c == '\t' || c == '\n'; });
  if (dense.starts_with(',') || dense.ends_with(',') || dense.find(",,") != std::string::npos) {
    return std::nullopt;
  }
  std::string blanks = text;
  for (char& c : blanks) {
    if (c == ',') c = ' ';
  }
  std::istringstream words(blanks);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const char* end = word.data() + word.size();
    const char* begin =
        word.data() + (word.starts_with('+') ? 1 : 0);  // from_chars refuses a plus sign
    double x = 0.0;
    const auto [rest, failed] = std::from_chars(begin, end, x);
    if (failed != std::errc() || rest != end || !std::isfinite(x)) return std::nullopt;
    numbers.push_back(x);
  }
  return numbers;
}

// The name may contain equals signs.
Result<SteadyMotion> parse_move(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const auto n =
      equals == std::string::npos ? std::nullopt : parse_numbers(text.substr(equals + 1));
  if (!n || n->size() != 6 || equals == 0) {
    return invalid_argument("--move", "is \"" + text + "\"; expected NODE=\"vx vy vz wx wy wz\"",
                            "state m/s and rad/s along and about the axes of the scene");
  }
  const SteadyMotion motion{
      text.substr(0, equals), {(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]}};
  if (!std::isfinite(motion.velocity_m_per_s.norm()) ||
      !std::isfinite(motion.turn_rad_per_s.norm())) {
    return invalid_argument("--move", "is \"" + text + "\", whose speed overflows",
                            "state a lower speed");
  }
  return motion;
}

}  // namespace

Result<std::vector<Vec3>> parse_axes(const std::string& text) {
  std::vector<Vec3> axes;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ';');) {
    const auto numbers = parse_numbers(part);
    if (numbers && numbers->empty()) continue;  // after a closing semicolon
    if (!numbers || numbers->size() != 3) {
      return invalid_argument("--actuated-axes", "has \"" + part + "\" in place of three numbers",
                              "write for example \"0 0 1; 1 0 0\"");
    }
    axes.emplace_back((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  }
  return axes;
}

Result<ScenePose> parse_place(const std::string& text) {
  ScenePose pose;
  if (text.empty()) return pose;
  const auto n = parse_numbers(text);
  if (!n || n->size() != 7) {
    return invalid_argument(
        "--place", "is \"" + text + "\"; expected seven numbers \"x y z qw qx qy qz\"",
        "write metres and a unit quaternion; the identity is \"0 0 0 1 0 0 0\"");
  }
  const Quat q((*n)[3], (*n)[4], (*n)[5], (*n)[6]);
  const double norm = q.norm();
  // A unit quaternion typed with six digits has this length; a larger deviation is a mistake.
  constexpr double kTypedUnit = 1e-4;
  if (!(std::abs(norm - 1.0) <= kTypedUnit)) {
    return invalid_argument("--place",
                            "has a quaternion of length " + std::to_string(norm) + "; expected 1",
                            "divide the quaternion by its length");
  }
  pose.rotation = norm == 1.0 ? q : Quat(q.normalized());
  pose.translation_m = {(*n)[0], (*n)[1], (*n)[2]};
  return pose;
}

Result<std::vector<SteadyMotion>> parse_moves(const std::vector<std::string>& texts) {
  std::vector<SteadyMotion> motions;
  for (const std::string& text : texts) {
    const auto motion = parse_move(text);
    if (!motion) return motion.error();
    motions.push_back(*motion);
  }
  return motions;
}

Result<EnergyBudgets> parse_energy_budgets(const std::vector<std::string>& texts) {
  EnergyBudgets budgets;
  std::array<bool, kEnergySourceCount> is_stated{};
  for (const std::string& text : texts) {
    const auto refused = [&](const std::string& problem) {
      std::ostringstream expected;
      expected << "is \"" << text << "\"" << problem
               << "; expected SOURCE=MJ or SOURCE=MJ,W with 0 to " << 1e3 * EnergyBudget::kMost_J
               << " mJ and 0 to " << EnergyBudget::kMost_W << " W";
      return invalid_argument("--energy-budget", expected.str(),
                              "write for example motors=100 or motors=100,0.1");
    };
    const std::size_t equals = text.find('=');
    const auto source =
        std::find(kEnergySourceNames.begin(), kEnergySourceNames.end(), text.substr(0, equals));
    if (equals == std::string::npos) return refused("");
    if (source == kEnergySourceNames.end()) {
      std::string names;
      for (const std::string_view name : kEnergySourceNames) {
        names += (names.empty() ? "" : ", ") + std::string(name);
      }
      return refused(", whose source is none of " + names);
    }
    const auto numbers = parse_numbers(text.substr(equals + 1));
    if (!numbers || numbers->empty() || numbers->size() > 2) return refused("");
    const auto n = static_cast<std::size_t>(source - kEnergySourceNames.begin());
    if (is_stated[n]) return refused(", which states the source again");
    is_stated[n] = true;
    EnergyBudget& budget = budgets.of[n];
    budget.tank_J = 1e-3 * numbers->front();
    if (numbers->size() == 2) budget.power_W = numbers->back();
    if (!budget.is_in_range()) return refused("");
  }
  return budgets;
}

std::string energy_budgets_text(const EnergyBudgets& budgets) {
  const EnergyBudgets usual;
  std::ostringstream text;
  for (std::size_t n = 0; n < kEnergySourceCount; ++n) {
    const EnergyBudget& budget = budgets.of[n];
    if (budget == usual.of[n]) continue;
    text << (text.view().empty() ? "" : "; ") << kEnergySourceNames[n] << " " << 1e3 * budget.tank_J
         << " mJ at once and " << budget.power_W << " W for ever (default "
         << 1e3 * usual.of[n].tank_J << " mJ and " << usual.of[n].power_W << " W)";
  }
  return text.str();
}

// The name may contain dots, the key may not; the value may not contain equals signs.
Result<std::vector<MaterialOverride>> parse_overrides(const std::vector<std::string>& texts) {
  std::vector<MaterialOverride> overrides;
  for (const std::string& text : texts) {
    const std::size_t equals = text.rfind('=');
    const std::size_t dot = equals == std::string::npos || equals == 0
                                ? std::string::npos
                                : text.rfind('.', equals - 1);
    const bool is_whole =
        dot != std::string::npos && dot > 0 && dot + 1 < equals && equals + 1 < text.size();
    if (!is_whole) {
      return invalid_argument("--material", "is \"" + text + "\"; expected NAME.key=value",
                              "write for example wood.stiffness=800");
    }
    overrides.push_back(
        {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1)});
  }
  return overrides;
}

}  // namespace palpate
