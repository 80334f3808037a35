#pragma once
/// What of a Result has figures: peak, rms, mean, range.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

#include <string>
#include <vector>

namespace balance {

/// Neighbouring columns of one of Result's arrays that together are a scalar or a vector.
struct Track {
  std::string quantity;  ///< "shaking_force", "torque[A1]"
  std::string unit;
  Samples Result::*array = nullptr;
  int first = 0, count = 1;
  std::string
      of_worst;  ///< "torque": the worst of neighbours with this name and one unit has figures, too; empty: it has none
};

/// Of every array that has columns; those of a run under control first.
std::vector<Track> list_tracks(const Result& result);

/// A run of neighbours that have a worst one: [first, last) in the list. Just one track if it has none.
std::vector<std::pair<std::size_t, std::size_t>> neighbours(const std::vector<Track>& tracks);

/// Whether the worst of tracks [first, last) means something: they have a common name and one unit.
bool have_worst(const std::vector<Track>& tracks, std::size_t first, std::size_t last);

/// Names of all figures of a run of a mechanism along a trajectory, the worst ones before those that they are the worst of.
std::vector<std::string> figure_names(const Mechanism& mechanism);

}  // namespace balance
