// What terms of objectives are called.

#include "balance/analysis/objective.hpp"

#include <fmt/format.h>

namespace balance {

std::string objective_term_name(Statistic figure) {
  switch (figure) {
    case Statistic::peak: return "peak";
    case Statistic::rms: return "rms";
    case Statistic::mean: return "mean";
    case Statistic::range: return "range";
  }
  return "";
}

std::string objective_term_name(const ObjectiveTerm& term) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_mass: return "added mass";
    case ObjectiveTerm::Size::added_inertia: return "added inertia";
    case ObjectiveTerm::Size::total_mass: return "total mass";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::RunMeasure::energy: return "energy along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::mobility: return "mobility along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::clearance: return "clearance along " + term.trajectory;
    case ObjectiveTerm::RunMeasure::duration: return "duration of " + term.trajectory;
    case ObjectiveTerm::RunMeasure::figure: break;
  }
  const std::string figure = objective_term_name(term.figure) + "(" + term.quantity + ") along " + term.trajectory;
  return term.deviation_multiple ? fmt::format("mean plus {:g} deviation{} of {}", *term.deviation_multiple,
                                               *term.deviation_multiple == 1 ? "" : "s", figure)
                                 : figure;
}

}  // namespace balance
