#pragma once
/// Reading one spec.

#include "balance/spec/node.hpp"
#include "balance/spec/parameters.hpp"

#include <memory>
#include <string>

namespace balance::read {

struct Reading {
  Study start;  ///< at the start values
  std::shared_ptr<const Recording> recording;
};

/// @throws SpecError with everything that is wrong, in the order of the document
Reading read_study(const std::string& text, const std::string& file_name, const Parameters::Overrides& overrides);

/// The same, for whoever will not read again.
/// @param root the text's document, if it has been parsed already
Study read_start(const std::string& text, const Node* root, const std::string& file_name,
                 const Parameters::Overrides& overrides);

/// The mechanism alone, of a document that includes no parts any more.
/// @param known of the reading that the root's places are from
/// @throws SpecError as above
Mechanism read_mechanism_alone(const Node& root, const std::string& file_name, const Problems& known,
                               const Parameters::Overrides& overrides);

}  // namespace balance::read
