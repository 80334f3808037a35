#include "command.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "plot_options.hpp"
#include "read_or_run.hpp"
#include "signals.hpp"

#include "balance/base/error.hpp"
#include "balance/report/draw_picture.hpp"
#include "balance/write/json_parts.hpp"
#include "balance/write/pending_file.hpp"

#include <memory>

namespace balance::app {
namespace {

std::string description(const Plot& picture, const PlotPage& page, const std::string& file) {
  Json panels = Json::array();
  for (const PlotPanel& panel : picture.panels) {
    Json lines = Json::array();
    for (const PlotLine& line : panel.lines)
      lines.push_back({{"label", line.label}, {"colour", line.pen.colour}, {"dashes", line.pen.dashes}});
    panels.push_back({{"quantity", panel.name}, {"axis", panel.y_label}, {"lines", lines}});
  }
  return format_json({{"width", page.width}, {"height", page.height}, {"panels", panels}, {"files", {file}}});
}

std::string draw(const Plot& picture, const PlotPage& page) {
  try {
    return render_plot(picture, page);
  } catch (const SystemError&) {
    // A signal from the keyboard reaches gnuplot too.
    if (pending_signal() != 0) throw Cancelled(nothing_written_message);
    throw;
  }
}

ExitCode run(const PlotOptions& options) {
  PlotPage page = choose_page(options);
  check_outputs(options);
  check_standard_input_once(options.results);
  std::vector<StoredRun> files;
  for (const std::string& name : options.results) {
    files.push_back(load_or_simulate_run(name, options.script ? "" : options.output, "the picture"));
  }
  const Plot picture = choose_picture(options, files);
  try {
    page = resolve_page_size(picture, page);
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--size: ") + error.what());
  }
  if (options.script) {
    print(gnuplot_script(picture, page));
    return ExitCode::done;
  }
  const SignalDeferral deferred;
  const std::string bytes = draw(picture, page);
  AtomicFile file(options.output, options.force ? OverwritePolicy::replace : OverwritePolicy::forbid);
  file.write(bytes);
  if (pending_signal() != 0) throw Cancelled(nothing_written_message);
  file.commit();
  if (options.json) {
    print(description(picture, page, options.output));
  } else if (!options.quiet) {
    print_status({options.output}, format_written_message(options.output));
  }
  return ExitCode::done;
}

}  // namespace

Command setup_plot(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("plot", "Draw quantities, paths or phase planes of runs: SVG, PDF, PNG");
  const auto options = std::make_shared<PlotOptions>();
  add_plot_options(*parser, *options);
  parser->footer(
      "A quantity is named as in the result file: shaking_force is a vector's magnitude, shaking_force.x\n"
      "its component; torque is every actuator's, torque[A1] one; joint_force[B1].y goes further still.\n"
      "Without --quantity it is torque, shaking_force and shaking_moment. Several results are laid over\n"
      "each other. A spec, with a trajectory behind a colon, is run first. A phase plane shows the rate\n"
      "along the path over the place, below what limits leave. gnuplot must be installed.\n\n"
      "Examples:\n"
      "  balance plot run.h5 -o run.pdf\n"
      "  balance plot a.h5 b.h5 --quantity shaking_force --x normalised -o force.svg\n"
      "  balance plot run.h5 --quantity 'torque[A1]' -o a1.png --size 160x90\n"
      "  balance plot run.h5 --path -o path.svg --font Times,10\n"
      "  balance plot 3rrr.yaml:fast --phase -o phase.svg");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
