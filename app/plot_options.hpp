#pragma once
/// What `balance plot` is asked for.

#include "balance/read/result_file.hpp"
#include "balance/report/plot_script.hpp"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace balance::app {

struct PlotOptions {
  std::vector<std::string> results, quantities, labels;
  std::string output, vectors = "magnitude", x = "time", plane = "xy", size, font, title;
  bool path = false, phase = false, script = false, force = false, json = false, quiet = false;
};

void add_plot_options(CLI::App& parser, PlotOptions& options);

/// @throws UsageError for values that make no sense
PlotPage choose_page(const PlotOptions& options);

/// The picture of the runs. @throws UsageError for a quantity or plane that they do not have
Plot choose_picture(const PlotOptions& options, const std::vector<StoredRun>& files);

/// Fails early what would fail late. @throws UsageError, SystemError
void check_outputs(const PlotOptions& options);

}  // namespace balance::app
