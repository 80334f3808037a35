#pragma once
/// Reading one spec: first at its start values, then with other values of its free numbers.

#include "balance/spec/free_numbers.hpp"
#include "balance/spec/open_parts.hpp"
#include "balance/spec/parameters.hpp"
#include "balance/spec/time_table.hpp"

#include <map>
#include <string>

namespace balance::read {

/// A spec that has been read, and what it takes to read it again. Never changed.
struct Reading {
  Node root;
  Parameters::Overrides overrides;
  Study start;
  std::map<std::string, TimeTable> tables;  ///< of files, by the key path that names the file
  FreeValues::Index free_index;             ///< into start.free_numbers
  Calculated constants;                     ///< expressions that free numbers do not change
  OpenParts open;                           ///< what they do change
};

/// @throws SpecError with everything that is wrong, in the order of the document
Reading read_first(const std::string& text, const std::string& file_name, const Parameters::Overrides& overrides);

/// The same, for whoever will not read again.
/// @param root the text's document, if it has been parsed already
Study read_start(const std::string& text, const Node* root, const std::string& file_name,
                 const Parameters::Overrides& overrides);

/// The mechanism alone.
/// @throws SpecError as above
Mechanism read_mechanism_alone(const Node& root, const std::string& file_name, const Parameters::Overrides& overrides);

/// @param x values of reading.start.free_numbers, SI, parameters as written; nothing is judged
Study read_again(const Reading& reading, const VectorX& x);

}  // namespace balance::read
