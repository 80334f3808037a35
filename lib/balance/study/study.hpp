#pragma once
/// Everything that one spec asks for, complete and validated.

#include "balance/model/mechanism.hpp"
#include "balance/motion/trajectory.hpp"
#include "balance/result/figure.hpp"
#include "balance/study/controller.hpp"
#include "balance/study/goal.hpp"
#include "balance/study/search_options.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace balance {

/// A number that the designer left open: `{free: [lower, upper], start: …}`. The study holds its start value.
struct FreeNumber {
  std::string path;  ///< key path in the spec, `counterweights.cw2.mass`, or the parameter's: `parameters.x`
  double lower = 0, upper = 0, start = 0;  ///< SI, except free parameters: as written
  double unit = 1;                         ///< SI value of the spec's unit here; 1 for parameters
  std::size_t begin = 0, end = 0;  ///< bytes of spec_text that `{free: …}`, or the alias that stands for it, takes up
};

/// How a spec is written with numbers in place of its free ones, and with what `--set` said: bytes [begin, end) of its text are
/// replaced by `text` and then, if there is one, the value of a free number.
struct Rewrite {
  std::size_t begin = 0, end = 0;
  std::string text;
  int number = -1;  ///< index of the free number; −1: none
};

/// One term of what to minimize. Either `size` is given, or figure, quantity and trajectory.
struct ObjectiveTerm {
  enum class Size { none, added_mass, added_inertia, total_mass };
  Size size = Size::none;
  Figure figure = Figure::rms;
  std::string quantity;    ///< as in Result::metrics: "shaking_force", "torque[A1]"
  std::string trajectory;  ///< name of one of the study's trajectories
  double weight = 1;       ///< not negative
};

/// What `design:` asks for.
struct DesignRequest {
  std::vector<Goal> goals;
  std::vector<ObjectiveTerm> minimize;  ///< their weighted sum; empty: nothing in particular
  SearchOptions search;
};

/// What a spec tells coordinates in, as SI values.
struct CoordinateUnits {
  double length = 1;
  double angle = 1;
};

struct Study {
  Mechanism mechanism;
  std::vector<Trajectory>
      trajectories;  ///< declared ones and the built-in `cycloid` and `bang-bang`; empty without `motion`
  std::vector<Controller> controllers;   ///< declared ones, then the built-in ones that no declared one replaces
  std::vector<FreeNumber> free_numbers;  ///< in the document's order
  std::vector<Rewrite> rewrites;         ///< in the text's order, disjoint
  DesignRequest design;
  CoordinateUnits units;              ///< of the spec
  std::string spec_file;              ///< as named by the user
  std::string spec_text;              ///< as read
  std::vector<std::string> warnings;  ///< legal but suspicious
};

}  // namespace balance
