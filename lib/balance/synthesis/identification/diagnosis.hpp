#pragma once
/// Known mistakes in records, by name: whether a record would fit better if it were read otherwise.

#include "balance/synthesis/identification/estimation.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <vector>

namespace balance::identification {

/// What an identification is repeated with.
struct DiagnosisInput {
  MotionEquations& equations;
  const std::vector<UnknownParameter>& unknowns;
  const std::vector<MeasurementRecord>& records;
  const Regression& regression;
  const std::vector<CompressedChannel>& compressed;
  const BaseCombinations& base;
  const VectorX& spec;
  const std::vector<std::optional<double>>& gains;
  const Estimate& estimate;
};

/// Efforts reversed or swapped, positions in degrees or reversed, efforts that lag behind; the best explanation first. None
/// if the record fits well as it is.
std::vector<Suspicion> diagnose(const DiagnosisInput& input);

}  // namespace balance::identification
