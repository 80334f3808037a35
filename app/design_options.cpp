#include "design_options.hpp"

#include "cli/failures.hpp"
#include "cli/help.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/files/provenance.hpp"
#include "balance/synthesis/design/catalogue_search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace balance::app {
namespace {

const std::vector<std::string> global_algorithms = {"crs", "direct", "isres", "esch", "mlsl"};
const std::vector<std::string> local_algorithms = {"auto", "slsqp", "auglag", "cobyla", "bobyqa", "sbplx"};

std::vector<std::string> algorithms() {
  std::vector<std::string> all = global_algorithms;
  all.insert(all.end(), local_algorithms.begin(), local_algorithms.end());
  return all;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void choose_algorithm(const std::string& name, study::SearchOptions& search) {
  if (name.empty()) return;
  if (contains(global_algorithms, name)) {
    search.global = name;
  } else if (contains(local_algorithms, name)) {
    search.local = name;
  } else {
    throw UsageError(fmt::format("--algorithm {}: expected {}{}", quote_for_message(name),
                                 join_alternatives(algorithms()), append_nearest_name(name, algorithms())));
  }
}

std::vector<ObjectiveTerm> choose_objective(const std::string& text, const Study& study) {
  return text.empty() ? std::vector<ObjectiveTerm>{} : specification::read_objective(text, study);
}

/// Command line that reproduces the file; see make_provenance.
std::string command_line(const DesignCommandOptions& o, const Study& study) {
  std::vector<std::string> words = {"balance", "design", std::filesystem::path(o.spec.spec).filename().string()};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {name, value});
  };
  for (const std::string& goal : o.goal.goals) add("--goal", goal);
  add("--minimize", o.minimize);
  add("--point", o.point);
  if (o.goal.strategy != "complete") add("--strategy", o.goal.strategy);
  for (const std::string& names : o.goal.without) add("--without", names);
  add("--algorithm", o.algorithm);
  if (o.seconds > 0) add("--seconds", fmt::format("{}", o.seconds));
  if (o.starts > 0) add("--starts", std::to_string(o.starts));
  if (o.goal.seed) add("--seed", std::to_string(*o.goal.seed));
  files::append_overrides(words, study);
  return files::join_command(std::move(words));
}

}  // namespace

void add_seconds_option(CLI::App& parser, double& seconds) {
  parser.add_option("--seconds", seconds, "limit of the search in CPU seconds (default: as in the spec)")
      ->type_name("S")
      ->check(number_range_validator(1e-3, 1e9));
}

void add_design_options(CLI::App& parser, DesignCommandOptions& o) {
  add_spec_options(parser, o.spec);
  add_units_option(parser, o.spec.units);
  parser.add_option("-o,--output", o.output, "write the spec with its free numbers filled in")->type_name("FILE");
  parser.add_option("--h5", o.h5, "write numbers, conditions and all runs to this HDF5 file")->type_name("FILE");
  parser.add_option("--certificate", o.certificate, "write the proof that nothing is lighter at any lengths")
      ->type_name("FILE");
  parser.add_option("--csv", o.csv, "write the points of the front to this CSV file")->type_name("FILE");
  parser.add_option("--point", o.point, "design of the front to show and, with -o, to write: a number or middle")
      ->type_name("K");
  add_goal_options(parser, o.goal);
  parser.add_option("--minimize", o.minimize, "objective among exact solutions, as in the spec's design section")
      ->type_name("YAML");
  CLI::Option* algorithm =
      parser.add_option("--algorithm", o.algorithm,
                        fmt::format("search algorithm; global: {}; local: {}", fmt::join(global_algorithms, ", "),
                                    fmt::join(local_algorithms, ", ")));
  suggest_words(algorithm->type_name("NAME"), algorithms());
  add_seconds_option(parser, o.seconds);
  parser.add_option("--starts", o.starts, "start points for solving the conditions (default: as in the spec)")
      ->type_name("N")
      ->check(integer_range_validator(1, 10'000));
  parser.add_flag("--force", o.force, "overwrite existing files");
  parser.add_flag("-q,--quiet", o.quiet, "print only errors (and JSON with --json)");
}

DesignStudyOptions make_study_options(const DesignCommandOptions& options, const Study& study) {
  DesignStudyOptions result;
  result.is_modular = is_modular(options.goal);
  result.excluded = choose_excluded_elements(options.goal, study.mechanism);
  result.minimize = choose_objective(options.minimize, study);
  // Without goals there must be an objective, constraints or a front.
  const bool nothing = result.minimize.empty() && study.design.minimize.empty() && study.design.subject_to.empty() &&
                       !study.design.front;
  result.goals =
      choose_goals(options.goal, study, nothing ? GoalRequirement::goal_or_objective : GoalRequirement::none);
  result.search = study.design.search;
  choose_algorithm(options.algorithm, result.search);
  if (options.goal.seed) result.search.seed = *options.goal.seed;
  if (options.seconds > 0) result.search.max_time = options.seconds;
  if (options.starts > 0) result.search.max_restarts = options.starts;
  result.keeps_certificates = !options.certificate.empty();
  result.compare_trajectories = !options.quiet || options.spec.json || !options.h5.empty();
  if (study.free_numbers.empty() && !design::has_free_rows(study)) {
    throw SpecError({.place = {.file = study.spec_file},
                     .message = "there is nothing to design: no number is free; write {free: [lower, upper]} in "
                                "place of a number, for instance mass: {free: [0, 10]} of a counterweight"});
  }
  return result;
}

void check_outputs(const DesignCommandOptions& options, const Study& study) {
  check_standard_output({options.output, options.csv, options.h5, options.certificate}, options.spec.json,
                        options.h5 == files::standard_output_path);
  const std::vector<files::InputFile> inputs = list_input_files(study);
  check_output(options.output, "the design", FileFormat::yaml, inputs, options.force);
  check_output(options.h5, "the result", FileFormat::hdf5, inputs, options.force);
  check_output(options.csv, "the table", FileFormat::csv, inputs, options.force);
  check_output(options.certificate, "the certificate", FileFormat::json, inputs, options.force);
  if (!options.h5.empty() && !options.output.empty() && files::is_same_file(options.h5, options.output))
    throw UsageError("--output and --h5 name the same file: " + options.output);
  for (const std::string& other : {options.output, options.h5})
    if (!options.csv.empty() && !other.empty() && files::is_same_file(options.csv, other))
      throw UsageError("--csv names the same file as another option: " + options.csv);
  for (const std::string& other : {options.output, options.h5, options.csv})
    if (!options.certificate.empty() && !other.empty() && files::is_same_file(options.certificate, other))
      throw UsageError("--certificate names the same file as another option: " + options.certificate);
}

files::Provenance describe(const DesignCommandOptions& options, const Study& study) {
  return files::make_provenance(study, command_line(options, study));
}

}  // namespace balance::app
