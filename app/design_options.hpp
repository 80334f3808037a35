#pragma once
/// What the user asks of `balance design`, and what it means for the library.

#include "goals.hpp"

#include "balance/analysis/design_study.hpp"
#include "balance/write/write_options.hpp"

#include <string>

namespace balance::app {

struct DesignCommandOptions {
  SpecOptions spec;
  GoalOptions goal;
  std::string output, h5;  ///< files to write; empty: none
  std::string csv;         ///< of a front
  std::string point;       ///< of a front: its number or `middle`; empty: the front alone
  std::string minimize;    ///< YAML; empty: the spec's
  std::string algorithm;   ///< one of SearchOptions' global or local ones; empty: the spec's
  double seconds = 0;      ///< 0: the spec's
  int starts = 0;          ///< 0: the spec's
  bool force = false;
  bool quiet = false;
};

void add_design_options(CLI::App& parser, DesignCommandOptions& options);

/// @throws UsageError for names that do not exist; SpecError if nothing is free
DesignStudyOptions make_study_options(const DesignCommandOptions& options, const Study& study);

/// Refuses at once what would fail after the computation. @throws UsageError, SystemError
void check_outputs(const DesignCommandOptions& options, const Study& study);

Provenance describe(const DesignCommandOptions& options, const Study& study);

}  // namespace balance::app
