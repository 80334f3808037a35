#pragma once
/// Text, JSON and HDF5 of an identification.

#include "balance/interface/files/json.hpp"
#include "balance/interface/files/text_options.hpp"
#include "balance/synthesis/identification/identification.hpp"

#include <string>
#include <vector>

namespace balance::reports {

/// @param title the mechanism's name
std::string identification_text(const identification::Identification& found, const std::string& title,
                                const files::TextOptions& options);

/// @param title the mechanism's name @param files that were written
Json identification_json(const identification::Identification& found, const std::string& title,
                         const std::vector<std::string>& files);

/// Base parameters with their covariance, unknowns, and what every channel measured and the identified mechanism predicts.
void write_identification(const std::string& path, const identification::Identification& found,
                          const files::Provenance& description, const files::WriteOptions& options);

}  // namespace balance::reports
