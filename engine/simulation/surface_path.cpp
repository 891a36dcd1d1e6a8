#include "engine/simulation/surface_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/simulation/scene_faces.h"
#include "engine/simulation/scene_sight.h"

namespace palpate {
namespace {

// The number of random start points drawn; how many of these are tried; the headings tried at a
// turn.
constexpr int kMostPlaces = 64;
constexpr std::size_t kMostStarts = 8;
constexpr int kMostHeadings = 22;
constexpr int kEdgeHeadings = 6;  // the last of kMostHeadings, along edges

// In units of room_m: the height of the probe above the surface; the largest and the least distance
// between two tests, and between two tests sideways; the height at which the upward test begins;
// the width of surface needed on both sides, which is also the distance of a turn from sharp edges;
// the least length of a leg.
constexpr double kProbeHeight = 0.25;
constexpr double kLookEvery = 0.25;
constexpr double kLookAgain = 0.125;
constexpr double kWidthEvery = 0.5;
constexpr double kLookFrom = 1e-3;
constexpr double kKeepOff = 1.0;
constexpr double kLeastLeg = 2.0;

// A first leg shorter than this share of the path leads nowhere. The bound also limits the number
// of legs of a path that moves back and forth.
constexpr double kLeastStart = 1e-3;

// A heading is good enough if it leads on for this part of a leg.
constexpr double kGoodLeg = 0.75;

// The cost of the narrow part of a leg, as a multiple of its length.
constexpr double kNarrowCosts = 2.0;

// A path crosses an edge sharper than kSharpEdgeRad only if the sine of its angle with the edge is
// at least kGrazing.
constexpr double kSharpEdgeRad = std::numbers::pi / 4;
constexpr double kGrazing = 0.5;

// The probe moves around an edge sharper than this; at other edges it is tested along a straight
// segment.
constexpr double kSeenEdgeRad = std::numbers::pi / 12;

// A path keeps this share of an edge away from its vertices, so that it always crosses exactly one
// edge.
constexpr double kOffVertex = 1e-6;

// The cost of a sharp edge, in units of room_m: the time for crossing it, and the loss of a leg's
// worth for each right angle by which the leg bends over edges.
constexpr double kEdgeCosts = 6.0;
constexpr double kRightAngle = std::numbers::pi / 2;

// The largest number of faces that a leg crosses, and the number of pieces after which the path
// ends. Both limit the memory for meshes finer than a hand can resolve.
constexpr std::size_t kMostFaces = 20000;
constexpr std::size_t kMostPieces = 200000;

// A straight part of the path, in one face.
struct Piece {
  SceneFace face;
  Vec3 from_m, to_m;
  Vec3 heading;     // unit, in the face
  double fold_rad;  // of the edge where it begins; > 0 for a convex edge
  bool is_turn;

  double length_m() const { return (to_m - from_m).norm(); }
};

struct Leg {
  // Whether a point of the leg has surface on both sides.
  struct Spot {
    double along_m;
    bool is_wide;  // surface, or a wall
  };
  std::vector<Piece> pieces;
  std::vector<Spot> spots;
  std::vector<double> edges_m;  // positions of sharp convex and concave edges along the leg
  double length_m = 0.0;
  double worth_m = 0.0;  // its length minus the costs of narrow parts and bends
};

// The point where a line in a face leaves the face.
struct Exit {
  std::size_t edge;
  Vec3 p_m;
  Vec3 along_edge;  // unit
};

std::optional<Exit> exit_of(const SceneFace& face, const Vec3& from_m, const Vec3& heading) {
  std::optional<Exit> found;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = face.corners_m[k];
    const Vec3 edge = face.corners_m[(k + 1) % 3] - a;
    const double edge_m = edge.norm();
    if (edge_m == 0.0) continue;
    const Vec3 outward = (edge / edge_m).cross(face.winding);
    const double speed = heading.dot(outward);
    if (!(speed > 0.0)) continue;
    const double distance_m = std::max(0.0, (a - from_m).dot(outward) / speed);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    const double part = (from_m + distance_m * heading - a).dot(edge) / (edge_m * edge_m);
    found = {k, a + std::clamp(part, kOffVertex, 1.0 - kOffVertex) * edge, edge / edge_m};
  }
  return found;
}

class PathFinder {
 public:
  PathFinder(const Scene& scene, const SurfacePathSettings& settings)
      : scene_(scene),
        settings_(settings),
        faces_(scene),
        sight_(scene.world()),
        random_(settings.seed),
        sampler_(scene, random_),
        far_m_(2.0 * scene.statistics().extent_m.norm()) {}

  std::optional<SurfacePath> find() {
    if (sampler_.is_empty()) return std::nullopt;
    std::vector<Start> starts;
    for (int i = 0; i < kMostPlaces; ++i) {
      if (auto start = draw_start()) starts.push_back(*start);
    }
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Start& a, const Start& b) { return a.rank() > b.rank(); });
    if (starts.size() > kMostStarts) starts.resize(kMostStarts);
    const Start* best = nullptr;
    Leg first;
    for (const Start& start : starts) {
      if (best && start.rank() < best->rank() && first.length_m > least_leg_m()) break;
      Leg leg = best_leg(start.face, start.p_m);
      if (leg.length_m < kLeastStart * settings_.length_m) continue;
      if (best && leg.worth_m <= first.worth_m) continue;
      best = &start;
      first = std::move(leg);
      if (first.length_m >= kGoodLeg * settings_.leg_m) break;
    }
    if (!best) return std::nullopt;
    take(first);
    while (done_m_ + least_leg_m() < settings_.length_m && pieces_.size() < kMostPieces) {
      take(next_leg());
    }
    const SceneObject& object = scene_.objects()[best->face.object];
    return SurfacePath{as_path(), best->free_m,
                       scene_.mesh(object.mesh).report().boundary_edges > 0};
  }

 private:
  struct Start {
    SceneFace face;
    Vec3 p_m;
    double free_m;
    bool is_wide;

    // Starts with free space in front rank first, then starts with surface all around.
    std::pair<bool, bool> rank() const { return {std::isinf(free_m), is_wide}; }
  };

  std::optional<Start> draw_start() {
    const SceneFace face = sampler_.draw();
    const double root = std::sqrt(random_.uniform());
    const double v = random_.uniform();
    const auto& c = face.corners_m;
    const Vec3 p_m = (1 - root) * c[0] + root * (1 - v) * c[1] + root * v * c[2];
    if (face.winding.isZero(0.0)) return std::nullopt;
    const double free_m =
        far_m_ * sight_.first_hit(p_m + above(kLookFrom, face.normal), p_m + far_m_ * face.normal);
    if (free_m < 2.0 * settings_.room_m) return std::nullopt;
    const Vec3 u = face.winding.unitOrthogonal();
    return Start{face, p_m, free_m,
                 is_wide(face, p_m, u) && is_wide(face, p_m, face.winding.cross(u))};
  }

  Vec3 above(double rooms, const Vec3& normal) const { return rooms * settings_.room_m * normal; }

  double least_leg_m() const {
    return std::min(kLeastLeg * settings_.room_m, 0.5 * settings_.leg_m);
  }

  Leg next_leg() {
    const Piece& last = pieces_.back();
    Leg leg = best_leg(last.face, last.to_m);
    if (leg.length_m >= least_leg_m()) return leg;
    Leg back = path_back();
    return back.length_m > leg.length_m ? back : leg;
  }

  // The best of the legs in several directions, or the first good one.
  Leg best_leg(const SceneFace& face, const Vec3& from_m) {
    const double wanted_m = std::min(settings_.leg_m, settings_.length_m - done_m_);
    Leg best;
    for (int i = 0; i < kMostHeadings && best.worth_m < kGoodLeg * wanted_m; ++i) {
      Leg leg = go_straight(face, from_m, heading(face, i), wanted_m + kKeepOff * settings_.room_m);
      settle(leg, wanted_m);
      if (best.pieces.empty() || leg.worth_m > best.worth_m) best = std::move(leg);
    }
    return best;
  }

  // Random headings first, then both directions along each edge of the face: on a thin part only
  // these lead on.
  Vec3 heading(const SceneFace& face, int i) {
    const int edge = i - (kMostHeadings - kEdgeHeadings);
    if (edge >= 0) {
      const Vec3& from = face.corners_m[static_cast<std::size_t>(edge % 3)];
      const Vec3 along = face.corners_m[static_cast<std::size_t>((edge + 1) % 3)] - from;
      if (along.norm() > 0.0) return (edge < 3 ? 1.0 : -1.0) * along.normalized();
    }
    const double angle_rad = 2.0 * std::numbers::pi * random_.uniform();
    const Vec3 u = face.winding.unitOrthogonal();
    return std::cos(angle_rad) * u + std::sin(angle_rad) * face.winding.cross(u);
  }

  // Ends a leg where surface is all around and no sharp edge is near, and computes its worth.
  void settle(Leg& leg, double wanted_m) const {
    const double keep_off_m = kKeepOff * settings_.room_m;
    double end_m = std::min(wanted_m, std::max(0.5 * leg.length_m, leg.length_m - keep_off_m));
    const auto is_good = [&](const Leg::Spot& spot) {
      return spot.is_wide && spot.along_m <= end_m &&
             std::none_of(leg.edges_m.begin(), leg.edges_m.end(), [&](double edge_m) {
               return std::abs(edge_m - spot.along_m) < keep_off_m;
             });
    };
    const auto good = std::find_if(leg.spots.rbegin(), leg.spots.rend(), is_good);
    if (good != leg.spots.rend() && good->along_m >= least_leg_m()) end_m = good->along_m;
    shorten(leg, end_m);
    double last_m = 0.0;
    leg.worth_m = leg.length_m;
    for (const Piece& piece : leg.pieces) {
      leg.worth_m -= std::max(0.0, piece.fold_rad) / kRightAngle * kEdgeCosts * settings_.room_m;
    }
    for (const Leg::Spot& spot : leg.spots) {
      if (spot.along_m > end_m) break;
      if (!spot.is_wide) leg.worth_m -= kNarrowCosts * (spot.along_m - last_m);
      last_m = spot.along_m;
    }
  }

  Leg go_straight(SceneFace face, Vec3 from_m, Vec3 heading, double wanted_m) const {
    Leg leg;
    double fold_rad = 0.0;
    std::optional<Vec3> probe_m;
    if (!look(face, from_m, probe_m)) return leg;
    for (std::size_t n = 0; n < kMostFaces && leg.length_m < wanted_m; ++n) {
      const auto exit = exit_of(face, from_m, heading);
      if (!exit) break;
      Piece piece{face, from_m, exit->p_m, heading, fold_rad, leg.pieces.empty()};
      const bool is_free = go_along(piece, wanted_m, leg, probe_m);
      leg.pieces.push_back(piece);
      leg.length_m += piece.length_m();
      if (!is_free) break;
      const auto next = faces_.across(face, exit->edge);
      if (!next || !cross(face, *next, *exit, heading, fold_rad, probe_m)) break;
      if (std::abs(fold_rad) > kSharpEdgeRad) leg.edges_m.push_back(leg.length_m);
      face = *next;
      from_m = exit->p_m;
    }
    return leg;
  }

  // Tests a piece for obstacles and shortens it at the first. probe_m: the last position of the
  // probe, if any. Returns whether the whole piece is free.
  bool go_along(Piece& piece, double most_m, Leg& leg, std::optional<Vec3>& probe_m) const {
    const double whole_m = piece.length_m();
    const double end_m = std::min(whole_m, most_m - leg.length_m);
    const double step_m = kLookEvery * settings_.room_m;
    double free_m = 0.0;
    while (free_m < end_m) {
      // The edge itself is not tested: a surface that begins at the edge does not obstruct the
      // piece.
      const double next_m = std::min(free_m + step_m, end_m);
      const double look_m = next_m < end_m ? next_m : 0.5 * (free_m + end_m);
      const Vec3 p_m = piece.from_m + look_m * piece.heading;
      if (!look(piece.face, p_m, probe_m)) break;
      const double along_m = leg.length_m + look_m;
      if (leg.spots.empty() ||
          along_m >= leg.spots.back().along_m + kWidthEvery * settings_.room_m) {
        leg.spots.push_back({along_m, is_wide(piece.face, p_m, piece.heading)});
      }
      free_m = next_m;
    }
    if (free_m < whole_m) piece.to_m = piece.from_m + free_m * piece.heading;
    return free_m >= whole_m;
  }

  // Whether each side of the path has surface, or a wall that stands on the surface.
  bool is_wide(const SceneFace& face, const Vec3& p_m, const Vec3& heading) const {
    const double aside_m = kKeepOff * settings_.room_m;
    const Vec3 above_m = p_m + above(kProbeHeight, face.normal);
    for (const double side : {-1.0, 1.0}) {
      const Vec3 beside_m = above_m + side * aside_m * face.normal.cross(heading);
      if (std::isfinite(sight_.first_hit(above_m, beside_m))) continue;
      const Vec3 below_m = beside_m - above(kProbeHeight + kKeepOff, face.normal);
      if (std::isinf(sight_.first_hit(beside_m, below_m))) return false;
    }
    return true;
  }

  // Whether the clearance above a point of a face is free, and the probe can move there.
  bool look(const SceneFace& face, const Vec3& p_m, std::optional<Vec3>& probe_m) const {
    const Vec3 here_m = p_m + above(kProbeHeight, face.normal);
    if (probe_m && (here_m - *probe_m).norm() < kLookAgain * settings_.room_m) return true;
    if (probe_m && std::isfinite(sight_.first_hit(*probe_m, here_m))) return false;
    probe_m = here_m;
    return std::isinf(
        sight_.first_hit(p_m + above(kLookFrom, face.normal), p_m + above(1.0, face.normal)));
  }

  // Turns the heading over an edge. Returns false if a hand cannot follow.
  bool cross(const SceneFace& face, const SceneFace& next, const Exit& exit, Vec3& heading,
             double& fold_rad, std::optional<Vec3>& probe_m) const {
    const Vec3 outward = exit.along_edge.cross(face.winding);
    const Vec3 onward = exit.along_edge.cross(next.winding);
    const double along = heading.dot(exit.along_edge);
    const double across = heading.dot(outward);
    fold_rad = std::copysign(
        std::atan2(face.normal.cross(next.normal).norm(), face.normal.dot(next.normal)),
        next.normal.dot(outward));
    if (fold_rad > kSharpEdgeRad && across < kGrazing) return false;
    heading = (along * exit.along_edge + across * onward).normalized();
    if (fold_rad < kSeenEdgeRad || !probe_m) return true;
    // Moves the probe around a convex edge, not through it.
    for (const Vec3& normal : {face.normal, next.normal}) {
      const Vec3 here_m = exit.p_m + above(kProbeHeight, normal);
      if (std::isfinite(sight_.first_hit(*probe_m, here_m))) return false;
      probe_m = here_m;
    }
    return true;
  }

  static void shorten(Leg& leg, double length_m) {
    while (!leg.pieces.empty() && leg.length_m > length_m) {
      Piece& last = leg.pieces.back();
      const double last_m = last.length_m();
      if (leg.length_m - last_m >= length_m) {
        leg.length_m -= last_m;
        leg.pieces.pop_back();
      } else {
        last.to_m = last.from_m + (length_m - (leg.length_m - last_m)) * last.heading;
        leg.length_m = length_m;
      }
    }
  }

  // The pieces that led here, from the last one back.
  Leg path_back() const {
    Leg leg;
    double fold_rad = 0.0;
    for (std::size_t i = pieces_.size(); i-- > 0 && leg.length_m < settings_.leg_m;) {
      const Piece& p = pieces_[i];
      leg.pieces.push_back(
          {p.face, p.to_m, p.from_m, -p.heading, fold_rad, leg.pieces.empty() || turned_after(i)});
      leg.length_m += p.length_m();
      fold_rad = p.fold_rad;
    }
    return leg;
  }
  bool turned_after(std::size_t i) const {
    return i + 1 < pieces_.size() && pieces_[i + 1].is_turn;
  }

  static std::ptrdiff_t sharp_edges(const Leg& leg) {
    return std::count_if(leg.pieces.begin(), leg.pieces.end(),
                         [](const Piece& p) { return p.fold_rad > kSharpEdgeRad; });
  }

  void take(const Leg& leg) {
    pieces_.insert(pieces_.end(), leg.pieces.begin(), leg.pieces.end());
    done_m_ += leg.length_m + static_cast<double>(sharp_edges(leg)) * kEdgeCosts * settings_.room_m;
  }

  HandPath as_path() const {
    HandPath path;
    for (const Piece& piece : pieces_) {
      if (piece.from_m == piece.to_m && !piece.is_turn) continue;
      path.points.push_back({piece.from_m, -piece.face.normal, piece.fold_rad, piece.is_turn});
    }
    path.points.front().is_turn = false;
    path.points.push_back({pieces_.back().to_m, path.points.back().inward});
    return path;
  }

  const Scene& scene_;
  SurfacePathSettings settings_;
  SceneFaceReader faces_;
  SceneSight sight_;
  UniformRandom random_;
  SceneFaceSampler sampler_;
  double far_m_;
  std::vector<Piece> pieces_;
  double done_m_ = 0.0;  // length of the path so far, sharp edges included
};

}  // namespace

std::optional<SurfacePath> plan_surface_path(const Scene& scene,
                                             const SurfacePathSettings& settings) {
  return PathFinder(scene, settings).find();
}

}  // namespace palpate
