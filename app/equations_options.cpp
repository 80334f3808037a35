#include "equations_options.hpp"

#include "failure.hpp"
#include "suggestion.hpp"

#include "balance/base/nearest.hpp"
#include "balance/equations/configuration.hpp"
#include "balance/formulas/sheet.hpp"
#include "balance/simulation/simulate.hpp"
#include "balance/spec/speed_option.hpp"
#include "balance/write/file_identity.hpp"
#include "balance/write/pending_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace balance::app {

namespace {

const Trajectory* find_trajectory(const std::string& name, const Study& study) {
  const auto at = std::find_if(study.trajectories.begin(), study.trajectories.end(),
                               [&](const Trajectory& t) { return t.name == name; });
  return at == study.trajectories.end() ? nullptr : &*at;
}

/// Whose start or end is meant.
const Trajectory& chosen_trajectory(const EquationsOptions& options, const Study& study) {
  if (study.trajectories.empty())
    throw UsageError(fmt::format("{} has no motion: --at {} needs one", study.spec_file, options.at));
  if (options.trajectory.empty()) return study.trajectories.front();
  if (const Trajectory* found = find_trajectory(options.trajectory, study)) return *found;
  std::vector<std::string> names;
  for (const Trajectory& t : study.trajectories) names.push_back(t.name);
  throw UsageError(fmt::format("{} has no trajectory {}, only {}{}", study.spec_file, in_quotes(options.trajectory),
                               fmt::join(names, ", "), nearest_hint(options.trajectory, names)));
}

std::vector<CoordinateValue> configuration_of(const Mechanism& mechanism, const PoseTarget& pose) {
  Configured found = find_configuration(mechanism, pose);
  if (found.outcome.status != MotionStatus::done) throw MotionFailure(found.outcome);
  return std::move(found.coordinates);
}

/// Where a run ends, in the assembly mode that it comes in.
std::vector<CoordinateValue> end_of(const Mechanism& mechanism, Trajectory trajectory) {
  trajectory.samples = 2;
  const Result run = simulate(mechanism, trajectory);
  if (run.outcome.status != MotionStatus::done) throw MotionFailure(run.outcome);
  std::vector<CoordinateValue> values;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    values.push_back({static_cast<int>(c), run.joint_position(run.joint_position.rows() - 1, c)});
  return values;
}

std::vector<CoordinateValue> find_pose(const EquationsOptions& options, const Study& study) {
  if (options.at == "end") return end_of(study.mechanism, chosen_trajectory(options, study));
  if (options.at != "start") return configuration_of(study.mechanism, read_pose(options.at, study));
  const Trajectory& trajectory = chosen_trajectory(options, study);
  if (!std::holds_alternative<TablePath>(trajectory.path) && !binds_rates(study.mechanism))
    return configuration_of(study.mechanism, trajectory.from);
  // a table has its start in itself; where rates are bound, `from` may leave the configuration to `assembly`
  const Result run = simulate(study.mechanism, trajectory);
  if (run.outcome.status != MotionStatus::done) throw MotionFailure(run.outcome);
  std::vector<CoordinateValue> values;
  for (Eigen::Index c = 0; c < run.joint_position.cols(); ++c)
    values.push_back({static_cast<int>(c), run.joint_position(0, c)});
  return values;
}

}  // namespace

namespace {

/// Of poses and of formulas, which share some.
std::vector<std::string> all_section_names() {
  std::vector<std::string> names = equation_section_names();
  for (const std::string& name : formulas::section_names())
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

/// What only formulas have; a pose needs those that stand before it.
void add_formula_options(CLI::App& parser, EquationsOptions& o) {
  CLI::Option* at = parser.get_option("--at");
  suggest_words(parser.add_option("--code", o.code, "print the torques as a program in c or python")
                    ->type_name("LANGUAGE")
                    ->check(CLI::IsMember({"c", "python"}))
                    ->excludes(at)
                    ->excludes(parser.get_option("--json"))
                    ->excludes(parser.get_option("--latex")),
                {"c", "python"});
  parser.add_flag("--expand", o.expand, "put in what parameters are that are expressions of others")->excludes(at);
  parser.add_flag("--numbers", o.numbers, "print numbers in place of symbols")->excludes(at);
  parser.add_flag("--all", o.all, "print formulas however long they are")->excludes(at);
  for (const char* name :
       {"--rates", "--accelerations", "--speeds", "--time", "--trajectory", "--independent", "--output"})
    parser.get_option(name)->needs(at);
}

}  // namespace

namespace {

bool is_blank(const std::string& text) { return text.find_first_not_of(" \t\r\n") == std::string::npos; }

void add_speed_options(CLI::App& parser, EquationsOptions& o) {
  const auto not_blank = [](const std::string& text) {
    return is_blank(text) ? "expected speeds, found an empty text" : "";
  };
  CLI::Option* speeds =
      parser
          .add_option("--speeds", o.speeds,
                      "the equation in these speeds, too: sums of rates of coordinates and of the tool's, as\n"
                      "\"v: tool.u, w: {A: 0.5, B: -0.5}\"")
          ->type_name("NAME: TERMS,...")
          ->check(not_blank);
  parser.add_option("--constraints", o.constraints, "speeds that are zero, as of wheels that roll: \"slip: tool.v\"")
      ->type_name("NAME: TERMS,...")
      ->check(not_blank)
      ->needs(speeds);
  for (const char* name : {"--latex", "--output"}) speeds->excludes(parser.get_option(name));
}

}  // namespace

void add_equations_options(CLI::App& parser, EquationsOptions& o) {
  add_spec_options(parser, o.spec);
  parser
      .add_option("--at", o.at,
                  "a pose (A1=0.3,A2=0.5 or tool: [0.1, 0.2], in the spec's units), start, end or a trajectory")
      ->type_name("POSE")
      ->check([](const std::string& text) { return is_blank(text) ? "expected a pose, found an empty text" : ""; });
  parser.add_option("--rates", o.rates, "rates of the independent coordinates there; those not named are 0")
      ->type_name("NAME=V,...");
  parser.add_option("--accelerations", o.accelerations, "their accelerations")->type_name("NAME=V,...");
  parser.add_option("--time", o.time, "seconds at which loads that change are taken, and payloads that come and go")
      ->type_name("T");
  parser.add_option("-t,--trajectory", o.trajectory, "whose start or end is meant; the first if not given")
      ->type_name("NAME");
  parser.add_option("--independent", o.independent, "independent coordinates, between commas; else the actuated ones")
      ->type_name("NAMES")
      ->delimiter(',')
      ->allow_extra_args(false);
  suggest_words(parser.add_option("--only", o.only, "what is wanted, between commas")
                    ->type_name("NAMES")
                    ->delimiter(',')
                    ->allow_extra_args(false),
                all_section_names());
  CLI::Option* latex = parser.add_flag("--latex", o.latex, "print LaTeX (amsmath) and nothing else");
  latex->excludes(parser.get_option("--json"));
  CLI::Option* output = parser.add_option("-o,--output", o.output, "write the matrices to this HDF5 file");
  output->type_name("FILE");
  parser.add_flag("--force", o.force, "replace a file that exists");
  parser.add_flag("--compress", o.compress, "compress the HDF5 file; slow")->needs(output);
  add_speed_options(parser, o);
  add_formula_options(parser, o);
}

std::set<EquationSection> choose_sections(const EquationsOptions& options) {
  using enum EquationSection;
  const std::vector<std::string>& names = equation_section_names();
  std::set<EquationSection> sections;
  for (const std::string& name : options.only) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      throw UsageError(
          fmt::format("--only needs {}, not {}{}", fmt::join(names, ", "), in_quotes(name), nearest_hint(name, names)));
    sections.insert(static_cast<EquationSection>(at - names.begin()));
  }
  if (!sections.empty()) return sections;
  sections = {inertia, velocity, gravity, torques, parameters};
  if (options.spec.json) sections.insert({redundant, natural, regressor});
  return sections;
}

const Trajectory* trajectory_at(const EquationsOptions& options, const Study& study) {
  return options.at == "start" || options.at == "end" ? nullptr : find_trajectory(options.at, study);
}

namespace {

SpeedChoice read_choice(const EquationsOptions& options, const Study& study) {
  SpeedChoice choice;
  if (!options.speeds.empty()) choice.speeds = read_speeds(options.speeds, "--speeds", study);
  if (options.speeds.empty() && !options.latex && options.output.empty()) choice.speeds = study.speeds;
  if (!options.constraints.empty()) choice.zero = read_speeds(options.constraints, "--constraints", study);
  for (const Speed& speed : choice.speeds)
    for (const Speed& zero : choice.zero)
      if (speed.name == zero.name)
        throw UsageError(
            fmt::format("--constraints has the name {}, too, which is one of --speeds", in_quotes(zero.name)));
  return choice;
}

}  // namespace

EquationsQuery make_query(const EquationsOptions& options, const Study& study) {
  if (!std::isfinite(options.time)) throw UsageError("--time needs a finite number of seconds");
  EquationsQuery query;
  if (!options.rates.empty()) query.rates = read_rates(options.rates, "--rates", study);
  if (!options.accelerations.empty()) query.accelerations = read_rates(options.accelerations, "--accelerations", study);
  query.speeds = read_choice(options, study);
  query.configuration = find_pose(options, study);
  query.time = options.time;
  query.independent = options.independent;
  query.sections = choose_sections(options);
  if (!options.output.empty()) query.sections.insert(EquationSection::redundant);
  return query;
}

void check_outputs(const EquationsOptions& options, const Study& study) {
  check_standard_output({options.output}, options.spec.json || options.latex, options.output == standard_output);
  if (options.output.empty()) return;
  if (same_file(options.output, options.spec.spec))
    throw UsageError("the result would replace the spec: " + options.output);
  keep_tables(options.output, "the result", study);
  check_writable(options.output, options.force ? Existing::replace : Existing::keep);
}

}  // namespace balance::app
