#!/usr/bin/env python3
"""Each rule of the safety governor has a test: a governor with a broken rule must fail its tests.

governor_mutations_test.py SOURCE_DIR BUILD_DIR [NAME...]

Copies the sources of the governor, breaks one rule at a time by replacing a text, compiles the copy
with the options of the build, and runs the tests in TESTS with it. The unchanged
copy must pass, and every broken one must fail. NAME selects the mutations whose name begins with it.
"""

import json
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

TESTS = [f"tests/haptics/{name}_test.cpp"
         for name in ("safety_governor", "governor_property", "governor_heat", "motor_heat",
                      "gentle_release", "passivity_control", "spring_restart", "swing_watch",
                      "energy_budgets", "force_history", "encoder_path", "stiff_span")]
GOVERNOR = "haptics/safety_governor.cpp"
MOTORS = "haptics/motor_limits.cpp"
HEAT = "haptics/motor_heat.cpp"
RELEASE = "haptics/gentle_release.cpp"
ENERGY = "haptics/safety_governor_energy.cpp"
CONTROL = "haptics/passivity_control.cpp"
CONTROL_H = "haptics/passivity_control.h"
RESTART = "haptics/spring_restart.cpp"
SWING = "haptics/swing_watch.cpp"
BUDGETS = "haptics/energy_budgets.cpp"
HISTORY = "haptics/force_history.h"
PATH = "haptics/encoder_path.cpp"
SPAN = "haptics/stiff_span.h"
SPEED = "haptics/strategies/speed_window.h"
# The last one is unchanged: the tests need it.
PROGRAM = [GOVERNOR, ENERGY, CONTROL, RESTART, SWING, BUDGETS, MOTORS, HEAT, RELEASE, PATH,
           "geometry/base/decompositions.cpp"]
SOURCES = [*PROGRAM, *TESTS, "tests/haptics/governor_judge.cpp"]
HEADERS = [SPEED, HISTORY, SPAN,
           *(source.replace(".cpp", ".h") for source in PROGRAM if source != ENERGY)]
# A broken governor may run into an endless loop; the tests take some seconds.
LONGEST_S = 120

# Per rule of the table in safety_governor.h: what is broken, in which file, the text and what
# replaces it.
MUTATIONS = {
    "finite": [
        ("keeps a force that is not finite", GOVERNOR,
         "    wanted_N.setZero();\n", ""),
        ("does not trip at a force that is not finite", GOVERNOR,
         "    if (has_bad_force) trip(TripReason::kBadForce, 0.0, 0.0, record);\n", ""),
        ("goes on at full force after a bad sample", GOVERNOR,
         "  if (has_bad_sample(record)) {\n    is_interrupted_ = true;\n",
         "  if (has_bad_sample(record)) {\n"),
        ("does not publish a bad sample", GOVERNOR,
         "    record.rules |= kRuleBadSample;\n", ""),
        ("trips at the fourth bad sample", GOVERNOR,
         "if (bad_samples_ >= bad_ns_.size() &&", "if (bad_samples_ > bad_ns_.size() &&"),
        ("counts bad samples without end", GOVERNOR,
         "&& now_ns_ - first_ns <= nanoseconds(Limits::kBadSamples_s))", ")"),
    ],
    "motors": [
        ("keeps what the motors cannot push", GOVERNOR,
         "limits_motors_ ? motors_.part(wanted_N) : wanted_N", "wanted_N"),
        ("does not publish what it drops", GOVERNOR,
         "  if (pushed_N_ != wanted_N) record.rules |= kRuleMotors;\n", ""),
        ("lets a motor exceed its peak", GOVERNOR,
         "factor = std::min(factor, marked(peaks < 1.0 ? kBelowLimit * peaks : 1.0, kRulePeak, record));",
         "factor = std::min(factor, marked(peaks < 0.0 ? 0.0 : 1.0, kRulePeak, record));"),
        ("looks only at the last motor that exceeds its peak", MOTORS,
         "scale = std::min(scale, peak_N / std::abs(motor_N[i]));",
         "scale = peak_N / std::abs(motor_N[i]);"),
        ("takes oblique motors for orthogonal ones", MOTORS,
         "for (int j = i + 1; j < basis.count; ++j) along_N -= basis.of_motors(i, j) * motor_N[j];",
         ""),
    ],
    "clamp": [
        ("has no clamp", GOVERNOR,
         "double factor = marked(factor_to(clamp_N_, pushed_N_), kRuleClamp, record);",
         "double factor = 1.0;"),
        ("does not count", GOVERNOR,
         "marked(factor_to(clamp_N_, pushed_N_), kRuleClamp, record)",
         "factor_to(clamp_N_, pushed_N_)"),
        ("lets the user raise the driver's limit", GOVERNOR,
         "std::min(clamp_N, max_force_N.value_or(clamp_N))", "max_force_N.value_or(clamp_N)"),
        ("trusts motors whose peak is unknown", GOVERNOR,
         "  if (device.moves_motors) clamp_N = Limits::kUnknownPeak_N;\n", ""),
        ("reverses the force by a negative limit", GOVERNOR,
         "return std::max(0.0, std::min(", "return std::max(-1e9, std::min("),
    ],
    "slew": [
        ("has no slew", ENERGY,
         "  limit_slew(force_N, record);\n  // What the rules", "  // What the rules"),
        ("does not count", GOVERNOR,
         "force_N *= marked(factor, kRuleSlew, record);", "force_N *= factor;"),
        ("does not let a reversal grow from zero", GOVERNOR,
         "std::max(0.0, last_force_N_.dot(force_N) / length_N)", "last_force_N_.norm()"),
        ("takes the longest step for its time", GOVERNOR,
         "Limits::kSlew_N_per_s * seconds(ramp_step_ns_)",
         "Limits::kSlew_N_per_s * seconds(step_ns_)"),
        ("takes the nominal step for its time", GOVERNOR,
         "Limits::kSlew_N_per_s * seconds(ramp_step_ns_)",
         "Limits::kSlew_N_per_s * seconds(period_ns_)"),
        ("takes a large change for a small one", GOVERNOR,
         "if (is_far_below(force_N - last_force_N_, growth_N)) return;",
         "if (is_far_below(force_N - last_force_N_, 4 * growth_N)) return;"),
        ("delays a fall", GOVERNOR,
         "  // No force grows by more than the length of its change.\n",
         "  if (force_N.norm() < 0.5 * last_force_N_.norm()) force_N = 0.5 * last_force_N_;\n"),
    ],
    "speed": [
        ("does not trip", GOVERNOR,
         "  trip(TripReason::kSpeed, *speed, Limits::kTopSpeed_m_per_s, record);\n", ""),
        ("trips twice as fast", GOVERNOR,
         "*speed <= Limits::kTopSpeed_m_per_s", "*speed <= 2 * Limits::kTopSpeed_m_per_s"),
        ("trips without a force", GOVERNOR,
         "  if (last_force_N_.norm() <= Limits::kMovingShare * clamp_N_) return;\n", ""),
        ("takes a fast device for a slow one", SPEED,
         "0.5 * limit_m_per_s * time_s()", "2.0 * limit_m_per_s * time_s()"),
        ("takes the speed of one tick", GOVERNOR,
         "longer_ns(Limits::kSpeedWindow_s, Limits::kSpeedWindowPeriods, period_ns_)",
         "longer_ns(0.0, 1.0, period_ns_)"),
        ("has no window of two slow periods", GOVERNOR,
         "longer_ns(Limits::kSpeedWindow_s, Limits::kSpeedWindowPeriods, period_ns_)",
         "longer_ns(Limits::kSpeedWindow_s, 0.0, period_ns_)"),
        ("loses the window at a high rate", SPEED,
         "if (count_ == 0 || time_s - entry(count_ - 1).time_s >= window_s_ / kSpacing) {",
         "{"),
        ("keeps the first position for ever", SPEED,
         "while (oldest_ + 1 < count_ && is_old(entry(oldest_ + 1))) ++oldest_;", ""),
    ],
    "stale": [
        ("keeps the force of an old sample", GOVERNOR,
         "  if (sample_age_ns_ > longest_age_ns_) {\n    is_interrupted_ = true;\n",
         "  if (sample_age_ns_ > longest_age_ns_) {\n"),
        ("has no limit in periods", GOVERNOR,
         "longer_ns(Limits::kStale_s, Limits::kStalePeriods, period_ns_)",
         "longer_ns(Limits::kStale_s, 0.0, period_ns_)"),
        ("does not trip", GOVERNOR,
         "      trip(TripReason::kStale, seconds(sample_age_ns_), seconds(longest_ns), record);\n",
         ""),
        ("takes a repeated sample for a new one", GOVERNOR,
         "is_new_ = !has_sample_ || sample.sequence > sample_.sequence;",
         "is_new_ = !has_sample_ || sample.sequence >= sample_.sequence;"),
        ("ignores the time of a sample", GOVERNOR,
         "if (is_newest_good && sample.time_ns != 0 && time.now_ns != 0) {", "if (false) {"),
        ("uses a sample that is out of order", GOVERNOR,
         "  if (is_out_of_order_) {\n", "  if (false) {\n"),
        ("does not publish a sample that is out of order", GOVERNOR,
         "  if (is_out_of_order_) record.rules |= kRuleOrder;\n", ""),
    ],
    "late": [
        ("keeps the force of a late tick", GOVERNOR,
         "  if (late_ns_ > longest_late_ns_) {\n    is_interrupted_ = true;\n",
         "  if (late_ns_ > longest_late_ns_) {\n"),
        ("has no limit in periods", GOVERNOR,
         "longer_ns(Limits::kLate_s, Limits::kLatePeriods, period_ns_)",
         "longer_ns(Limits::kLate_s, 0.0, period_ns_)"),
        ("never starts again", GOVERNOR,
         "    if (is_very_late && !is_tripped()) begin_start();\n", ""),
        ("always starts again", GOVERNOR,
         "if (is_very_late && !is_tripped())", "if (!is_tripped())"),
        ("ends a trip", GOVERNOR,
         "if (is_very_late && !is_tripped())", "if (is_very_late)"),
    ],
    "workspace": [
        ("has no workspace", GOVERNOR,
         "marked(workspace_factor(record), kRuleWorkspace, record)", "1.0"),
        ("has a step at the border", GOVERNOR,
         "std::max(0.0, 1.0 - beyond / Limits::kFadeShare)", "beyond > 0.0 ? 0.0 : 1.0"),
        ("fades twice as slowly", GOVERNOR,
         "beyond / Limits::kFadeShare", "0.5 * beyond / Limits::kFadeShare"),
        ("has one side only", GOVERNOR,
         "std::abs(record.device_m[k] - middle_m)", "(record.device_m[k] - middle_m)"),
        ("has one axis only", GOVERNOR,
         "for (int k = 0; k < sensed_axes_; ++k) {", "for (int k = 0; k < 1; ++k) {"),
        ("has its middle in the origin", GOVERNOR,
         "const double middle_m = workspace_low_m_[n] + half_m;", "const double middle_m = 0.0;"),
    ],
    "ease": [
        ("does not ease", GOVERNOR,
         "return is_eased_ ? seconds(ease_ns_)", "return is_interrupted_ ? seconds(ease_ns_)"),
        ("eases twice as fast", GOVERNOR,
         "seconds(ease_ns_) / Limits::kEase_s : 1.0",
         "std::min(1.0, 2 * seconds(ease_ns_) / Limits::kEase_s) : 1.0"),
        ("does not begin anew", GOVERNOR,
         "ease_ns_ = is_interrupted_ ? 0 : ease_ns_ + ramp_step_ns_;",
         "ease_ns_ = is_interrupted_ && !is_eased_ ? 0 : ease_ns_ + ramp_step_ns_;"),
        ("multiplies its factor", GOVERNOR,
         "factor = std::min(factor, marked(ease_share(), kRuleEase, record));",
         "factor *= marked(ease_share(), kRuleEase, record);"),
    ],
    "start": [
        ("begins at full force", GOVERNOR,
         "  if (moves_motors_) begin_start();\n", ""),
        ("goes on at full force after a rearm", GOVERNOR,
         "&& is_tripped()) begin_start();\n    watch_interruptions",
         "&& is_tripped()) status_.state = GovernorState::kRuns;\n    watch_interruptions"),
        ("rearms by itself", GOVERNOR,
         "if (rearms && is_tripped())", "if (is_tripped())"),
        ("starts under any force", GOVERNOR,
         "record.contact == 0 || pushed_N_.norm() < Limits::kStartForce_N", "true"),
        ("waits for a small force without contact", GOVERNOR,
         "record.contact == 0 || pushed_N_.norm() < Limits::kStartForce_N",
         "pushed_N_.norm() < Limits::kStartForce_N"),
        ("starts at any speed", GOVERNOR,
         "&& speed && *speed < Limits::kStartSpeed_m_per_s", "&& speed"),
        ("starts before it knows the speed", GOVERNOR,
         "&& speed && *speed < Limits::kStartSpeed_m_per_s",
         "&& !(speed && *speed >= Limits::kStartSpeed_m_per_s)"),
        ("starts at once", GOVERNOR,
         "    if (calm_ns_ < nanoseconds(Limits::kCalm_s)) return;\n", ""),
        ("does not begin to wait anew", GOVERNOR,
         "calm_ns_ = is_calm ? calm_ns_ + ramp_step_ns_ : 0;",
         "calm_ns_ = is_calm ? calm_ns_ + ramp_step_ns_ : calm_ns_;"),
        ("has no ramp", GOVERNOR,
         "return seconds(start_ns_) / Limits::kStart_s;", "return 1.0;"),
    ],
    "trip": [
        ("does not cut the force", ENERGY,
         "    force_N = released(record);\n", ""),
        ("ignores the device", GOVERNOR,
         "    if (sample_.asks_for_trip) trip(TripReason::kDevice, 0.0, 0.0, record);\n", ""),
        ("of an unstable loop does not count", ENERGY,
         "      record.rules |= kRuleTripped;\n", ""),
        ("counts each tick", GOVERNOR,
         "  if (is_tripped()) return;\n  status_.state", "  status_.state"),
    ],
    "heat": [
        ("does not warm with the square", HEAT,
         "? loads[i] * loads[i] : 1.0", "? std::abs(loads[i]) : 1.0"),
        ("does not cool", HEAT,
         "mean_square_[i] += share * (load2 - mean_square_[i]);",
         "mean_square_[i] += share * std::max(0.0, load2 - mean_square_[i]);"),
        ("has a third of the series only", HEAT, "(1.0 / 6 - x * ", "(0.0 / 6 - x * "),
        ("takes a long step for a short one", HEAT, "share *= 2.0 - share;", "share *= 2.0;"),
        ("has no limit", HEAT, "return factor2 < 1.0 ? std::sqrt(factor2) : 1.0;", "return 1.0;"),
        ("scales by the square", HEAT, "std::sqrt(factor2)", "factor2"),
        ("looks only at the last motor", HEAT,
         "factor2 = std::min(factor2, (1.0 - x) / load2 + x);",
         "factor2 = (1.0 - x) / load2 + x;"),
        ("has no fade", HEAT, "std::max(0.0, (1.0 - mean_square_[i]) / kFadeWidth)",
         "mean_square_[i] < 1.0 ? 1.0 : 0.0"),
        ("fades from half of the force", HEAT,
         "1.0 - HeatLimits::kFadeFrom * HeatLimits::kFadeFrom", "0.75"),
        ("is poisoned by a load that is not finite", HEAT,
         "std::isfinite(loads[i]) ? loads[i] * loads[i] : 1.0", "loads[i] * loads[i]"),
        ("takes the forces for the loads", MOTORS,
         "= rows_[n].dot(force_N) / continuous_N_[n];", "= rows_[n].dot(force_N);"),
        ("confuses the motors", MOTORS,
         "rows_[basis_.motors[static_cast<std::size_t>(i)]] = row *",
         "rows_[static_cast<std::size_t>(i)] = row *"),
        ("takes oblique motors for orthogonal ones", MOTORS,
         "      row -= basis_.of_motors(i, j) * rows_[basis_.motors[static_cast<std::size_t>(j)]];\n",
         ""),
        ("takes dependent motors for independent ones", MOTORS,
         "spans_all_ = std::abs(determinant) > kClearlyIndependent;", "spans_all_ = true;"),
        ("confuses the rows of three motors", MOTORS,
         "rows_[1] = directions_[2].cross(directions_[0]);",
         "rows_[1] = directions_[0].cross(directions_[2]);"),
        ("takes a large load for a small one", MOTORS,
         "0.25 * limits_N[n] * limits_N[n]", "25.0 * limits_N[n] * limits_N[n]"),
        ("does not cool in a pause", GOVERNOR,
         "    heat_.add(Vec3::Zero(), time.now_ns - paused_at_ns_ - step_ns_);\n", ""),
        ("keeps the share of a tick before", GOVERNOR, "  heat_share_ = 1.0;\n", ""),
    ],
    "release": [
        ("drops the hand", RELEASE, "  is_active_ = force_N.allFinite();\n", ""),
        ("keeps a force that is not finite", RELEASE, "force_N.allFinite()", "true"),
        ("keeps its force after a way that is not finite", RELEASE,
         "!way_m.allFinite() || ", ""),
        ("has no end", RELEASE, " || age_ns_ >= fall_ns_) stop();", ") stop();"),
        ("does not fall", RELEASE, "  age_ns_ += step_ns;\n", ""),
        ("pushes along the motion", RELEASE,
         "std::min(0.0, before_N_.dot(direction_))", "before_N_.dot(direction_)"),
        ("keeps the part across the motion", RELEASE,
         "resists_N = std::min(0.0, before_N_.dot(direction_)) * direction_;",
         "resists_N *= before_N_.dot(direction_) < 0.0 ? 1.0 : 0.0;"),
        ("leaves the span of the motors", RELEASE,
         "const Vec3 part_m = motors.part(way_m_);", "const Vec3 part_m = way_m_;"),
        ("leaves the span of motors that have turned", RELEASE,
         "motors.part(left * resists_N)", "left * resists_N"),
        ("begins with a jump", ENERGY,
         "has_just_tripped ? 0 : step_ns_, motors_)), record);\n  limit_slew(force_N, record);\n",
         "has_just_tripped ? 0 : step_ns_, motors_)), record);\n"),
        ("is too much for a warm motor", ENERGY,
         "cooled(\n      limited(release_.force(sensed_way_m_, has_just_tripped ? 0 : step_ns_, motors_)), "
         "record);",
         "limited(release_.force(sensed_way_m_, has_just_tripped ? 0 : step_ns_, motors_));"),
        ("is not told", ENERGY,
         "  if (!force_N.isZero(0.0)) record.rules |= kRuleRelease;\n", ""),
        ("trusts what is bad", ENERGY,
         "if (is_interrupted_ || sample_.asks_for_trip || (record.faults & kFaultNonFiniteForce) != 0) {",
         "if (false) {"),
        ("takes rounding for a motion", RELEASE,
         "quantum_m_ + kWayRounding * way_m_.norm()", "quantum_m_"),
        ("takes a step of the encoder for a motion", RELEASE,
         "quantum_m_ + kWayRounding * way_m_.norm()", "kWayRounding * way_m_.norm()"),
        ("drops a hand that rests", RELEASE, "Vec3 resists_N = before_N_;",
         "Vec3 resists_N = Vec3::Zero();"),
        ("swings with the hand", RELEASE,
         "++turns_ >= GentleReleaseLimits::kMostTurns", "false"),
        ("ends at the first turn", RELEASE,
         "++turns_ >= GentleReleaseLimits::kMostTurns", "true"),
        ("does not begin anew", RELEASE, "  age_ns_ = 0;\n", ""),
        ("does not count the turns anew", RELEASE, "  turns_ = 0;\n", ""),
        ("does not forget the motion of the last trip", RELEASE, "  has_moved_ = false;\n", ""),
        ("takes the way before the trip for its own", RELEASE, "step_ns > 0 && ", ""),
    ],
    "energy": [
        ("is not summed", ENERGY, "    status_.given_J += way_work_J_;\n", ""),
        ("by design is not summed", ENERGY,
         "    status_.given_J += way_work_J_;\n"
         "    status_.given_late_J += share * acted_late_N_.dot(way_m_);\n"
         "    status_.given_by_design_J += work_masked_N_.dot(way_m_);\n",
         "    status_.given_J += way_work_J_;\n"
         "    status_.given_late_J += share * acted_late_N_.dot(way_m_);\n"),
        ("has no delay", HISTORY, "return back(delay.whole);", "return back(0);"),
        ("takes the older force for the newer one", HISTORY,
         "delay.share * back(delay.whole + 1) + (1.0 - delay.share) * back(delay.whole)",
         "(1.0 - delay.share) * back(delay.whole + 1) + delay.share * back(delay.whole)"),
        ("is not that of the ticks without a sample", ENERGY,
         "    const double share = 1.0 / acted_ticks_;\n", "    const double share = 1.0;\n"),
    ],
    "damping": [
        ("is not given", ENERGY, "+ damping_N), record);", "), record);"),
        ("does not count", ENERGY, "    record.rules |= kRuleDamping;\n", ""),
        ("is twice the largest", CONTROL, "const double most = held_damping(tick.longest_hold_s);",
         "const double most = 2.0 * held_damping(tick.longest_hold_s);"),
        ("takes a leak for none", CONTROL,
         "account_J += leak_J - counted_damping_ * motion;",
         "account_J += -counted_damping_ * motion;"),
        ("counts no damping of the device", CONTROL,
         "account_J += leak_J - counted_damping_ * motion;", "account_J += leak_J;"),
        ("is not corrected when it acts", CONTROL,
         "    pay(share * since.damping_N.dot(way_m) - since.booked_J);\n", ""),
        ("is not booked", CONTROL, "  pay(booked_J_[booked_]);\n", ""),
        ("forgets nothing", CONTROL,
         "    if (end.account_J > 0.0) end.account_J -= forgotten_ * end.account_J;\n", ""),
        ("knows no delay", CONTROL,
         "{share * since.acting_N[0], share * since.acting_N[1]};", "{last_N, last_N};"),
        ("knows the least delay only", CONTROL,
         "{share * since.acting_N[0], share * since.acting_N[1]};",
         "{share * since.acting_N[0], share * since.acting_N[0]};"),
        ("knows the last tick of a way only", CONTROL,
         "{share * since.acting_N[0], share * since.acting_N[1]};",
         "{forces_.acting_N(delays_[0]), forces_.acting_N(delays_[1])};"),
        ("pushes along the motion", CONTROL, "held_N_ = -damping * along;",
         "held_N_ = damping * along;"),
        ("damps across the change of the force", CONTROL,
         "Vec3(velocity.dot(changed_N) / change2 * changed_N)", "velocity"),
        ("pulls into the surface", ENERGY,
         "    if (against > even2) damping_N *= even2 / against;\n", ""),
        ("leaves the span of the motors", ENERGY,
         "    damping_N = motors_.part(damping_N);\n", ""),
        ("lets a motor exceed its limit", ENERGY,
         "limited(warm_N + damping_N)", "(warm_N + damping_N)"),
        ("is too much for a warm motor", ENERGY,
         "force_N = cooled(limited(warm_N + damping_N), record);",
         "force_N = limited(even_N + damping_N);"),
        ("takes what the motors cannot push for a swing", ENERGY,
         "watched_N -= factor * motors_.part(sources.effects_N[0]);",
         "watched_N -= factor * sources.effects_N[0];"),
        ("takes a vibration for a swing", ENERGY,
         "  if (sources.has_effects) watched_N -= factor * motors_.part(sources.effects_N[0]);\n", ""),
        ("counts the device's damping after an interruption", CONTROL,
         "tick.is_disturbed ? 0.0 : device_.damping_Ns_per_m", "device_.damping_Ns_per_m"),
        ("is held over an interruption", CONTROL_H,
         "    count_ = 0;\n    held_N_.setZero();\n", "    count_ = 0;\n"),
        ("knows no long hold", CONTROL,
         "if (!(longest_hold_s > period_s_)) return most_damping_;", "return most_damping_;"),
        ("forgets its way too early", CONTROL, "    damped_ticks_ = booked_J_.size();\n",
         "    damped_ticks_ = 1;\n"),
        ("knows the change of the force only", CONTROL,
         "{way_m, acting_N[1] - even_N}, tick.way_s", "{way_m, tick.force_N - last_N}, tick.way_s"),
        ("never softens the contact", CONTROL,
         "if (judged_J_ > PassivityLimits::kSoften_J) {", "if (false) {"),
        ("never ends", CONTROL, "    is_active_ = false;\n", ""),
        ("never stiffens the next contact", CONTROL,
         "    stiffness_ = 1.0;\n    has_swung_ = false;\n", "    has_swung_ = false;\n"),
        ("trips without a force", CONTROL,
         "} else if (!tick.force_N.isZero(0.0)) {", "} else {"),
        ("never trips", CONTROL, "      unstable_s_ += period_s_;\n", ""),
    ],
    "steps": [
        ("count as jumps", PATH, "  if (!(quantum_m_ > 0.0)) return sensed_m;\n",
         "  return sensed_m;\n"),
        ("do not limit the path", PATH,
         "std::clamp(edge_m + speed_m_per_s * since_s + past_edge_m, at_m - half_m, at_m + half_m)",
         "edge_m + speed_m_per_s * since_s + past_edge_m"),
        ("have their edges where the device says", PATH,
         "const double to_edge_m = 0.5 * ", "const double to_edge_m = 0.0 * "),
        ("are damped along one axis", SPAN, "    sum_N2_ *= 1.0 - kForget;\n",
         "    sum_N2_.setZero();\n"),
        ("lengthen a velocity", SPAN, "part2 > most2 ?", "false ?"),
        ("know no damping", CONTROL,
         "const double known = has_steps() && samples_with_force_ > 0 ? known_damping(tick) : 0.0;",
         "const double known = 0.0;"),
    ],
    "swing": [
        ("is never seen", SWING, "swings = is_swing() &&", "swings = false &&"),
        ("is seen in what dies down", SWING,
         "sizes_N[0] > (1.0 - kLostShare) * sizes_N[kSteady - 1]", "true"),
        ("needs no regular time", SWING, "return most_s < kSteadyTime * least_s;", "return true;"),
        ("is seen in small ones", SWING, "&& sizes_N[0] > 2.0 * least_N", ""),
        ("has no end", SWING, "    count = 0;\n    swings = false;\n", ""),
    ],
    "restart": [
        ("withholds nothing", RESTART,
         "  if (withheld_N_ == 0.0) return 1.0;\n", "  return 1.0;\n"),
        ("gives all back after an interruption", RESTART,
         "  if (was_interrupted_) return 0.0;\n", "  if (was_interrupted_) return 1e9;\n"),
        ("has a tank without end", RESTART,
         "store_J = std::max(0.0, store_J - ", "store_J = std::max(0.0, store_J - 0.0 * "),
        ("gives back without end", RESTART,
         "    returning_J_ = left_J + tick.owed_J;\n", ""),
        ("does not follow a hand that retreats", RESTART,
         "    withheld_N_ = std::min(withheld_N_, tick.spring_N);\n", ""),
        ("forgets what a start held back", RESTART,
         "    withheld_N_ = std::max(withheld_N_, (1.0 - tick.share) * tick.spring_N);\n", ""),
        ("never gives back", RESTART, "    if (returning_N_ > 0.0) give_back(tick);\n", ""),
        ("lets no node push", RESTART,
         "  if (tick.nodes_moved) tank_J_ = std::min(kTank_J, tank_J_ + kNodePower_W * tick.step_s);\n",
         ""),
    ],
    "budget": [
        ("has no end", BUDGETS, "const double excess_J = std::max(0.0, -left_J);",
         "const double excess_J = 0.0 * left_J;"),
        ("has no power", BUDGETS, "+ budget.power_W * step_s - work_J", "- work_J"),
        ("grows without end", BUDGETS,
         "left_J_[n] = std::min(budget.tank_J, left_J + excess_J);",
         "left_J_[n] = left_J + excess_J;"),
        ("takes what the hand has put in for a gift", BUDGETS,
         "  if (stored_J_ >= 0.0) return take(EnergySource::kOther, 0.0, work.step_s);\n", ""),
    ],
}


def fail(text):
    sys.exit(f"governor_mutations_test: {text}")


def compile_options(build, root, source):
    """The compiler and its options for a source, which may be a part of a larger unit."""
    path = build / "compile_commands.json"
    if not path.exists():
        fail(f"{path} does not exist; expected a build directory (configure it first)")
    full = str(root / source)
    for entry in json.loads(path.read_text()):
        file = pathlib.Path(entry["file"])
        is_unit = file.parent.name == "Unity" and file.exists() and f'"{full}"' in file.read_text()
        if str(file) != full and not is_unit:
            continue
        words = shlex.split(entry["command"])
        # Without its own files and the precompiled headers, which were made of the unchanged ones.
        kept, skips = [], False
        for word in words:
            if not skips and word not in ("-o", "-c", "-include", "-Winvalid-pch"):
                kept.append(word)
            skips = word in ("-o", "-c", "-include")
        return kept
    fail(f"{path}: does not compile {full}; expected one of its sources (build the tests first)")


class Copy:
    """A copy of the governor in a folder of its own."""

    def __init__(self, root, build, folder):
        self.root, self.folder = root, folder
        self.options = {source: compile_options(build, root, source) for source in SOURCES}
        for source in SOURCES + HEADERS:
            (folder / source).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(root / source, folder / source)

    def object_of(self, source):
        return self.folder / (pathlib.Path(source).stem + ".o")

    def compile(self, sources):
        for source in sources:
            # A launcher such as ccache stands before the compiler.
            words = self.options[source]
            first = next(n for n, word in enumerate(words) if word.startswith("-"))
            command = [*words[:first], f"-I{self.folder}", *words[first:], "-w", "-c",
                       self.folder / source, "-o", self.object_of(source)]
            done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
            if done.returncode != 0:
                fail(f"{source} does not compile:\n{done.stderr}")

    def failed_with(self, source, old, new):
        """The names of the tests that fail with a replaced text. Restores the copy."""
        text = (self.root / source).read_text()
        users = SOURCES if source.endswith(".h") else [source]
        unchanged = {user: self.object_of(user).read_bytes() for user in users}
        (self.folder / source).write_text(text.replace(old, new))
        self.compile(users)
        failed = self.failed_tests()
        (self.folder / source).write_text(text)
        for user in users:
            self.object_of(user).write_bytes(unchanged[user])
        return failed

    def link(self):
        compiler, *options = self.options[TESTS[0]]
        program = self.folder / "governor_test"
        command = [compiler, *options, *map(self.object_of, SOURCES), "-lgtest_main", "-lgtest",
                   "-o", program]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        if done.returncode != 0:
            fail(f"the test does not link:\n{done.stderr}")
        return program

    def failed_tests(self):
        """The names of the tests that fail."""
        program = self.link()
        try:
            done = subprocess.run([program, "--gtest_brief=1"], capture_output=True, text=True,
                                  timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            return ["(no end)"]
        failed = [line.split("]")[1].split()[0].rstrip(",") for line in done.stdout.splitlines()
                  if line.startswith("[  FAILED  ] ") and "." in line]
        if done.returncode not in (0, 1) or (done.returncode == 1) != bool(failed):
            fail(f"the test ended with {done.returncode}; expected 0 or 1\n{done.stdout}"
                 f"{done.stderr}")
        return sorted(set(failed))


def check_texts(root):
    """Every text that a mutation replaces must be there once."""
    for rule, mutations in MUTATIONS.items():
        for name, source, old, _ in mutations:
            count = (root / source).read_text().count(old)
            if count != 1:
                fail(f"{source}: the text of the mutation \"{rule}: {name}\" is there {count} "
                     f"times; expected once (adapt MUTATIONS to the source)\n{old}")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    root, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    chosen = [(f"{rule}: {name}", *rest) for rule, mutations in MUTATIONS.items()
              for name, *rest in mutations]
    chosen = [entry for entry in chosen if entry[0].startswith(tuple(sys.argv[3:] or [""]))]
    check_texts(root)
    survivors = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(root, build, pathlib.Path(folder))
        copy.compile(SOURCES)
        failed = copy.failed_tests()
        if failed:
            fail(f"the unchanged governor fails: {' '.join(failed)}")
        for title, source, old, new in chosen:
            failed = copy.failed_with(source, old, new)
            print(f"{title}: {' '.join(failed) or 'SURVIVES'}", flush=True)
            if not failed:
                survivors.append(title)
    if survivors:
        fail("no test fails with these broken rules:\n  " + "\n  ".join(survivors))


if __name__ == "__main__":
    main()
