// The faces around a proxy at rest, and tests of whether they hold it: see god_object_escapes.h.

#include "haptics/proxy/god_object_escapes.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace palpate {
namespace {

// Distance in stand-offs within which a point counts as being at a vertex. A point that planes hold
// at a vertex is a few stand-offs away from it, depending on the angles between the planes.
constexpr double kAtVertexPerStandOff = 64.0;

// Rounding of a proxy's position, including its transformation to a body, relative to the scene's
// size.
constexpr double kPlaceRoundoff = 32 * std::numeric_limits<double>::epsilon();

// Rounding of a unit vector and of its product with another.
constexpr double kDirectionRoundoff = 8 * std::numeric_limits<double>::epsilon();

}  // namespace

double GodObject::place_roundoff_m() const {
  return kPlaceRoundoff * world_->size_m();
}

GodObject::Faces GodObject::holding_faces() const {
  Faces holding;
  for (int i = 0; i < step_.active_count(); ++i) holding.add(step_.active_contact(i));
  return holding;
}

// Finds the faces around the proxy, up to kMostAround, sorted by distance. The result is kept for
// the position, so that a repeated step does not search again.
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

// The contact with the nearest point of a face. The direction from a very near edge to the proxy
// has few exact digits, so its component along the edge is removed.
FaceContact GodObject::contact_of_nearest(const FaceRef& face) const {
  FaceContact nearest = tracer_.nearest_contact(face, proxy_);
  if (nearest.feature == TriangleFeature::kEdge) nearest.normal = tracer_.across_edge(nearest);
  return nearest;
}

// Whether the face of a contact is exactly under a point that touches it, so that every step
// against its normal approaches the face. False if the contact differs slightly from the triangle
// that decides.
bool GodObject::is_touched_face(const FaceContact& contact) const {
  return !is_beside_face(contact) && contact.clearance_m <= scale().stand_off_m &&
         tracer_.has_deciding_contacts(world_->body(contact.face.body));
}

// Whether a step in this direction approaches none of the touched faces, except for the rounding of
// their contact normals. The distance to a triangle is convex, so such a step approaches none of
// them at any length.
bool GodObject::falls_to_none(const Vec3& step, std::span<const FaceContact> touched) const {
  const double slope =
      kDirectionRoundoff + place_roundoff_m() / (tracer_.radius_m() + scale().stop_m);
  const double least = -slope * step.norm();
  return std::all_of(touched.begin(), touched.end(),
                     [&](const FaceContact& contact) { return contact.normal.dot(step) >= least; });
}

// Whether a touched face stops a step although the whole step approaches no touched face by more
// than rounding.
bool GodObject::is_stopped_by_rounding(const Vec3& step) {
  const auto touched = around_->all_touched();
  const bool falls = std::any_of(touched.begin(), touched.end(), [&](const FaceContact& contact) {
    return -contact.normal.dot(step) > place_roundoff_m();
  });
  if (falls) return false;
  const auto hit = tracer_.trace(proxy_, end_of_step(step));
  return hit && std::any_of(touched.begin(), touched.end(), [&](const FaceContact& contact) {
           return contact.face == hit->contact.face;
         });
}

// Whether the proxy is at a corner of one of the faces of these contacts.
bool GodObject::is_at_vertex(std::span<const FaceContact> contacts) const {
  const double near_m = kAtVertexPerStandOff * scale().stand_off_m;
  return std::any_of(contacts.begin(), contacts.end(), [&](const FaceContact& contact) {
    const ContactBody& body = world_->body(contact.face.body);
    TriangleGeometry buffer;
    const TriangleGeometry& t = body.triangle(contact.face.slot, buffer);
    const Vec3 p_body = body.to_body(proxy_);
    const double near = body.length_to_body(near_m);
    const auto is_near = [&](const Vec3& corner) {
      return (p_body - corner).squaredNorm() <= near * near;
    };
    return is_near(t.a) || is_near(t.b) || is_near(t.c);
  });
}

// The least displacement that lifts the proxy to SolverScale::stop_m above the planes of these
// faces without approaching any face around it. Zero if that displacement is too long.
Vec3 GodObject::lift_above(std::span<const FaceContact> faces,
                           std::span<const FaceContact> nearest) const {
  std::array<ContactPlane, kMaxContactPlanes> planes;
  std::size_t count = 0;
  const auto add = [&](const Vec3& normal, double offset_m) {
    const auto kept = within_plane(ContactPlane{normal, offset_m}, motion_plane_);
    if (kept) planes[count++] = *kept;
  };
  for (const FaceContact& face : faces) add(face.normal, scale().stop_m - face.clearance_m);
  for (const FaceContact& contact : nearest) {
    add(contact.normal, std::min(0.0, scale().stop_m - contact.clearance_m));
  }
  const PlaneProjection lift = least_displacement(std::span(planes).first(count), motion_plane_);
  const double most_m = kAtVertexPerStandOff * scale().stand_off_m;
  const bool is_near = lift.solved && lift.displacement_m.squaredNorm() <= most_m * most_m;
  return is_near ? lift.displacement_m : Vec3(Vec3::Zero());
}

}  // namespace palpate
