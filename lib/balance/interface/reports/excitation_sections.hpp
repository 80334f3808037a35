#pragma once
/// Text and JSON of a motion along which to measure.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/interface/reports/excited_spec.hpp"
#include "balance/synthesis/identification/excitation.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// @param title the mechanism's name @param spec null: not written
std::string excitation_text(const identification::Excitation& excitation, const Mechanism& mechanism,
                            const std::string& title, const ExcitedSpec* spec, const files::TextOptions& options);

/// @param title the mechanism's name @param spec null: not written @param files that were written
Json excitation_json(const identification::Excitation& excitation, const Mechanism& mechanism, const std::string& title,
                     const ExcitedSpec* spec, const std::vector<std::string>& files);

}  // namespace balance::reports
