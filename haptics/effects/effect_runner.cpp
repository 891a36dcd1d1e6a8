#include "haptics/effects/effect_runner.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>

#include "haptics/proxy/plane_projection.h"

namespace palpate {
namespace {

// The most boxes that are examined one by one, and the number of ticks between two examinations.
constexpr std::size_t kMostBoxes = 32;
constexpr int kTicksBetweenSearches = 16;

}  // namespace

EffectRunner::EffectRunner(const ContactWorld& world, const GodObjectSettings& proxy,
                           const CouplingSettings& coupling, bool measures_time)
    : program_(world.effects.get()),
      coupling_(coupling),
      measures_time_(measures_time),
      parameters_(program_->parameters),
      states_(program_->state_bytes),
      work_(proxy.accuracy.effects_budget(), proxy.accuracy.counting),
      has_budget_(proxy.accuracy.counting != CountingRule::kFirst),
      order_(program_->places.count),
      place_forces_N_(program_->places.count, Vec3::Zero()) {
  tick_.radius_m = proxy.radius_m;
  reset_states();
  const auto effects = compiled_effects();
  for (std::size_t n = 0; n < effects.size(); ++n) {
    const auto* place = std::find(kGivingEffects.begin(), kGivingEffects.end(), effects[n].name);
    giving_of_[n] = static_cast<std::uint8_t>(place - kGivingEffects.begin());
  }
  for (std::size_t b = 0; b < program_->bodies.size(); ++b) {
    if (!program_->bodies[b].attributes) continue;
    const Box box = world.bodies[b].box_solver();
    if (boxes_.size() < kMostBoxes) {
      boxes_.push_back(box);
    } else {
      boxes_.back() = boxes_.back().united(box);
    }
  }
}

void EffectRunner::find_far_reach(const LiveWorld& world, const Vec3& proxy,
                                  double touch_m) noexcept {
  ticks_to_search_ = kTicksBetweenSearches;
  double reach_m = world.size_m();
  if (program_->places.count != 0) {
    const double left_m = quiet_radius_m_ - (proxy - quiet_centre_).norm();
    if (left_m < 0.5 * quiet_radius_m_) {  // the next tick renews the quiet ball
      quiet_radius_m_ = 0.0;
      ticks_to_search_ = 0;
      return;
    }
    reach_m = std::min(reach_m, left_m);
  }
  for (const Box& box : boxes_) {
    reach_m = std::min(reach_m, std::sqrt(box.squared_distance(proxy)));
  }
  reach_m -= touch_m;
  far_centre_ = proxy;
  far_reach_m_ = std::max(0.0, 0.5 * reach_m);
}

void EffectRunner::reset_states() noexcept {
  for (const EffectCall& call : program_->calls) {
    compiled_effects()[call.effect].begin_state(states_.data() + call.state);
  }
}

std::uint32_t EffectRunner::end_tick() noexcept {
  for (std::uint32_t left = active_; left != 0; left &= left - 1) {
    ++counters_.ticks[static_cast<std::size_t>(std::countr_zero(left))];
  }
  return active_;
}

void EffectRunner::run_one(const EffectCall& call, EffectTick& tick) noexcept {
  const Vec3 before_N = tick.force_N;
  const auto active =
      call.apply(parameters_.data() + call.parameters, states_.data() + call.state, tick);
  active_ |= static_cast<std::uint32_t>(active) << call.effect;
  const std::uint8_t place = giving_of_[call.effect];
  if (!active || place == kGivesNothing) return;
  giving_[place] += tick.force_N - before_N;
  gives_ = true;
}

void EffectRunner::run(std::span<const EffectCall> table, EffectTick& tick) noexcept {
  if (!measures_time_) {
    for (const EffectCall& call : table) run_one(call, tick);
    return;
  }
  for (const EffectCall& call : table) {
    const auto start = std::chrono::steady_clock::now();
    run_one(call, tick);
    const std::chrono::nanoseconds time = std::chrono::steady_clock::now() - start;
    counters_.time_ns[call.effect] += time.count();
  }
}

FacePoint EffectRunner::face_point(const LiveWorld& world, const FaceContact& contact,
                                   const Vec3& proxy) const noexcept {
  const ContactBody& body = world.body(contact.face.body);
  // If the contact is on the face itself, its point is the proxy. At an edge or vertex it is the
  // touched feature's point, which differs for spheres.
  const bool is_face = contact.feature == TriangleFeature::kFace;
  return {&body, program_->bodies[contact.face.body].attributes, contact.face.slot,
          body.to_body(is_face ? proxy : contact.feature_point)};
}

FrictionCone EffectRunner::friction_cone(const LiveWorld& world, const FaceContact& contact,
                                         const Vec3& proxy) noexcept {
  const std::uint32_t m = program_->material(contact.face.body, contact.face.slot);
  if (program_->materials[m].without_effects) return {};
  const auto table = program_->table(m, EffectStage::kProxy);
  if (table.empty()) return {};
  tick_.cone = {};
  tick_.face = face_point(world, contact, proxy);
  tick_.normal = contact.normal;
  const std::uint32_t active = active_;
  run(table, tick_);
  held_ |= active_;  // includes tried faces that do not hold the proxy in the end
  active_ = active;
  return tick_.cone;
}

EffectTick& EffectRunner::prepared(const ProxyState& state, const EffectMotion& motion) noexcept {
  tick_.dt_s = motion.dt_s;
  tick_.longest_dt_s = motion.longest_dt_s;
  tick_.ticks = motion.ticks;
  tick_.steady_ticks = motion.steady_ticks;
  tick_.time_s = motion.time_s;
  tick_.has_measured_times = motion.has_measured_times;
  tick_.proxy_m = state.proxy;
  tick_.velocity_m_per_s = motion.velocity_m_per_s;
  tick_.slid = state.slid;
  tick_.force_N.setZero();
  return tick_;
}

// The fast path for a single face without effects, which is the most frequent contact.
bool EffectRunner::touches_face_without_effects(std::span<const FaceContact> contacts) noexcept {
  if (contacts.size() != 1) return false;
  const FaceRef& face = contacts[0].face;
  const std::uint32_t m = program_->material(face.body, face.slot);
  if (!program_->materials[m].without_effects) return false;
  touches_[0] = {face.body, m, contacts[0].normal};
  touch_count_ = 1;
  return true;
}

void EffectRunner::find_touches(const ContactView& contact, const Vec3& lag_m) noexcept {
  const std::span<const FaceContact> contacts = contact.contacts();
  touch_count_ = contacts.size();
  material_count_ = 0;
  std::array<Vec3, 3> normals;
  for (std::size_t i = 0; i < touch_count_; ++i) normals[i] = contact.plane_normal(i);
  shares_ = bearing_shares(lag_m, std::span(normals).first(touch_count_));
  for (std::size_t i = 0; i < touch_count_; ++i) {
    const FaceRef& face = contacts[i].face;
    const std::uint32_t m = program_->material(face.body, face.slot);
    touches_[i] = {face.body, m, contacts[i].normal};
    const auto known =
        std::find_if(materials_.begin(), materials_.begin() + material_count_,
                     [&](const TouchedMaterial& touched) { return touched.material == m; });
    if (known != materials_.begin() + material_count_) {
      known->share += shares_[i];
    } else {
      materials_[material_count_++] = {m, shares_[i]};
    }
  }
}

ContactResponse EffectRunner::evaluate_contact(const ContactView& contact, const ProxyState& state,
                                               const EffectMotion& motion) noexcept {
  ContactResponse response;
  response.normal = state.normal;
  response.coupling = coupling_;
  touch_count_ = 0;
  material_count_ = 0;
  if (!state.in_contact || contact.contacts().empty()) return response;
  if (state.is_held) active_ |= held_;
  if (touches_face_without_effects(contact.contacts())) return response;
  find_touches(contact, state.proxy - motion.goal_m);
  const auto touched = std::span(materials_).first(material_count_);
  if (std::all_of(touched.begin(), touched.end(), [&](const TouchedMaterial& m) {
        return program_->materials[m.material].without_effects;
      })) {
    return response;
  }

  response.without_effects = false;
  response.coupling = {0.0, 0.0};
  Vec3 normals = Vec3::Zero();
  bool is_shaded = false;
  EffectTick& tick = prepared(state, motion);
  for (std::size_t i = 0; i < touch_count_; ++i) {
    const FaceContact& face = contact.contacts()[i];
    const double share = shares_[i];
    tick.share = share;
    tick.normal = contact.plane_normal(i);
    tick.rendered_normal = tick.normal;
    tick.height_m = 0.0;
    tick.slope.setZero();
    tick.coupling = coupling_;
    const std::uint32_t m = touches_[i].material;
    if (!program_->materials[m].without_effects) {
      tick.face = face_point(contact.world(), face, state.proxy);
      run(program_->table(m, EffectStage::kSurface), tick);
      run(program_->table(m, EffectStage::kForceMap), tick);
    }
    is_shaded = is_shaded || tick.rendered_normal != tick.normal;
    normals += tick.rendered_normal;
    response.height_m += share * tick.height_m;
    response.slope += share * tick.slope;
    response.coupling.stiffness_N_per_m += share * tick.coupling.stiffness_N_per_m;
    response.coupling.damping_Ns_per_m += share * tick.coupling.damping_Ns_per_m;
  }
  if (is_shaded && normals.dot(state.normal) > 0.0) response.normal = normals.normalized();
  return response;
}

Vec3 EffectRunner::contact_force_N(const ProxyState& state, const ContactResponse& response,
                                   const EffectMotion& motion) noexcept {
  EffectTick& tick = prepared(state, motion);
  for (std::size_t i = 0; i < material_count_; ++i) {
    const auto table = program_->table(materials_[i].material, EffectStage::kForceAdd);
    if (table.empty()) continue;
    tick.normal = response.normal;
    tick.share = materials_[i].share;
    run(table, tick);
  }
  return tick.force_N;
}

Vec3 EffectRunner::surroundings_force_N(const LiveWorld& world, const ProxyState& state,
                                        const Vec3& normal, const EffectMotion& motion) noexcept {
  const std::span<const EffectCall> everywhere = program_->table(program_->everywhere);
  const std::span<const EffectCall> places = program_->table(program_->places);
  const bool is_quiet =
      (state.proxy - quiet_centre_).squaredNorm() < quiet_radius_m_ * quiet_radius_m_ &&
      world.moving().empty();
  if (everywhere.empty() && (places.empty() || is_quiet)) return Vec3::Zero();
  EffectTick& tick = prepared(state, motion);
  tick.normal = normal;
  tick.world = &world;
  tick.touches = std::span(touches_).first(touch_count_);
  run(everywhere, tick);
  if (is_quiet) return tick.force_N;
  quiet_centre_ = state.proxy;
  quiet_radius_m_ = world.size_m();
  run_places(places, tick);
  return tick.force_N;
}

void EffectRunner::run_place(const EffectCall& call, EffectTick& tick) noexcept {
  tick.quiet_m = 0.0;
  tick.is_capped = false;
  run(std::span(&call, 1), tick);
  quiet_radius_m_ = std::min(quiet_radius_m_, tick.quiet_m);
  is_capped_ = is_capped_ || tick.is_capped;
}

// The nearest places are searched first. The forces add in the order of the calls, so that their
// sum does not depend on the distances.
void EffectRunner::run_places(std::span<const EffectCall> places, EffectTick& tick) noexcept {
  work_.begin_tick();
  tick.work = has_budget_ ? &work_ : nullptr;
  if (!has_budget_ || places.size() == 1) {
    for (const EffectCall& call : places) run_place(call, tick);
    return;
  }
  work_.add_of_solver(Work::kPlace, places.size());
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    const EffectCall& call = places[i];
    order_[i] = {compiled_effects()[call.effect].distance_m(parameters_.data() + call.parameters,
                                                            states_.data() + call.state, tick),
                 i};
  }
  const Vec3 force_before_N = tick.force_N;
  std::make_heap(order_.begin(), order_.end());
  for (auto end = order_.end(); end != order_.begin(); --end) {
    std::pop_heap(order_.begin(), end);
    const std::uint32_t i = (end - 1)->call;
    tick.force_N.setZero();
    run_place(places[i], tick);
    place_forces_N_[i] = tick.force_N;
  }
  tick.force_N = force_before_N;
  for (const Vec3& force_N : place_forces_N_) tick.force_N += force_N;
}

void EffectRunner::set_parameters(std::uint32_t call,
                                  std::span<const std::byte> parameters) noexcept {
  std::copy(parameters.begin(), parameters.end(),
            parameters_.begin() + program_->calls[call].parameters);
  quiet_radius_m_ = 0.0;
  far_reach_m_ = 0.0;
}

}  // namespace palpate
