#pragma once
/// The law with the least peak of a quantity in a duration. Private to timing.

#include "balance/timing/fastest.hpp"

namespace balance {

struct MinPeakLaw {
  TimeOptimalLaw law;          ///< to be stretched to the duration
  double peak = 0;             ///< [SI]
  std::vector<double> bounds;  ///< that the law before stretching keeps, one per row of the model
};

/// @param limits of the model's first rows; the others are those whose peak is to be least @param duration [s]
MinPeakLaw find_min_peak_law(const PathModel& model, const std::vector<double>& limits, const EndpointRates& rates,
                             double duration);

}  // namespace balance
