#pragma once
/// Designs with free lengths, together with the bound over all lengths.

#include "balance/synthesis/certificate/length_bound.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <optional>

namespace balance::design {

/// Solves a problem of a spec. Where all its lengths can be bounded, the bound comes first: if it is reached, its design
/// is the answer. Otherwise the search starts at the best lengths of the bound's tree, and the tree goes on with what
/// the search found. The outcome has the bound, and limits that no lengths can meet are proved so.
/// @param bound the bound, if there is one
DesignOutcome solve_with_length_bound(const DesignSpace& space, const DesignStudyOptions& options,
                                      const DesignProblem& problem, std::optional<certificate::LengthBound>& bound);

/// Why no bound over all lengths, and no proof of one, can be asked for; completes "no certificate because …". Empty: it
/// can.
std::string find_certificate_obstacle(const DesignSpace& space, const DesignStudyOptions& options);

}  // namespace balance::design
