#pragma once
/// What the user asks of `balance report`.

#include "goals.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::app {

struct ReportOptions {
  SpecOptions spec;
  GoalOptions goal;
  std::vector<std::string> trajectories;  ///< names; empty: all that the spec declares
  std::string controller;                 ///< that leads every run; empty: none
  std::optional<long> samples;            ///< of every trajectory; the spec's if not given
  std::string output;                     ///< empty: the spec's name with .html, in the current folder
  bool force = false;
  bool quiet = false;
};

void add_report_options(CLI::App& parser, ReportOptions& options);

/// Those asked for, in the spec's order; without a wish those that the spec lists, else the built-in ones.
/// @throws UsageError for a name that does not exist
std::vector<std::string> choose_trajectories(const ReportOptions& options, const Study& study);

/// The file that the page goes to. @throws UsageError if that is the spec; SystemError if it cannot be written
std::string choose_output(const ReportOptions& options);

/// What makes the same page again; the spec's folder is left out.
std::string command_line(const ReportOptions& options);

}  // namespace balance::app
