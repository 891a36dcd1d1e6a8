#include "haptics/proxy/body_push.h"

#include <algorithm>
#include <array>

#include "haptics/proxy/plane_projection.h"

namespace palpate {
namespace {

// A stopped push is shortened at most this many times; then the proxy keeps exactly its position on
// the body.
constexpr int kMostShortenedPushes = 8;

// Largest length of a push, relative to the body's motion at the proxy. Planes that close at less
// than about one degree therefore hold the proxy.
constexpr double kFarthestPerMotion = 64.0;

// The search for a new position of the proxy while one body moves, with the contact planes met.
class PushedProxy {
 public:
  PushedProxy(SegmentTracer& tracer, const Push& push, const ContactBody& placed,
              const Vec3& start_body, const Vec3& proxy)
      : tracer_(tracer), push_(push), placed_(placed), start_body_(start_body), proxy_(proxy) {}

  // The nearest position that neither the moving body nor another body blocks.
  std::optional<Vec3> to_nearest_place() {
    Vec3 target = proxy_;
    for (int met = 0; met <= kMaxContactPlanes; ++met) {
      const auto hit = first_obstacle(target);
      if (tracer_.is_cut_short()) return std::nullopt;
      if (!hit) return target;
      if (met == kMaxContactPlanes || !add_plane(*hit)) return std::nullopt;
      const auto planes = std::span(planes_).first(static_cast<std::size_t>(plane_count_));
      const PlaneProjection least = least_displacement(planes, push_.motion_plane);
      if (!least.solved) return std::nullopt;
      target = in_motion_plane(proxy_ + least.displacement_m);
      if (is_far(target)) return std::nullopt;
    }
    return std::nullopt;
  }

  // The position that the proxy had relative to the body, if the proxy can reach it.
  std::optional<Vec3> kept_place() {
    const Vec3 target = in_motion_plane(placed_.to_solver(start_body_));
    if (push_.motion_plane &&
        tracer_.trace_in_body(push_.body, start_body_, placed_.to_body(target))) {
      return std::nullopt;
    }
    if (tracer_.trace_others(push_.body, proxy_, target)) return std::nullopt;
    return target;
  }

  // The position that the proxy reaches if it sticks to the body from the point where they meet.
  std::optional<Vec3> carried() {
    Vec3 along_body = placed_.to_body(proxy_) - start_body_;
    double fraction = 1.0;
    for (int shortened = 0; shortened <= kMostShortenedPushes + 1; ++shortened) {
      const Vec3 target = placed_.to_solver(start_body_ + fraction * along_body);
      const auto hit = tracer_.trace_in_body(push_.body, start_body_, placed_.to_body(target));
      if (!hit) {
        if (tracer_.trace_others(push_.body, proxy_, target)) return std::nullopt;
        return target;
      }
      fraction *= shortened < kMostShortenedPushes ? hit->fraction.value() : 0.0;
    }
    return std::nullopt;
  }

 private:
  // The first obstacle of the proxy, as a contact plane for displacements from its position.
  std::optional<ContactPlane> first_obstacle(const Vec3& target) {
    const double stop_m = tracer_.scale().stop_m;
    const Vec3 target_body = placed_.to_body(target);
    if (const auto hit = tracer_.trace_in_body(push_.body, start_body_, target_body)) {
      const Vec3 stop =
          placed_.to_solver(start_body_ + hit->fraction.value() * (target_body - start_body_));
      const Vec3& normal = hit->contact.normal;
      return ContactPlane{normal, normal.dot(stop - proxy_) + stop_m - hit->contact.clearance_m};
    }
    if (target == proxy_) return std::nullopt;
    if (const auto hit = tracer_.trace_others(push_.body, proxy_, target)) {
      const Vec3& normal = hit->contact.normal;
      const Vec3 stop_from_proxy = hit->fraction.value() * (target - proxy_);
      const double room = hit->contact.clearance_m - stop_m - normal.dot(stop_from_proxy);
      return ContactPlane{normal, std::min(0.0, -room)};
    }
    return std::nullopt;
  }

  // Whether the push is too long. Two planes that close on the proxy squeeze it out, the farther
  // the smaller the angle between them, and without limit. Beyond the limit the proxy has no space.
  bool is_far(const Vec3& target) const {
    const Vec3 stuck = placed_.to_solver(start_body_);
    const double moved_m = (stuck - proxy_).norm() + 4 * tracer_.scale().stand_off_m;
    const double farthest_m = kFarthestPerMotion * moved_m;
    return (target - proxy_).squaredNorm() > farthest_m * farthest_m;
  }

  // The point of the plane of motion nearest to p. The rounding of many pushes does not add up.
  Vec3 in_motion_plane(const Vec3& p) const {
    return push_.motion_plane ? push_.motion_plane->nearest(p, push_.plane_point) : p;
  }

  // Adds a plane. False if the plane cannot push the proxy within the plane of motion.
  bool add_plane(const ContactPlane& plane) {
    const std::optional<ContactPlane> pushing = within_plane(plane, push_.motion_plane);
    if (pushing) planes_[static_cast<std::size_t>(plane_count_++)] = *pushing;
    return pushing.has_value();
  }

  SegmentTracer& tracer_;
  const Push& push_;
  const ContactBody& placed_;  // the body at its target pose
  Vec3 start_body_;            // proxy relative to the body before the motion, body frame
  Vec3 proxy_;                 // solver frame
  std::array<ContactPlane, kMaxContactPlanes> planes_{};
  int plane_count_ = 0;
};

}  // namespace

bool push_proxy(LiveWorld& world, SegmentTracer& tracer, const Push& push, Vec3& proxy) noexcept {
  const RigidTransform before = world.body(push.body).T_solver_body;
  const Vec3 start_body = world.body(push.body).to_body(proxy);
  const bool was_moving = world.is_moving(push.body);
  if (!world.place(push.body, push.T_solver_body)) return false;
  if (!was_moving) tracer.forget_candidates();
  PushedProxy pushed(tracer, push, world.body(push.body), start_body, proxy);
  std::optional<Vec3> target;
  if (push.carries) target = pushed.kept_place();
  if (!target) target = pushed.to_nearest_place();
  if (!target && !push.motion_plane) target = pushed.carried();
  if (!target) {
    world.place(push.body, before);
    return false;
  }
  proxy = *target;
  return true;
}

}  // namespace palpate
