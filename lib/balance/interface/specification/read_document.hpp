#pragma once
/// Reading one spec.

#include "balance/interface/specification/spec_parameters.hpp"
#include "balance/interface/specification/spec_units.hpp"
#include "balance/interface/specification/yaml_document.hpp"

#include <memory>
#include <string>

namespace balance::specification {

struct ReadResult {
  Study start;  ///< at the start values
  std::shared_ptr<const study::Recording> recording;
};

/// @param inputs key paths of numbers that become inputs of the recording, as in ReadOptions
/// @throws SpecError listing everything that is wrong, in document order
ReadResult read_study(const std::string& text, const std::string& file_name, const SpecParameters::Overrides& overrides,
                      const std::set<std::string>& inputs = {});

/// The same without a recording, for a single reading.
/// @param root the text's document; null: it is parsed here
Study read_start_study(const std::string& text, const YamlNode* root, const std::string& file_name,
                       const SpecParameters::Overrides& overrides);

/// Dimension of every number that is free or that loads or tolerances name, by its key path. @throws SpecError as above
std::map<std::string, Dimension> read_number_dimensions(const std::string& text, const std::string& file_name,
                                                        const SpecParameters::Overrides& overrides);

/// Reads the mechanism alone, from a document without includes.
/// @param known_problems collector of the reading that the root's places are from
/// @throws SpecError as above
Mechanism read_mechanism_alone(const YamlNode& root, const std::string& file_name,
                               const SpecErrorCollector& known_problems, const SpecParameters::Overrides& overrides);

}  // namespace balance::specification
