#include "engine/session/loop_changes.h"

#include <array>
#include <cstring>
#include <optional>

#include "engine/session/live_setting.h"
#include "haptics/effects/effect_program.h"

namespace palpate {
namespace {

template <std::size_t kCount>
std::span<const std::byte> bytes_of(const std::array<double, kCount>& numbers) {
  return std::as_bytes(std::span(numbers));
}

template <std::size_t kCount>
std::array<double, kCount> numbers_of(std::span<const std::byte> bytes) {
  std::array<double, kCount> numbers;
  std::memcpy(numbers.data(), bytes.data(), sizeof numbers);
  return numbers;
}

// A kind without a line of the table, or in another place than its number, does not compile.
consteval bool table_is_in_order() {
  for (std::size_t k = 0; k < kInputKinds.size(); ++k) {
    const InputKindFacts& facts = kInputKinds[k];
    if (facts.kind != static_cast<InputKind>(k)) return false;
    if (facts.least_bytes > facts.most_bytes || facts.most_bytes > kMostInputBytes) return false;
  }
  return kInputKinds.size() == static_cast<std::size_t>(InputKind::kSetting) + 1;
}
static_assert(table_is_in_order());

constexpr std::uint32_t kActuatorsShift = 8;

std::optional<ActuationModel> actuation_of(const TickInput& input) {
  const auto n = numbers_of<9>(input.bytes);
  return ActuationModel::from_basis(
      static_cast<int>(input.handle & ((1u << kActuatorsShift) - 1)),
      static_cast<int>(input.handle >> kActuatorsShift & ((1u << kActuatorsShift) - 1)),
      {Vec3(n[0], n[1], n[2]), Vec3(n[3], n[4], n[5]), Vec3(n[6], n[7], n[8])});
}

// Unpacks an input and changes the loop. The compiler must know every kind here.
#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wswitch"
bool apply_change(const TickInput& input, HapticLoop& loop) noexcept {
  switch (input.kind) {
    case InputKind::kBodyPose: {
      const auto n = numbers_of<7>(input.bytes);
      loop.move_body(input.handle, {Quat(n[0], n[1], n[2], n[3]), Vec3(n[4], n[5], n[6])});
      return true;
    }
    case InputKind::kBadBodyPose:
      loop.refuse_body_pose();
      return true;
    case InputKind::kActuation: {
      const auto actuation = actuation_of(input);
      if (actuation) loop.set_actuation(*actuation);
      return actuation.has_value();
    }
    case InputKind::kA4:
    case InputKind::kForce:
    case InputKind::kCoupling:
    case InputKind::kSetting: {
      const LiveChanges changes(input);
      for (const LiveChange& change : changes.all()) {
        kLiveSettings[change.setting].set(loop, change.value);
      }
      return !changes.all().empty();
    }
    case InputKind::kFreeHand:
      input.handle != 0 ? loop.free_hand() : loop.hold_hand();
      return true;
    // Inputs that need the scene, and those of the session and of its device.
    case InputKind::kEffectParameters:
    case InputKind::kMotors:
    case InputKind::kRearm:
    case InputKind::kTrip:
    case InputKind::kPause:
      return false;
  }
  return false;
}
#pragma GCC diagnostic pop

}  // namespace

void LoopChanges::move_body(std::uint32_t body, const RigidTransform& T_scene_body) noexcept {
  const Quat& q = T_scene_body.rotation;
  const Vec3& o = T_scene_body.translation_m;
  const std::array<double, 7> numbers{q.w(), q.x(), q.y(), q.z(), o.x(), o.y(), o.z()};
  make({InputKind::kBodyPose, body, bytes_of(numbers)});
}

void LoopChanges::set_actuation(const ActuationModel& actuation) noexcept {
  std::array<double, 9> numbers;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    numbers[k] = actuation.actuated_axis(static_cast<int>(k / 3))[static_cast<Eigen::Index>(k % 3)];
  }
  make({InputKind::kActuation,
        static_cast<std::uint32_t>(actuation.sensors()) |
            static_cast<std::uint32_t>(actuation.actuators()) << kActuatorsShift,
        bytes_of(numbers)});
}

void LoopChanges::set(std::size_t setting, double value) noexcept {
  const std::array<double, 1> number{value};
  make({InputKind::kSetting, kLiveSettings[setting].number, bytes_of(number)});
}

void LoopChanges::set_effect_parameters(std::uint32_t call, std::uint16_t effect,
                                        std::span<const std::byte> parameters) noexcept {
  if (sink_) {
    std::array<double, kMostInputBytes / sizeof(double)> numbers;
    std::size_t count = 0;
    for (const ParameterKey& key : compiled_effects()[effect].keys) {
      if (count == numbers.size()) break;  // checked by MaterialTuner::add()
      std::memcpy(&numbers[count++], parameters.data() + key.offset, sizeof(double));
    }
    sink_->on_input(
        {InputKind::kEffectParameters, call, std::as_bytes(std::span(numbers).first(count))});
  }
  loop_->set_effect_parameters(call, parameters);
}

bool LoopChanges::make(const TickInput& input) noexcept {
  const auto kind = static_cast<std::size_t>(input.kind);
  if (kind >= kInputKinds.size()) return false;
  const InputKindFacts& facts = kInputKinds[kind];
  if (input.bytes.size() < facts.least_bytes || input.bytes.size() > facts.most_bytes) return false;
  if (sink_) sink_->on_input(input);
  return apply_change(input, *loop_);
}

}  // namespace palpate
