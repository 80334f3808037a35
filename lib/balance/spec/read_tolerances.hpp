#pragma once
/// A spec together with how far its numbers may be off.

#include "balance/spec/read_spec.hpp"
#include "balance/study/tolerances.hpp"

#include <string>

namespace balance {

struct TolerancedDesignSpace {
  DesignSpace space;
  Tolerances tolerances;  ///< parameters first, else in the order of reading; empty if the spec says nothing of them
};

/// @throws SpecError, SystemError as read_design_space
TolerancedDesignSpace read_toleranced_space(const std::string& text, const std::string& file_name,
                                            const ReadOptions& options = {});
TolerancedDesignSpace read_toleranced_space_file(const std::string& path, const ReadOptions& options = {});

}  // namespace balance
