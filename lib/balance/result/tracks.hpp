#pragma once
/// What of a Result has figures: peak, rms, mean, range.

#include "balance/model/mechanism.hpp"
#include "balance/result/result.hpp"

#include <string>
#include <utility>
#include <vector>

namespace balance {

/// Neighbouring columns of one of Result's arrays that together are a scalar or a vector.
struct Track {
  std::string quantity;  ///< "shaking_force", "torque[A1]"
  std::string unit;
  Samples Result::*array = nullptr;
  int first = 0, count = 1;
  std::string of_worst;  ///< "torque": the worst of the neighbours with this name has figures, too; empty: none has
};

/// Of every array that has columns; those of a run under control first.
std::vector<Track> list_tracks(const Result& result);

/// The tracks in runs [first, last): neighbours that have a worst one together, every other by itself.
std::vector<std::pair<std::size_t, std::size_t>> neighbours(const std::vector<Track>& tracks);

/// Names of all figures of a run of a mechanism along a trajectory, the worst ones before those that they are the worst of.
std::vector<std::string> figure_names(const Mechanism& mechanism);

/// SI unit of a figure of that name: "N m"; empty if there is none of it.
std::string figure_unit(const Mechanism& mechanism, const std::string& name);

}  // namespace balance
