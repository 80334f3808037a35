// What terms of objectives are called.

#include "balance/analysis/objective.hpp"

#include <fmt/format.h>

namespace balance {

std::string name_of(Figure figure) {
  switch (figure) {
    case Figure::peak: return "peak";
    case Figure::rms: return "rms";
    case Figure::mean: return "mean";
    case Figure::range: return "range";
  }
  return "";
}

std::string name_of(const ObjectiveTerm& term) {
  switch (term.size) {
    case ObjectiveTerm::Size::added_mass: return "added mass";
    case ObjectiveTerm::Size::added_inertia: return "added inertia";
    case ObjectiveTerm::Size::total_mass: return "total mass";
    case ObjectiveTerm::Size::none: break;
  }
  switch (term.run) {
    case ObjectiveTerm::Run::energy: return "energy along " + term.trajectory;
    case ObjectiveTerm::Run::mobility: return "mobility along " + term.trajectory;
    case ObjectiveTerm::Run::clearance: return "clearance along " + term.trajectory;
    case ObjectiveTerm::Run::duration: return "duration of " + term.trajectory;
    case ObjectiveTerm::Run::figure: break;
  }
  const std::string figure = name_of(term.figure) + "(" + term.quantity + ") along " + term.trajectory;
  return term.plus ? fmt::format("mean plus {:g} deviation{} of {}", *term.plus, *term.plus == 1 ? "" : "s", figure)
                   : figure;
}

}  // namespace balance
