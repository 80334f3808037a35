#include "balance/interface/reports/plot.hpp"
#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/json.hpp"
#include "balance/interface/files/result_file.hpp"
#include "balance/interface/reports/gnuplot.hpp"
#include "balance/interface/reports/gnuplot_script.hpp"
#include "balance/interface/reports/modes_request.hpp"
#include "balance/interface/reports/plot_identification.hpp"
#include "balance/interface/reports/plot_vibration.hpp"
#include "balance/mechanics/results/quantities.hpp"
#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/signals.hpp"
#include "run_operands.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace balance::app {

constexpr const char* over_rate_abscissa = "rate";  // of identifications only

using files::StoredRun;
using reports::PlotPage;

/// Options of `balance plot`.
struct PlotOptions {
  std::vector<std::string> results, quantities, labels;
  std::string output, vectors = "magnitude", x = "time", plane = "xy", size, font, title, units = "spec";
  std::string poses;  ///< their number; empty: none are drawn
  std::optional<int> orders;
  std::string sweep;  ///< of vibrations, as of `balance modes`; empty: none
  bool side_by_side = false, path = false, phase = false, script = false, force = false, json = false, quiet = false;
};

void add_plot_options(CLI::App& parser, PlotOptions& options);

/// @throws UsageError for invalid values
PlotPage choose_page(const PlotOptions& options);

/// `--poses 5` is a flag followed by an operand, since the number may be left out: moves such an operand to the flag.
/// @throws UsageError if there is no other operand, or if the number is not a number of poses
void take_pose_count(PlotOptions& options);

/// The plot of the runs. @throws UsageError for a quantity or plane that the runs do not have; SpecError, SystemError
/// if poses are drawn and a run's mechanism cannot be read
reports::Plot choose_picture(const PlotOptions& options, const std::vector<StoredRun>& files);

/// Checks before the computation that the outputs can be written. @throws UsageError, SystemError
void check_outputs(const PlotOptions& options);

namespace {

std::string description(const reports::Plot& picture, const PlotPage& page, const std::string& file) {
  Json panels = Json::array();
  for (const reports::PlotPanel& panel : picture.panels) {
    Json lines = Json::array();
    for (const reports::PlotLine& line : panel.lines)
      lines.push_back({{"label", line.label}, {"colour", line.pen.colour}, {"dashes", line.pen.dashes}});
    panels.push_back({{"quantity", panel.name}, {"axis", panel.y_label}, {"lines", lines}});
  }
  return files::format_json({{"width", page.width}, {"height", page.height}, {"panels", panels}, {"files", {file}}});
}

std::string draw(const reports::Plot& picture, const PlotPage& page) {
  try {
    return render_plot(picture, page);
  } catch (const SystemError&) {
    // Ctrl-C in the terminal also interrupts gnuplot.
    if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
    throw;
  }
}

/// @throws UsageError, SpecError, MotionFailure
reports::Plot choose_sweep_picture(const PlotOptions& options) {
  const auto name = options.results.size() == 1 ? parse_spec_trajectory_name(options.results.front()) : std::nullopt;
  if (!name) throw UsageError("--sweep: expected one spec, such as spec.yaml:trajectory");
  const Study study = read_study({.spec = name->spec});
  const specification::SpecUnits units =
      has_spec_units(options.units) ? specification::read_display_units(study.spec_text) : specification::SpecUnits{};
  ProgressLine line(options.quiet);
  try {
    const reports::VibrationReportData view = reports::analyse_modes(
        study, {.trajectory = name->trajectory, .sweep = options.sweep}, files::find_display_unit("rad/s", units),
        [&](double fraction) { line.draw_fraction("sweep", fraction); });
    if (view.modes.motion.outcome.status != MotionStatus::done)
      throw MotionFailure(view.modes.motion.outcome, study, view.modes.trajectory);
    reports::Plot picture = reports::plot_sweep(view, units);
    picture.title = options.title;
    return picture;
  } catch (const reports::SweepError& error) {
    throw UsageError(error.what());
  }
}

/// @throws UsageError
reports::Plot choose_identification_picture(const PlotOptions& options, const reports::StoredIdentification& found) {
  if (options.path || options.phase || options.orders || options.x == "angle" || options.x == "normalised")
    throw UsageError(fmt::format("{}: a result of balance identify is drawn over time or --x rate", found.path));
  const bool over_rate = options.x == over_rate_abscissa;
  const std::vector<std::string> known = list_plot_names(found);
  for (const std::string& name : options.quantities)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(fmt::format("--quantity {}: {} has no such quantity{}", quote_for_message(name), found.path,
                                   append_nearest_name(name, known)));
  const specification::SpecUnits units =
      has_spec_units(options.units) ? specification::read_display_units(found.spec_text) : specification::SpecUnits{};
  try {
    reports::Plot picture = reports::plot_identification(
        found,
        options.quantities.empty() ? std::vector<std::string>{over_rate ? "friction" : "effort"} : options.quantities,
        over_rate, units);
    picture.title = options.title;
    return picture;
  } catch (const std::invalid_argument& error) {
    throw UsageError(std::string("--x rate: ") + error.what());
  }
}

reports::Plot read_picture(const PlotOptions& options) {
  if (!options.sweep.empty()) return choose_sweep_picture(options);
  if (options.results.size() == 1)
    if (const auto found = reports::read_identification(options.results.front()))
      return choose_identification_picture(options, *found);
  if (options.x == over_rate_abscissa) throw UsageError("--x rate: expected one result of balance identify --h5");
  std::vector<StoredRun> files;
  for (const std::string& name : options.results) {
    files.push_back(
        load_or_simulate_run(name, options.script ? "" : options.output, "the picture",
                             options.poses.empty() ? AcceptedRuns::motions : AcceptedRuns::motions_and_states));
  }
  return choose_picture(options, files);
}

ExitCode run(PlotOptions options) {
  take_pose_count(options);
  PlotPage page = choose_page(options);
  check_outputs(options);
  check_standard_input_once(options.results);
  const reports::Plot picture = read_picture(options);
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
  files::AtomicFile file(options.output,
                         options.force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  file.write(bytes);
  if (pending_signal() != 0) throw files::Cancelled(nothing_written_message);
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
      "Quantities are named as in the result file: shaking_force is a vector's magnitude, shaking_force.x\n"
      "one component; torque is that of every actuator, torque[A1] of one; joint_force[B1].y combines both.\n"
      "The default is torque, shaking_force and shaking_moment. Several results share one picture. A spec,\n"
      "optionally followed by a colon and a trajectory, is simulated first. A phase plane shows the rate\n"
      "along the path over the position, with the largest allowed rate. gnuplot must be installed.\n\n"
      "Of a file of balance identify --h5, effort, residual and friction are drawn; effort[A1] is one channel.\n\n"
      "With --poses, paths are drawn with the mechanism: at the start, in the middle and at the end, or at N\n"
      "evenly spaced times. Mechanisms in space are projected; --plane isometric shows all three axes.\n\n"
      "Examples:\n"
      "  balance plot run.h5 -o run.pdf\n"
      "  balance plot a.h5 b.h5 --quantity shaking_force --x normalised -o force.svg\n"
      "  balance plot run.h5 --path --poses -o poses.svg\n"
      "  balance plot a.h5 b.h5 --path --poses 5 --side-by-side -o poses.pdf\n"
      "  balance plot engine.yaml --orders 8 -o orders.svg\n"
      "  balance plot engine.yaml --quantity torque --x angle -o turning-moment.svg\n"
      "  balance plot found.h5 --x rate -o friction.svg\n"
      "  balance plot frame-on-mounts.yaml:run --sweep A=2:70 -o campbell.svg");
  return {parser, [options] { return run(*options); }};
}

namespace {

const std::vector<std::string> views = {"magnitude", "components", "both"};
const std::vector<std::string> abscissas = {"time", "normalised", "angle", over_rate_abscissa};
const std::vector<std::string> suffixes = {"svg", "pdf", "png"};
constexpr double min_page_side = 30, max_page_side = 1000;  // mm
constexpr int default_pose_count = 3;
constexpr int max_plotted_order = 64;                    // more bars cannot be distinguished
constexpr double min_font_size = 4, max_font_size = 72;  // pt

std::size_t position(const char* option, const std::string& word, const std::vector<std::string>& words) {
  const auto entry = std::find(words.begin(), words.end(), word);
  if (entry == words.end())
    throw UsageError(fmt::format("{} {}: expected {}{}", option, quote_for_message(word), join_alternatives(words),
                                 append_nearest_name(word, words)));
  return static_cast<std::size_t>(entry - words.begin());
}

reports::PlotFileFormat choose_format(const std::string& output) {
  if (output.empty() || output == files::standard_output_path) return reports::PlotFileFormat::svg;
  std::string suffix = std::filesystem::path(output).extension().string();
  if (!suffix.empty()) suffix.erase(0, 1);
  if (std::find(suffixes.begin(), suffixes.end(), suffix) == suffixes.end())
    throw UsageError(fmt::format("--output {}: the name must end with .svg, .pdf or .png", quote_for_message(output)));
  return static_cast<reports::PlotFileFormat>(position("--output", suffix, suffixes));
}

/// Parses a number that spans the whole text and lies within the bounds.
bool parse(std::string_view text, double low, double high, double& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number >= low && number <= high;
}

void choose_size(const std::string& text, PlotPage& page) {
  const std::size_t cross = text.find('x');
  const bool is_valid = cross != std::string::npos &&
                        parse(std::string_view(text).substr(0, cross), min_page_side, max_page_side, page.width) &&
                        parse(std::string_view(text).substr(cross + 1), min_page_side, max_page_side, page.height);
  if (!is_valid)
    throw UsageError(fmt::format("--size {}: expected WIDTHxHEIGHT in mm, each from {:g} to {:g}, such as 120x80",
                                 quote_for_message(text), min_page_side, max_page_side));
}

void choose_font(const std::string& text, PlotPage& page) {
  const std::size_t comma = text.find(',');
  page.font = text.substr(0, comma);
  const bool has_valid_name = !page.font.empty() && std::all_of(page.font.begin(), page.font.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == ' ' || c == '-';
  });
  const bool has_valid_size = comma == std::string::npos || parse(std::string_view(text).substr(comma + 1),
                                                                  min_font_size, max_font_size, page.font_size);
  if (!has_valid_name || !has_valid_size)
    throw UsageError(
        fmt::format("--font {}: expected NAME or NAME,SIZE, the name of letters, digits, blanks and hyphens, the "
                    "size from {:g} to {:g} pt, such as 'Times,10'",
                    quote_for_message(text), min_font_size, max_font_size));
}

/// Label that distinguishes the files: the name without folder and suffix, and the group.
std::string default_label(const StoredRun& file) {
  const std::string stem = escape_for_terminal(std::filesystem::path(file.path).stem().string());
  return file.group.empty() ? stem : stem + " " + file.group;
}

std::vector<reports::PlotRun> label_runs(const PlotOptions& options, const std::vector<StoredRun>& files) {
  if (!options.labels.empty() && options.labels.size() != files.size())
    throw UsageError(fmt::format("--label is given {} times for {} results: expected one per result, in order",
                                 options.labels.size(), files.size()));
  std::vector<reports::PlotRun> runs;
  std::set<std::string> used;
  bool has_duplicate = false;
  for (std::size_t i = 0; i < files.size(); ++i) {
    runs.push_back({options.labels.empty() ? default_label(files[i]) : options.labels[i], &files[i].result});
    has_duplicate = has_duplicate || !used.insert(runs.back().label).second;
  }
  // Files with the same name in several folders.
  if (has_duplicate && options.labels.empty())
    for (std::size_t i = 0; i < files.size(); ++i)
      runs[i].label =
          escape_for_terminal(files[i].group.empty() ? files[i].path : files[i].path + ":" + files[i].group);
  return runs;
}

/// Units that all specs have in common; SI if they differ.
specification::SpecUnits choose_units(const PlotOptions& options, const std::vector<StoredRun>& files) {
  if (!has_spec_units(options.units)) return {};
  const auto is_same = [](const specification::SpecUnits& a, const specification::SpecUnits& b) {
    return a.length == b.length && a.mass == b.mass && a.time == b.time && a.angle == b.angle && a.force == b.force;
  };
  specification::SpecUnits common;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const specification::SpecUnits units = specification::read_display_units(files[i].spec_text);
    if (i == 0) common = units;
    if (!is_same(common, units)) return {};
  }
  return common;
}

/// The most important quantities for designers that all runs have.
std::vector<std::string> default_quantities(const std::vector<StoredRun>& files) {
  std::vector<std::string> names = {"torque", "shaking_force", "shaking_moment"};
  std::erase_if(names, [&](const std::string& name) {
    return !std::all_of(files.begin(), files.end(), [&](const StoredRun& file) {
      const auto quantity = find_plot_quantity(file.result, name, reports::VectorView::magnitude);
      return quantity && quantity->unit != "mixed";
    });
  });
  return names;
}

void check_names(const std::vector<std::string>& names, const std::vector<StoredRun>& files) {
  for (const StoredRun& file : files) {
    const std::vector<std::string> known = reports::list_plot_names(file.result);
    for (const std::string& name : names)
      if (std::find(known.begin(), known.end(), results::resolve_quantity_name(name, known)) == known.end())
        throw UsageError(fmt::format("--quantity {}: {} has no such quantity{}", quote_for_message(name), file.path,
                                     append_nearest_name(name, known)));
  }
}

/// Whether a text begins with a number, so that it cannot be meant as a file.
bool is_numeric(const std::string& text) {
  double number = 0;
  return parse(text, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), number);
}

/// @throws UsageError unless it is empty or a number of poses
int count_poses(const std::string& text) {
  double count = 0;
  if (text.empty()) return 0;
  if (!parse(text, 1, reports::max_poses, count) || count != std::floor(count))
    throw UsageError(
        fmt::format("--poses {}: expected a whole number from 1 to {}", quote_for_message(text), reports::max_poses));
  return static_cast<int>(count);
}

}  // namespace

void take_pose_count(PlotOptions& options) {
  std::vector<std::string>& runs = options.results;
  const auto number = std::find_if(runs.begin(), runs.end(), [](const std::string& name) {
    std::error_code ignored;
    return is_numeric(name) && !std::filesystem::exists(name, ignored);
  });
  if (!options.poses.empty() && number != runs.end()) {
    options.poses = *number;
    runs.erase(number);
    if (runs.empty()) throw UsageError("no run given: balance plot needs a result file or a spec");
  }
  count_poses(options.poses);
}

void add_plot_options(CLI::App& parser, PlotOptions& o) {
  add_run_operands(parser, o.results);
  CLI::Option* quantity =
      parser.add_option("--quantity", o.quantities, "quantity to draw over time; may be repeated, one panel each");
  quantity->type_name("NAME")->allow_extra_args(false);
  suggest_words(quantity,
                {"torque",           "power",          "shaking_force",    "shaking_moment",     "ground_force",
                 "ground_moment",    "com_position",   "com_velocity",     "com_acceleration",   "tool_position",
                 "tool_orientation", "joint_position", "joint_velocity",   "joint_acceleration", "joint_force",
                 "joint_moment",     "kinetic_energy", "potential_energy", "mobility",           "newton_iterations",
                 "torque_measured",  "torque_residual"});
  CLI::Option* path = parser.add_flag("--path", o.path, "draw the paths of tool and centre of mass instead");
  path->excludes(quantity);
  CLI::Option* phase =
      parser.add_flag("--phase", o.phase, "draw the rate along the path over the position, and its limit, instead");
  phase->excludes(quantity)->excludes(path);
  parser
      .add_option("--sweep", o.sweep,
                  "draw vibrations over a speed or a parameter of the spec instead, as of balance modes")
      ->type_name("NAME=FROM:TO:COUNT")
      ->excludes(quantity)
      ->excludes(path)
      ->excludes(phase);
  suggest_files(
      parser.add_option("-o,--output", o.output, "the picture: .svg, .pdf or .png; - is SVG on standard output")
          ->type_name("FILE"),
      suffixes);
  const auto choice = [&](const char* name, std::string& value, const char* text,
                          const std::vector<std::string>& words) {
    CLI::Option* option = parser.add_option(name, value, text);
    suggest_words(option->type_name("NAME")->capture_default_str(), words);
    return option;
  };
  choice("--vectors", o.vectors, "draw vectors as magnitude, components or both", views)
      ->excludes(path)
      ->excludes(phase);
  CLI::Option* abscissa =
      choice("--x", o.x, "time, time by the duration, the angle of what turns at constant speed, or the rate of joints",
             abscissas)
          ->excludes(path)
          ->excludes(phase);
  parser.add_option("--orders", o.orders, "draw the amplitudes of the orders 1 to N of a motion at constant speed")
      ->type_name("N")
      ->check(integer_range_validator(1, max_plotted_order))
      ->excludes(path)
      ->excludes(phase)
      ->excludes(abscissa);
  choice("--plane", o.plane, "view of paths: plane xy, xz or yz, or isometric", reports::list_projections())
      ->needs(path);
  parser
      .add_flag(fmt::format("--poses{{{}}}", default_pose_count), o.poses,
                "draw the mechanism along the path, --poses N at N times (start, middle and end by default)")
      ->needs(path);
  parser.add_flag("--side-by-side", o.side_by_side, "one frame per run for paths, at the same scale")->needs(path);
  parser.add_option("--label", o.labels, "name of a result in the legend; once per result, in order")
      ->type_name("TEXT")
      ->allow_extra_args(false);
  add_units_option(parser, o.units);
  parser.add_option("--title", o.title, "text above the picture")->type_name("TEXT");
  parser.add_option("--size", o.size, "width and height in mm (default: height as needed)")->type_name("WxH");
  parser.add_option("--font", o.font, "font and its size in points")->type_name("NAME[,SIZE]");
  parser.add_flag("--script", o.script, "print the gnuplot script for editing, and draw nothing");
  parser.add_flag("--force", o.force, "overwrite an existing file");
  CLI::Option* json = parser.add_flag("--json", o.json, "print JSON, errors included");
  json->excludes(parser.get_option("--script"));
  parser.add_flag("-q,--quiet", o.quiet, "print only errors (and JSON with --json)");
}

PlotPage choose_page(const PlotOptions& options) {
  PlotPage page;
  page.format = choose_format(options.output);
  if (!options.size.empty()) choose_size(options.size, page);
  if (!options.font.empty()) choose_font(options.font, page);
  return page;
}

reports::Plot choose_picture(const PlotOptions& options, const std::vector<StoredRun>& files) {
  std::vector<reports::PlotRun> runs = label_runs(options, files);
  const auto view = static_cast<reports::VectorView>(position("--vectors", options.vectors, views));
  const auto axis = static_cast<reports::Abscissa>(position("--x", options.x, abscissas));
  position("--plane", options.plane, reports::list_projections());
  check_names(options.quantities, files);
  const specification::SpecUnits units = choose_units(options, files);
  const reports::PathView paths{options.plane, count_poses(options.poses), options.side_by_side};
  std::vector<Mechanism> mechanisms;
  if (paths.poses > 0)
    for (const StoredRun& file : files) mechanisms.push_back(read_run_mechanism(file));
  for (std::size_t i = 0; i < mechanisms.size(); ++i) runs[i].mechanism = &mechanisms[i];
  const std::vector<std::string> quantities =
      options.quantities.empty() ? default_quantities(files) : options.quantities;
  try {
    reports::Plot picture = options.phase    ? plot_phase_plane(runs)
                            : options.path   ? plot_paths(runs, paths, units)
                            : options.orders ? plot_orders(runs, quantities, *options.orders, view, units)
                                             : plot_over_time(runs, quantities, view, axis, units);
    picture.title = options.title;
    return picture;
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
}

void check_outputs(const PlotOptions& options) {
  if (options.script) return;
  if (options.output.empty()) throw UsageError("--output is needed: the name of a .svg, .pdf or .png file");
  std::vector<files::InputFile> inputs;
  for (const std::string& result : options.results) inputs.push_back({result, "its input"});
  check_output(options.output, "the picture", FileFormat::other, inputs, options.force);
}

}  // namespace balance::app
