#pragma once
/// Pictures of a result of `balance identify --h5`: measured and predicted efforts, residuals and friction.

#include "balance/interface/reports/plot.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

/// Rows of one measured effort, current or component of the force on the frame.
struct StoredChannel {
  std::string name, unit;                         ///< "A1", "N m"
  std::string rate_unit;                          ///< empty: a component of the force on the frame
  std::vector<double> record;                     ///< index of the record
  std::vector<double> time, measured, predicted;  ///< [SI]
  std::vector<double> friction, rate;             ///< [SI]; `rate` is empty for the frame
  std::vector<double> moving;                     ///< 1 where the coordinate is not at rest
};

/// Records that were only predicted where there are any, else those that were fitted.
struct StoredIdentification {
  std::string path, spec_text;
  bool is_validation = false;
  std::vector<StoredChannel> channels;  ///< at least one
};

/// @returns std::nullopt if the file is another result, or none
/// @throws SystemError if it is damaged
std::optional<StoredIdentification> read_identification(const std::string& path);

/// What can be drawn: `effort`, measured and predicted; `residual`, their difference; `friction`, as identified and with
/// the residual; each also of one channel, `effort[A1]`.
std::vector<std::string> list_plot_names(const StoredIdentification& found);

/// One panel per channel and quantity, as lines over time, or as points over the rate of moving coordinates.
/// @param quantities of list_plot_names()
/// @throws std::invalid_argument if nothing that is drawn has a rate
Plot plot_identification(const StoredIdentification& found, const std::vector<std::string>& quantities, bool over_rate,
                         const specification::SpecUnits& units = {});

}  // namespace balance::reports
