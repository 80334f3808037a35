#pragma once
/// From samples to the points of a line in a picture: jumps upright, no more points than a page can show.

#include "balance/result/result.hpp"

#include <vector>

namespace balance {

struct PlotPoint {
  double x = 0, y = 0;
};

/// Samples at which an acceleration jumps: its step there is many times those around it. The sample holds the value after the jump.
std::vector<Eigen::Index> find_sampled_jumps(const RunResult& result);

/// The values over `x`; at a jump the line first goes on to the value before it, so that the step is upright.
/// @param x one per value, increasing
std::vector<PlotPoint> trace_values(const VectorX& x, const VectorX& values, const std::vector<Eigen::Index>& jumps);

/// At most about `most` points of a line over x; the largest and smallest value of every stretch stay.
std::vector<PlotPoint> decimate_series(std::vector<PlotPoint> points, std::size_t most);

/// At most about `most` points of a curve in the plane, both ends included.
std::vector<PlotPoint> decimate_path(std::vector<PlotPoint> points, std::size_t most);

}  // namespace balance
