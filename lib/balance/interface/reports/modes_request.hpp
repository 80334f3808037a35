#pragma once
/// What `balance modes` was asked for, and the computation.

#include "balance/interface/reports/vibration_sections.hpp"

#include <stdexcept>
#include <string>

namespace balance::reports {

struct ModesRequest {
  std::string trajectory = {};  ///< empty: the first with free coordinates, else the first, else as assembled
  std::string sweep = {};       ///< "v=1:10:91"; empty: none
  int orders = 4;               ///< highest order of the response
  int exact = 5;                ///< values of a sweep at which the response is also computed exactly; 0: nowhere
};

/// A sweep that is not of the form NAME=FROM:TO or NAME=FROM:TO:COUNT, or whose speeds are not positive. The message begins
/// with `--sweep`.
class SweepError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The modes' outcome says why there are none; the rest is then empty. @throws study::UnknownNameError
/// @param speed_unit the unit of swept speeds
/// @throws SweepError; SpecError for an unknown parameter, or what does not go with free coordinates
VibrationReportData analyse_modes(const Study& study, const ModesRequest& request, const files::DisplayUnit& speed_unit,
                                  const simulation::Progress& progress = {});

/// Adds the request's sweep to what analyse_modes() found without one.
/// @throws as analyse_modes()
void add_sweep(const Study& study, const ModesRequest& request, const files::DisplayUnit& speed_unit,
               VibrationReportData& view);

/// @param trajectory its name
files::Provenance make_modes_provenance(const Study& study, const std::string& trajectory, const ModesRequest& request);

}  // namespace balance::reports
