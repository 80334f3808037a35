#pragma once
/// Designs, and the motions that judge them: a design's own conditions are never asked.

#include "balance/synthesis/design/design_study.hpp"
#include "published.hpp"

#include <string>
#include <utility>
#include <vector>

namespace published {

using balance::DesignReport;
using balance::DesignStatus;
using balance::Goal;
using balance::GoalKind;

/// Parameters of a spec and the numbers that replace theirs.
using Numbers = std::vector<std::pair<std::string, double>>;

balance::DesignSpace space_of(const std::string& file);
/// @param text a spec
balance::DesignSpace space_of_text(const std::string& text, const Numbers& numbers);

/// The design of the spec's own goal, trajectories left out; balanced, or the test ends.
DesignReport balanced(const balance::DesignSpace& space, const balance::DesignStudyOptions& options = {});
/// The same, whatever comes out.
DesignReport designed(const balance::DesignSpace& space, balance::DesignStudyOptions options = {});

/// Value of the free number with that key path.
double found(const DesignReport& report, const std::string& path);

/// The actuated joints wander at random about `home`, each up to `reach` away: a spline through eight random values.
Trajectory wander(const Mechanism& mechanism, const VectorX& home, double reach, std::mt19937& random,
                  long samples = 41);
/// The same about the middle of one of the study's trajectories.
Trajectory wander(const balance::Study& study, const std::string& about, double reach, std::mt19937& random,
                  long samples = 41);

double largest(const balance::Samples& values);

}  // namespace published
