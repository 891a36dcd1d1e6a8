#include "engine/trials/trial_row.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr std::array<TrialMeasure, kFirstFaultMeasure> kOwnMeasures = {{
    {"total_time_s", "s",
     "from the first contact within the green sphere to the first contact within the red sphere",
     "total time"},
    {"contact_s", "s", "part of the total time in contact", ""},
    {"losses_of_contact", "1", "transitions from contact to no contact, however short",
     "number of losses of contact"},
    {"losses_100ms", "1", "intervals without contact of 0.1 s or more", ""},
    {"losses_per_s", "1/s", "losses_of_contact divided by total_time_s", ""},
    {"losses_100ms_per_s", "1/s", "losses_100ms divided by total_time_s", ""},
    {"mean_penetration_m", "m", "mean distance from the device point to the proxy, over contact",
     ""},
    {"mean_penetration_dm", "dm", "mean_penetration_m in the paper's unit", "mean penetration"},
    {"mean_contact_angle_deg", "deg",
     "mean angle from the contact normal to the actuated axes, over contact", "mean contact angle"},
    {"share_within_30deg", "1", "share of the contact with a contact angle of at most 30 deg", ""},
    {"tracked_share", "1",
     "share of the way from green to red along which the contact moved without a loss", ""},
    {"recoveries", "1", "how often the simulated operator was lost and went back to the contour",
     ""},
    {"device_path_m", "m", "length of the path of the device point, device frame", ""},
    {"proxy_path_m", "m", "length of the path of the proxy, scene frame", ""},
    {"port_work_J", "J",
     "work of the commanded force on the hand; positive: the device gave energy", ""},
    {"work_lost_J", "J", "work of the full force on the hand minus port_work_J", ""},
    {"mean_ghost_force_N", "N",
     "mean part of the commanded force that is tangential to the surface, over contact", ""},
    {"mean_missing_force_N", "N",
     "mean of the full force minus the commanded force along the normal, over contact", ""},
}};

constexpr std::array<TrialMeasure, kMeasureCount - kPlainMeasureCount> kStrategyMeasures = {{
    {"wall_work_J", "J",
     "work that the tangential part of the commanded force did in the direction of the motion, "
     "over "
     "contact",
     ""},
    {"largest_contact_work_J", "J",
     "largest work of the commanded force on the hand in one contact; positive: the device gave "
     "energy",
     ""},
    {"empty_turns", "1", "turns of the scene in free motion that no contact followed within 0.1 s",
     ""},
    {"mean_drift_m", "m",
     "mean distance of the scene from its place at the start, device frame; empty if the scene "
     "turned",
     ""},
    {"worst_drift_m", "m", "largest such distance", ""},
    {"governor_share", "1", "share of the ticks in which the governor changed the force", ""},
}};

constexpr std::array<std::string_view, kFaultCount> kFaultMeanings = {
    "ticks whose position was not finite",
    "ticks whose time step was not valid",
    "ticks in which the solver reached its limit of steps or work",
    "ticks whose position was farther from the last one than a hand can move",
    "ticks in which the proxy stopped a moving body",
    "ticks in which a new pose of a body was ignored",
    "ticks whose computed force was not finite",
    "ticks whose position was too far from the scene",
    "ticks that were refused because of their settings",
    "ticks whose sample the device marked as invalid",
    "ticks in which new motor axes were ignored",
    "ticks in which magnets and media reached their limit of work"};

std::array<TrialMeasure, kMeasureCount> make_measures() {
  std::array<TrialMeasure, kMeasureCount> all{};
  for (std::size_t i = 0; i < kOwnMeasures.size(); ++i) all[i] = kOwnMeasures[i];
  for (std::size_t i = 0; i < kFaultCount; ++i) {
    all[kFirstFaultMeasure + i] = {kFaultNames[i], "1", kFaultMeanings[i], ""};
  }
  all[kMissedDeadlines] = {"missed_deadlines", "1",
                           "ticks that began after their deadline; 0 in simulated time", ""};
  std::copy(kStrategyMeasures.begin(), kStrategyMeasures.end(), all.begin() + kPlainMeasureCount);
  return all;
}

}  // namespace

const std::array<TrialMeasure, kMeasureCount>& trial_measures() {
  static const std::array<TrialMeasure, kMeasureCount> measures = make_measures();
  return measures;
}

}  // namespace palpate
