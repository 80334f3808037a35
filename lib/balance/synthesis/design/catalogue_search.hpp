#pragma once
/// Which rows of catalogues are best: branch and bound over sets of rows and boxes of places where the figures are known
/// functions of them, otherwise a design for each combination of rows.

#include "balance/synthesis/design/design_study.hpp"

#include <functional>

namespace balance::design {

/// Makes a design for given rows.
using FixedRowStudy = std::function<DesignReport(const DesignSpace&, const DesignStudyOptions&)>;

/// Whether a design has to choose rows of catalogues.
bool has_free_rows(const Study& study);

/// The design with the best rows.
/// @param space with free rows
/// @throws std::invalid_argument as run_design_study; for load cases that rows are free with
DesignReport run_catalogue_study(const DesignSpace& space, const DesignStudyOptions& options,
                                 const FixedRowStudy& study);

}  // namespace balance::design
