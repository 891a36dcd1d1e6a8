// What is around a proxy that may have a way on: see god_object_ways.h.

#include "haptics/proxy/god_object_ways.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace palpate {
namespace {

// A point held by planes at a vertex is within a few stand-offs of it, by the angles between them.
constexpr double kAtVertexPerStandOff = 64.0;

// Planes taken in, one after the other, of many that may hold a proxy.
constexpr int kMostExchanges = 64;

// How far the place of a proxy is rounded, and what it is brought to a body by, of the scene's
// size.
constexpr double kPlaceRoundoff = 32 * std::numeric_limits<double>::epsilon();

// A unit vector, and its product with another.
constexpr double kDirectionRoundoff = 8 * std::numeric_limits<double>::epsilon();

}  // namespace

double GodObject::place_roundoff_m() const {
  return kPlaceRoundoff * world_->size_m();
}

GodObject::Faces GodObject::holding_faces() const {
  Faces holding;
  for (int i = 0; i < projection_.active_count; ++i) holding.add(contacts_[projection_.active[i]]);
  return holding;
}

// Of any number of contacts takes the planes that hold the proxy: while one of them is violated,
// the most violated one comes in.
void GodObject::hold_by_most_violated(std::span<const FaceContact> contacts) {
  plane_count_ = 0;
  projection_ = project_onto_planes({}, goal_ - proxy_);
  for (int left = kMostExchanges; left > 0; --left) {
    const FaceContact* most = nullptr;
    double by_m = 0.0;
    for (const FaceContact& contact : contacts) {
      const double room_m = std::max(0.0, contact.clearance_m - scale().stop_m);
      const double violation_m = -room_m - contact.normal.dot(projection_.displacement_m);
      if (violation_m <= by_m) continue;
      by_m = violation_m;
      most = &contact;
    }
    if (!most || !add_plane(*most)) return;
    projection_ = project_onto_planes(planes(), goal_ - proxy_);
    if (!projection_.solved) return;
  }
}

// Of much that is around, only so many can be tried: the nearest are the first. A step that is
// taken again knows them.
void GodObject::look_around() {
  Surroundings& around = *around_;
  if (around.of == proxy_) return;
  const double near_m = (tracer_.radius_m() > 0.0 ? 1.0 : kAroundPerStandOff) * scale().stand_off_m;
  around.count = tracer_.contacts_around(proxy_, tracer_.radius_m() + near_m, around.faces);
  around.of.reset();
  if (tracer_.is_cut_short()) return;
  around.of = proxy_;
  std::array<std::size_t, kMostAround> order;
  for (std::size_t i = 0; i < around.count; ++i) {
    order[i] = i;
    around.scratch[i] = contact_of_nearest(around.faces[i].face);
  }
  const auto is_nearer = [&](std::size_t a, std::size_t b) {
    return std::pair(around.scratch[a].clearance_m, a) <
           std::pair(around.scratch[b].clearance_m, b);
  };
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(around.count), is_nearer);
  for (std::size_t i = 0; i < around.count; ++i) around.nearest[i] = around.scratch[order[i]];
  for (std::size_t i = 0; i < around.count; ++i) around.scratch[i] = around.faces[order[i]];
  std::copy_n(around.scratch.begin(), around.count, around.faces.begin());
  const auto is_touched = [&](const FaceContact& contact) {
    return contact.clearance_m <= scale().stand_off_m;
  };
  const auto all = around.all_nearest();
  const auto end = std::partition_point(all.begin(), all.end(), is_touched);
  around.touched_count = static_cast<std::size_t>(end - all.begin());
}

// So near to an edge, the direction to it has few digits. Its own has them all.
FaceContact GodObject::contact_of_nearest(const FaceRef& face) const {
  FaceContact nearest = tracer_.nearest_contact(face, proxy_);
  if (nearest.feature == TriangleFeature::kEdge) {
    const Vec3 edge = tracer_.edge_direction(nearest);
    nearest.normal = (nearest.normal - nearest.normal.dot(edge) * edge).normalized();
  }
  return nearest;
}

// Whether a face is where its contact says, under a point that touches it: a step that falls to it
// comes nearer to it then. Corners in the solver frame are not quite where the contact is.
bool GodObject::is_touched_face(const FaceContact& contact) const {
  return !is_beside_face(contact) && contact.clearance_m <= scale().stand_off_m &&
         !tracer_.decides_by_corners(world_->body(contact.face.body));
}

// Whether the faces that hold a point prove that nothing leads on: the steepest descent that falls
// to none of them gains little. To come nearer to a face by rounding is not to fall: between faces
// that are nearly parallel that leads far.
bool GodObject::is_held_by(std::span<const FaceContact> holding) const {
  std::array<ContactPlane, 3> planes;
  for (std::size_t i = 0; i < holding.size(); ++i) {
    if (!is_touched_face(holding[i])) return false;
    planes[i] = {plane_normal(i), -place_roundoff_m()};
  }
  const PlaneProjection descent =
      project_onto_planes(std::span(planes).first(holding.size()), goal_ - proxy_);
  return descent.solved && !may_gain_by(descent.displacement_m);
}

// The same of all faces that it touches. The search for those that hold may end with some of them,
// which leave more to gain.
bool GodObject::is_held_by_faces() {
  auto& faces = around_->scratch;
  std::size_t count = 0;
  for (const FaceContact& contact : around_->all_touched()) {
    if (!is_touched_face(contact)) continue;
    faces[count] = contact;
    faces[count++].clearance_m = scale().stop_m + place_roundoff_m();
  }
  hold_by_most_violated(std::span(faces).first(count));
  return projection_.solved && !may_gain_by(projection_.displacement_m);
}

// Whether a step in this direction falls towards none of what is touched, but for the rounding of
// the directions from there to the proxy. The distance to a triangle is convex, so then it comes
// nearer to none of it however long it is.
bool GodObject::falls_to_none(const Vec3& step, std::span<const FaceContact> touched) const {
  const double slope =
      kDirectionRoundoff + place_roundoff_m() / (tracer_.radius_m() + scale().stop_m);
  const double least = -slope * step.norm();
  return std::all_of(touched.begin(), touched.end(),
                     [&](const FaceContact& contact) { return contact.normal.dot(step) >= least; });
}

// Whether a step is stopped by a face that it touches, though all of it comes nearer to none of
// those by more than rounding.
bool GodObject::is_stopped_by_rounding(const Vec3& step) {
  const auto touched = around_->all_touched();
  const bool falls = std::any_of(touched.begin(), touched.end(), [&](const FaceContact& contact) {
    return -contact.normal.dot(step) > place_roundoff_m();
  });
  if (falls) return false;
  const auto hit = tracer_.trace(proxy_, within_bounds(proxy_ + step));
  return hit && std::any_of(touched.begin(), touched.end(), [&](const FaceContact& contact) {
           return contact.face == hit->contact.face;
         });
}

// Whether a point rests at a corner of one of the faces that hold it.
bool GodObject::is_at_vertex(std::span<const FaceContact> contacts) const {
  const double near_m = kAtVertexPerStandOff * scale().stand_off_m;
  return std::any_of(contacts.begin(), contacts.end(), [&](const FaceContact& contact) {
    const ContactBody& body = world_->body(contact.face.body);
    TriangleGeometry room;
    const TriangleGeometry& t = body.triangle(contact.face.slot, room);
    const Vec3 p_body = body.to_body(proxy_);
    const double near = body.length_to_body(near_m);
    const auto is_near = [&](const Vec3& corner) {
      return (p_body - corner).squaredNorm() <= near * near;
    };
    return is_near(t.a) || is_near(t.b) || is_near(t.c);
  });
}

// The least displacement that puts the proxy a stop above the planes of these faces and brings it
// nearer to none around. Zero if there is none near by.
Vec3 GodObject::lift_above(std::span<const FaceContact> faces,
                           std::span<const FaceContact> nearest) const {
  std::array<ContactPlane, kMaxContactPlanes> planes;
  std::size_t count = 0;
  const auto add = [&](const Vec3& normal, double offset_m) {
    const ContactPlane plane{normal, offset_m};
    const auto kept = motion_plane_normal_ ? within_plane(plane, *motion_plane_normal_)
                                           : std::optional<ContactPlane>(plane);
    if (kept) planes[count++] = *kept;
  };
  for (const FaceContact& face : faces) add(face.normal, scale().stop_m - face.clearance_m);
  for (const FaceContact& contact : nearest) {
    add(contact.normal, std::min(0.0, scale().stop_m - contact.clearance_m));
  }
  const PlaneProjection lift =
      project_onto_planes(std::span(planes).first(count), Vec3::Zero(), Feasibility::kMustMove);
  const double most_m = kAtVertexPerStandOff * scale().stand_off_m;
  const bool is_near = lift.solved && lift.displacement_m.squaredNorm() <= most_m * most_m;
  return is_near ? lift.displacement_m : Vec3(Vec3::Zero());
}

}  // namespace palpate
