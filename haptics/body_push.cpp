#include "haptics/body_push.h"

#include <array>

#include "haptics/plane_projection.h"

namespace palpate {
namespace {

// A push that is stopped is shortened at most so often; then the proxy keeps its very place on the
// body.
constexpr int kMaxShortenings = 8;

// One body that moves, and what the proxy has met of it and of others.
class Push {
 public:
  Push(SegmentTracer& tracer, std::uint32_t body, const ContactBody& placed, const Vec3& start_body,
       const Vec3& proxy, const std::optional<Vec3>& motion_plane_normal)
      : tracer_(tracer),
        body_(body),
        placed_(placed),
        start_body_(start_body),
        proxy_(proxy),
        motion_plane_normal_(motion_plane_normal) {}

  // The nearest place from which neither the body nor any other keeps the proxy.
  std::optional<Vec3> to_nearest_place() {
    Vec3 target = proxy_;
    for (int met = 0; met <= kMaxContactPlanes; ++met) {
      const auto hit = first_obstacle(target);
      if (!hit) return target;
      if (met == kMaxContactPlanes || !add_plane(*hit)) return std::nullopt;
      const auto planes = std::span(planes_).first(static_cast<std::size_t>(plane_count_));
      const PlaneProjection least =
          project_onto_planes(planes, Vec3::Zero(), Feasibility::kMustMove);
      if (!least.solved) return std::nullopt;
      target = proxy_ + least.displacement_m;
    }
    return std::nullopt;
  }

  // Where the proxy gets when it sticks to the body from where it is met.
  std::optional<Vec3> carried() {
    Vec3 along_body = placed_.to_body(proxy_) - start_body_;
    double fraction = 1.0;
    for (int shortened = 0; shortened <= kMaxShortenings + 1; ++shortened) {
      const Vec3 target = placed_.to_solver(start_body_ + fraction * along_body);
      const auto hit = tracer_.trace_in_body(body_, start_body_, placed_.to_body(target));
      if (!hit) {
        if (tracer_.trace_others(body_, proxy_, target)) return std::nullopt;
        return target;
      }
      fraction *= shortened < kMaxShortenings ? hit->fraction : 0.0;
    }
    return std::nullopt;
  }

 private:
  struct Obstacle {
    Vec3 normal;      // solver frame, towards the proxy
    double offset_m;  // of the displacement from proxy_, along the normal
  };

  std::optional<Obstacle> first_obstacle(const Vec3& target) {
    const double stand_off = tracer_.scale().stand_off_m;
    const Vec3 target_body = placed_.to_body(target);
    if (const auto hit = tracer_.trace_in_body(body_, start_body_, target_body)) {
      const Vec3 stop =
          placed_.to_solver(start_body_ + hit->fraction * (target_body - start_body_));
      const Vec3& normal = hit->contact.normal;
      return Obstacle{normal, normal.dot(stop - proxy_) + stand_off - hit->contact.clearance_m};
    }
    if (target == proxy_) return std::nullopt;
    if (const auto hit = tracer_.trace_others(body_, proxy_, target)) {
      const Vec3& normal = hit->contact.normal;
      const Vec3 stop_from_proxy = hit->fraction * (target - proxy_);
      const double room = hit->contact.clearance_m - stand_off - normal.dot(stop_from_proxy);
      return Obstacle{normal, std::min(0.0, -room)};
    }
    return std::nullopt;
  }

  // False if the plane cannot push the proxy within its plane of motion.
  bool add_plane(const Obstacle& obstacle) {
    Vec3 normal = obstacle.normal;
    double offset_m = obstacle.offset_m;
    if (motion_plane_normal_) {
      normal -= normal.dot(*motion_plane_normal_) * *motion_plane_normal_;
      const double in_plane = normal.norm();
      if (in_plane < kMinInPlaneNormal) return false;
      normal /= in_plane;
      offset_m /= in_plane;
    }
    planes_[static_cast<std::size_t>(plane_count_++)] = {normal, offset_m};
    return true;
  }

  SegmentTracer& tracer_;
  std::uint32_t body_;
  const ContactBody& placed_;  // where it is to be
  Vec3 start_body_;            // the proxy, in the frame of the body before it moved
  Vec3 proxy_;                 // solver frame
  std::optional<Vec3> motion_plane_normal_;
  std::array<ContactPlane, kMaxContactPlanes> planes_{};
  int plane_count_ = 0;
};

}  // namespace

bool push_proxy(LiveWorld& world, SegmentTracer& tracer, std::uint32_t body,
                const RigidTransform& T_solver_body, const std::optional<Vec3>& motion_plane_normal,
                Vec3& proxy) noexcept {
  const RigidTransform before = world.body(body).T_solver_body;
  const Vec3 start_body = world.body(body).to_body(proxy);
  const bool was_moving = world.is_moving(body);
  if (!world.place(body, T_solver_body)) return false;
  if (!was_moving) tracer.forget_candidates();
  Push push(tracer, body, world.body(body), start_body, proxy, motion_plane_normal);
  std::optional<Vec3> target = push.to_nearest_place();
  if (!target && !motion_plane_normal) target = push.carried();
  if (!target) {
    world.place(body, before);
    return false;
  }
  proxy = *target;
  return true;
}

}  // namespace palpate
