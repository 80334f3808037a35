#pragma once
/// A motion along the path at the edge of what the limits allow. Private to timing.

#include "balance/motion/law.hpp"
#include "balance/timing/allowed.hpp"

#include <functional>
#include <vector>

namespace balance {

/// A moment of it.
struct ArcNode {
  double t = 0;  ///< from the arc's start [s]
  double s = 0, v = 0;
  double u = 0;  ///< s''
  int row = -1;  ///< which limit it is at; −1: none
};

/// Ascending in t and s.
using Arc = std::vector<ArcNode>;

/// Place, rate and second rate between two nodes, by the quintic that the law will be.
ArcNode between(const ArcNode& a, const ArcNode& b, double t);
/// The same at a place.
ArcNode between_at(const ArcNode& a, const ArcNode& b, double s);

enum class Edge {
  speed_up,  ///< the largest s'', forwards in time
  brake,     ///< the smallest s'', backwards in time
  slide,     ///< on the cap of a row without a, forwards
};

enum class ArcEnd {
  arrived,    ///< at the place that it was to go to
  blocked,    ///< nothing is allowed any more
  capped,     ///< on the cap, exactly
  left,       ///< a slide: the cap can be followed no further, s'' has to be smaller than it asks for
  told,       ///< by the watcher
  unlimited,  ///< nothing limits s''
  stuck,      ///< s' does not leave zero
};

/// A stretch of the path where everything is smooth.
struct Smooth {
  double begin = 0, end = 1;
  std::size_t first_panel = 0, last_panel = 1;
  bool vanishes_at_begin = false, vanishes_at_end = false;  ///< a row's a

  /// How near arcs come to such an end: on it nothing can be asked of that row.
  double near_begin() const { return vanishes_at_begin ? begin + margin() : begin; }
  double near_end() const { return vanishes_at_end ? end - margin() : end; }

 private:
  double margin() const { return 1e-6 * (end - begin); }
};

/// Sees every step; true: enough.
using Watcher = std::function<bool(const ArcNode& from, const ArcNode& to)>;

/// Continues an arc by embedded Runge–Kutta steps in time (Dormand and Prince), so short that the quintics between nodes keep s''.
/// @param arc at least one node, on the stretch; braking: nodes run backwards, t counts backwards from the arc's first node
/// @param until within the stretch
/// @param under not 0: the ceiling, less this part of it, is taken for a cap, too
ArcEnd follow_edge(Allowed& allowed, const Smooth& stretch, Edge edge, double until, const Watcher& watcher, Arc& arc,
                   double under = 0);

}  // namespace balance
