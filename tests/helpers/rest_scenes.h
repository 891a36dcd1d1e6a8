#pragma once

// Random scenes in which it is hard to find the place nearest to the goal, each with a proxy of its
// size, and a hand that looks for trouble there.

#include <cstdint>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

struct RestScene {
  Soup soup;
  double radius_m = 0.0;          // of the proxy
  std::vector<Vec3> starts = {};  // where it may be put; empty: anywhere with room
  std::vector<Vec3> aims = {};    // places worth aiming at besides vertices, edges and faces
  double grid_m = 0.0;            // of the vertices and of the goals; 0: none
};

enum class ProxyKind : std::uint8_t { kPoint, kSphere };

struct RestClass {
  const char* name;
  ProxyKind proxy;
  RestScene (*make)(ProxyKind proxy, Random& random);
  double most_capped;  // of the ticks in contact

  std::string full_name() const;  // with the proxy
};

inline void PrintTo(const RestClass& rest_class, std::ostream* out) {
  *out << rest_class.full_name();
}

// The hard scenes of the leak test are among them.
std::span<const RestClass> rest_classes();

// These, and meshes so fine that judging rests there would take long.
std::vector<RestClass> restless_classes();

// Those whose spheres are larger than edges, up to ten thousand times.
std::vector<RestClass> large_sphere_classes();

// A room with no wall bent: the hull of random float points, convex by exact signs, with angles of
// more than a degree between walls that meet in an edge. Faces look inwards.
Soup convex_room(Random& random);

// A hand that plunges, slides, comes in the plane of a face, aims at vertices and edges to the bit,
// jumps, goes at a steady pace from place to place, and rests for some ticks wherever it is. Solver
// frame.
class RestHand {
 public:
  // The triangles outlive the hand.
  RestHand(const std::vector<Corners>& triangles, std::vector<Vec3> aims, double radius_m,
           double stand_off_m, double grid_m, const Vec3& start, Random& random);
  Vec3 next_goal(const ProxyState& felt);

  // From now on it neither rests nor aims: each tick has some way to go.
  void never_rest() { is_restless_ = true; }

 private:
  enum class Habit : std::uint8_t {
    kPlunge,
    kSlide,
    kGraze,
    kAim,
    kPress,
    kJump,
    kWander,
    kTour,
    kCount
  };

  void choose(const ProxyState& felt);
  Vec3 place_of_interest();
  Vec3 vertex_or_edge();
  Vec3 graze_start();
  Vec3 make_goal(const ProxyState& felt);
  const Corners& some_triangle();
  Vec3 on_grid(const Vec3& p) const;
  double log_uniform(double low, double high);

  const std::vector<Corners>* triangles_;
  std::vector<Vec3> aims_;
  double radius_m_;
  double stand_off_m_;
  double grid_m_;
  Random* random_;
  Vec3 low_, high_;
  double size_m_;
  Vec3 goal_;
  Vec3 aim_;
  Vec3 heading_;
  double pace_m_ = 0.0;
  double depth_m_ = 0.0;
  Habit habit_ = Habit::kWander;
  int ticks_left_ = 0;
  int rest_left_ = 0;
  bool is_restless_ = false;
  int stage_ = 0;
};

}  // namespace palpate::test
