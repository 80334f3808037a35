#pragma once
/// The parts of a design that are bought: a bill of materials, and what is known about the choice of rows.

#include "balance/foundation/hdf5/hdf5_writer.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/synthesis/design/design_study.hpp"

#include <optional>
#include <string>

namespace balance::reports {

/// A line for each element, the sums, and how well the rows are known to be the best; empty without catalogues.
/// @param objective_unit SI unit of the objective; empty for sums
std::string parts_text(const std::optional<design::CatalogueReport>& report, const std::string& objective_unit,
                       const files::TextOptions& options);
/// Null without catalogues.
Json parts_json(const std::optional<design::CatalogueReport>& report);
void add_parts(hdf5::Hdf5Writer& file, const design::CatalogueReport& report);

}  // namespace balance::reports
