#include "equations_options.hpp"

#include "failure.hpp"
#include "suggestion.hpp"
#include "value_check.hpp"

#include "balance/base/nearest.hpp"
#include "balance/formulas/sheet.hpp"
#include "balance/spec/speed_option.hpp"
#include "balance/write/pending_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace balance::app {

namespace {

/// Of poses and of formulas, which share some.
std::vector<std::string> all_section_names() {
  std::vector<std::string> names = equation_section_names();
  for (const std::string& name : formulas::sheet_section_names())
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

/// What only formulas have; a pose needs those that stand before it.
void add_formula_options(CLI::App& parser, EquationsOptions& o) {
  CLI::Option* at = parser.get_option("--at");
  add_choice_validator(parser.add_option("--code", o.code, "print the torques as a program in c or python")
                           ->type_name("LANGUAGE")
                           ->excludes(at)
                           ->excludes(parser.get_option("--json"))
                           ->excludes(parser.get_option("--latex")),
                       {"c", "python"});
  parser.add_flag("--expand", o.expand, "put in what parameters are that are expressions of others")->excludes(at);
  parser.add_flag("--numbers", o.numbers, "print numbers in place of symbols")->excludes(at);
  parser.add_flag("--all", o.all, "print formulas however long they are")->excludes(at);
  for (const char* name : {"--speeds", "--trajectory", "--output"}) parser.get_option(name)->needs(at);
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
  add_state_options(parser, o,
                    "a pose (A1=0.3,A2=0.5 or tool: [0.1, 0.2], in the spec's units), start, end or a trajectory");
  parser.add_option("-t,--trajectory", o.trajectory, "whose start or end is meant; the first if not given")
      ->type_name("NAME");
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
      throw UsageError(fmt::format("--only needs {}, not {}{}", fmt::join(names, ", "), quote_for_message(name),
                                   append_nearest_name(name, names)));
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
  if (!options.constraints.empty()) choice.constrained = read_speeds(options.constraints, "--constraints", study);
  for (const GeneralisedSpeed& speed : choice.speeds)
    for (const GeneralisedSpeed& zero : choice.constrained)
      if (speed.name == zero.name)
        throw UsageError(
            fmt::format("--constraints has the name {}, too, which is one of --speeds", quote_for_message(zero.name)));
  return choice;
}

}  // namespace

EquationsQuery make_query(const EquationsOptions& options, const Study& study) {
  EquationsQuery query;
  query.speeds = read_choice(options, study);
  SingleState state = read_state(options, study);
  query.configuration = std::move(state.configuration);
  query.rates = std::move(state.rates);
  query.accelerations = std::move(state.accelerations);
  query.time = state.time;
  query.independent = options.independent;
  query.sections = choose_sections(options);
  if (!options.output.empty()) query.sections.insert(EquationSection::redundant);
  return query;
}

void check_outputs(const EquationsOptions& options, const Study& study) {
  check_standard_output({options.output}, options.spec.json || options.latex, options.output == standard_output_path);
  check_output(options.output, "the result", list_input_files(study), options.force);
}

}  // namespace balance::app
