#pragma once
/// Figures of a design for their bound over all lengths.

#include "balance/synthesis/certificate/figure_dual.hpp"

#include <memory>
#include <string>
#include <vector>

namespace balance::design {

/// The terms of an objective as figures of forces along one motion.
/// @param reason why they are not: completes "no certificate because …"
certificate::FigureRequest read_figure_request(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms,
                                               std::string& reason);

/// Forces along the motion by the library's mechanics.
/// @param space must outlive the model
std::unique_ptr<certificate::ForceRowModel> make_force_row_model(const DesignSpace& space,
                                                                 const std::vector<ObjectiveTerm>& terms,
                                                                 const certificate::FigureProblem& problem);

}  // namespace balance::design
