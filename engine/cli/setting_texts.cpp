#include "engine/cli/setting_texts.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

namespace palpate {
namespace {

// Finite numbers separated by blanks or commas; nothing if anything else is there.
std::optional<std::vector<double>> parse_numbers(const std::string& text) {
  std::string blanks = text;
  for (char& c : blanks) {
    if (c == ',') c = ' ';
  }
  std::istringstream words(blanks);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const char* end = word.data() + word.size();
    const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);  // which from_chars refuses
    double x = 0.0;
    const auto [rest, failed] = std::from_chars(begin, end, x);
    if (failed != std::errc() || rest != end || !std::isfinite(x)) return std::nullopt;
    numbers.push_back(x);
  }
  return numbers;
}

// The name may hold equals signs, the numbers do not.
Result<SteadyMotion> parse_move(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  const auto n =
      equals == std::string::npos ? std::nullopt : parse_numbers(text.substr(equals + 1));
  if (!n || n->size() != 6 || equals == 0) {
    return invalid_argument("--move", "\"" + text + "\" is not NODE=\"vx vy vz wx wy wz\"",
                            "metres and radians a second along the axes of the scene");
  }
  const SteadyMotion motion{
      text.substr(0, equals), {(*n)[0], (*n)[1], (*n)[2]}, {(*n)[3], (*n)[4], (*n)[5]}};
  if (!std::isfinite(motion.velocity_m_per_s.norm()) ||
      !std::isfinite(motion.turn_rad_per_s.norm())) {
    return invalid_argument("--move", "\"" + text + "\" is too fast to be a motion");
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
      return invalid_argument("--actuated-axes", "\"" + part + "\" is not three numbers",
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
    return invalid_argument("--place",
                            "\"" + text + "\" is not seven numbers \"x y z qw qx qy qz\"",
                            "metres and a quaternion, identity is \"0 0 0 1 0 0 0\"");
  }
  const Quat q((*n)[3], (*n)[4], (*n)[5], (*n)[6]);
  const double norm = q.norm();
  // Typed with six digits or more, a unit quaternion has this length; what has not is a mistake.
  constexpr double kTypedUnit = 1e-4;
  if (!(std::abs(norm - 1.0) <= kTypedUnit)) {
    return invalid_argument("--place",
                            "the quaternion has length " + std::to_string(norm) + ", expected 1");
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

// The name may hold dots, the key does not; neither does the value hold equals signs.
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
      return invalid_argument("--material", "\"" + text + "\" is not NAME.key=value",
                              "for example wood.stiffness=800");
    }
    overrides.push_back(
        {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1)});
  }
  return overrides;
}

}  // namespace palpate
