#pragma once
/// Quantities of a run by the names that a user types: `shaking_force`, `shaking_force.x`, `torque`, `torque[A1]`,
/// `joint_force[B1].y`.

#include "balance/mechanics/results/result.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::reports {

/// What to draw of a vector if no component is named.
enum class VectorView { magnitude, components, both };

struct PlotCurve {
  std::string label;  ///< distinguishes it within its quantity: "A1", "x", "B1 x"; empty if it is the only one
  VectorX values;     ///< one per sample
};

struct PlotQuantity {
  std::string name;          ///< as typed
  std::string title;         ///< for an axis: "shaking force"
  std::string unit;          ///< of all curves; "mixed" if they differ, "1" for none
  bool not_negative = true;  ///< true for magnitudes
  std::vector<PlotCurve> curves;
  bool is_effort = false;  ///< of actuators
};

/// All names in the result; those of members and components follow the name of the whole.
std::vector<std::string> list_plot_names(const RunResult& result);

/// std::nullopt if the result has no quantity of that name.
std::optional<PlotQuantity> find_plot_quantity(const RunResult& result, const std::string& name, VectorView view);

}  // namespace balance::reports
