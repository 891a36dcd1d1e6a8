#include "engine/viewer/messages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <string_view>

namespace palpate {
namespace {

static_assert(std::endian::native == std::endian::little, "messages copy numbers as they are");

constexpr std::uint16_t kState = 1;
constexpr std::uint16_t kTicks = 2;
constexpr std::uint16_t kPointer = 16;
constexpr std::size_t kPointerBytes = 40;
constexpr double kMostRowsPerSecond = 2000.0;

template <typename Number>
void put(std::string& out, Number number) {
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  out.append(bytes, sizeof number);
}

template <typename Number>
Number number_at(std::string_view bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

void put_head(std::string& out, std::uint16_t kind) {
  out.clear();
  put(out, kind);
  put(out, static_cast<std::uint16_t>(kViewVersion));
}

constexpr std::array kChartColumns = {&TickSummary::alpha_rad, &TickSummary::depth_m2,
                                      &TickSummary::force_N2, &TickSummary::full_force_N2,
                                      &TickSummary::step_us};

// The smallest and the largest number of each column, at the first and the last time of the group.
std::array<TickSummary, 2> extremes(std::span<const TickSummary> rows) {
  std::array<TickSummary, 2> ends = {rows.front(), rows.back()};
  const bool has_contact =
      std::any_of(rows.begin(), rows.end(), [](const TickSummary& row) { return row.contact; });
  for (const auto column : kChartColumns) {
    // Without contact there is no angle.
    const bool only_contact = column == &TickSummary::alpha_rad && has_contact;
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const TickSummary& row : rows) {
      if (only_contact && !row.contact) continue;
      low = std::min(low, row.*column);
      high = std::max(high, row.*column);
    }
    ends[0].*column = low;
    ends[1].*column = high;
  }
  for (TickSummary& end : ends) end.contact = has_contact;
  return ends;
}

std::vector<TickSummary> thinned(std::span<const TickSummary> rows, std::size_t group) {
  std::vector<TickSummary> kept;
  for (std::size_t begin = 0; begin < rows.size(); begin += group) {
    const auto part = rows.subspan(begin, std::min(group, rows.size() - begin));
    if (part.size() == 1) {
      kept.push_back(part.front());
    } else {
      const auto ends = extremes(part);
      kept.insert(kept.end(), ends.begin(), ends.end());
    }
  }
  return kept;
}

template <typename Value>
void put_column(std::string& out, std::span<const TickSummary> rows, const Value& value) {
  for (const TickSummary& row : rows) put(out, static_cast<float>(value(row)));
}

}  // namespace

void encode_state(const ViewState& state, std::span<const BodyPose> bodies, double now_s,
                  std::string& out) {
  put_head(out, kState);
  put(out, state.flags);
  put(out, state.pointer);
  for (const double x : state.target_m) put(out, x);
  put(out, now_s);
  put(out, static_cast<std::uint32_t>(sizeof(TickRecord)));
  put(out, static_cast<std::uint32_t>(bodies.size()));
  const std::string_view body_name = state.body_name.substr(0, kMostTouchedNameBytes);
  const std::string_view material_name = state.material_name.substr(0, kMostTouchedNameBytes);
  put(out, state.axis_count);
  put(out, static_cast<std::uint16_t>(body_name.size()));
  put(out, static_cast<std::uint16_t>(material_name.size()));
  for (const auto& axis : state.axes) {
    for (const double x : axis) put(out, x);
  }
  char record[sizeof(TickRecord)];
  std::memcpy(record, &state.record, sizeof record);
  out.append(record, sizeof record);
  for (const BodyPose& pose : bodies) {
    put(out, pose.body);
    put(out, std::uint32_t{0});
    for (const double x : pose.q_wxyz) put(out, x);
    for (const double x : pose.o_m) put(out, x);
  }
  out += body_name;
  out += material_name;
}

void encode_ticks(std::span<const TickSummary> rows, std::uint32_t lost, std::uint32_t group,
                  std::string& out) {
  std::vector<TickSummary> few;
  if (group > 1) {
    few = thinned(rows, group);
    rows = few;
  }
  const double base_s = rows.empty() ? 0.0 : rows.front().time_s;
  put_head(out, kTicks);
  put(out, static_cast<std::uint32_t>(rows.size()));
  put(out, base_s);
  put(out, lost);
  put(out, group);
  constexpr float kDegrees = static_cast<float>(180.0 / std::numbers::pi);
  put_column(out, rows, [&](const TickSummary& row) { return row.time_s - base_s; });
  put_column(out, rows, [&](const TickSummary& row) {
    return row.contact != 0 ? kDegrees * row.alpha_rad : std::numeric_limits<float>::quiet_NaN();
  });
  put_column(out, rows, [](const TickSummary& row) { return std::sqrt(row.depth_m2); });
  put_column(out, rows, [](const TickSummary& row) { return std::sqrt(row.force_N2); });
  put_column(out, rows, [](const TickSummary& row) { return std::sqrt(row.full_force_N2); });
  put_column(out, rows, [](const TickSummary& row) { return row.step_us; });
  put_column(out, rows, [](const TickSummary& row) { return row.contact; });
}

std::uint32_t thinning_group(double rate_Hz) {
  if (!(rate_Hz > kMostRowsPerSecond)) return 1;
  return static_cast<std::uint32_t>(std::ceil(2.0 * rate_Hz / kMostRowsPerSecond));
}

Result<PointerMessage> decode_pointer(std::string_view bytes) {
  const auto refused = [](const char* field, std::string problem) {
    return invalid_argument(std::string("pointer.") + field, std::move(problem));
  };
  if (bytes.size() != kPointerBytes) {
    return refused("size", "is " + std::to_string(bytes.size()) + " bytes; expected 40");
  }
  if (const auto kind = number_at<std::uint16_t>(bytes, 0); kind != kPointer) {
    return refused("kind", "is " + std::to_string(kind) + "; expected 16");
  }
  if (const auto version = number_at<std::uint16_t>(bytes, 2); version != kViewVersion) {
    return refused("version",
                   "is " + std::to_string(version) + "; expected " + std::to_string(kViewVersion));
  }
  PointerMessage message;
  const auto buttons = number_at<std::uint32_t>(bytes, 4);
  message.holds = (buttons & 1u) != 0;
  message.is_clutched = (buttons & 2u) != 0;
  message.sequence = number_at<std::uint64_t>(bytes, 8);
  if (message.sequence == 0) return refused("sequence", "is 0; expected a positive number");
  for (std::size_t k = 0; k < 3; ++k) {
    message.target_m[k] = number_at<double>(bytes, 16 + 8 * k);
    if (!std::isfinite(message.target_m[k])) {
      return refused("target", "is not finite; expected a place in the device frame, m");
    }
  }
  return message;
}

}  // namespace palpate
