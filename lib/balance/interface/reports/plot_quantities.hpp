#pragma once
/// Quantities of a run by the names that a user types: `shaking_force`, `shaking_force.x`, `torque`, `torque[A1]`,
/// `joint_force[B1].y`.

#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance {

/// What is drawn of a vector where no component is named.
enum class VectorView { magnitude, components, both };

struct PlotCurve {
  std::string label;  ///< what tells it from the others of its quantity: "A1", "x", "B1 x"; empty if it is alone
  VectorX values;     ///< one per sample
};

struct PlotQuantity {
  std::string name;          ///< as typed
  std::string title;         ///< for an axis: "shaking force"
  std::string unit;          ///< of all curves; "mixed" if they differ, "1" for none
  bool not_negative = true;  ///< by its nature: magnitudes
  std::vector<PlotCurve> curves;
};

/// Every name that the result has, those of single members and components behind the name of the whole.
std::vector<std::string> list_plot_names(const RunResult& result);

/// Nothing if the result has no quantity of that name.
std::optional<PlotQuantity> find_plot_quantity(const RunResult& result, const std::string& name, VectorView view);

}  // namespace balance
