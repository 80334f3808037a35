#include "cli/command.hpp"
#include "cli/console.hpp"
#include "cli/failures.hpp"
#include "cli/option_values.hpp"
#include "cli/signals.hpp"
#include "cli/validators.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/files/atomic_file.hpp"
#include "balance/interface/reports/excitation_sections.hpp"
#include "balance/interface/reports/excited_spec.hpp"
#include "balance/interface/specification/display_units.hpp"
#include "balance/interface/specification/spec_edit.hpp"
#include "balance/mechanics/results/limitable_quantities.hpp"
#include "balance/synthesis/identification/excitation.hpp"
#include "balance/synthesis/identification/motion_equation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>

namespace balance::app {
namespace {

using identification::ExcitationLimit;
using Kind = ExcitationLimit::Kind;

constexpr double default_seconds = 30;

struct ExciteOptions {
  SpecOptions spec;
  std::vector<std::string> limits;            ///< NAME=BOUND
  std::string limits_of;                      ///< a trajectory
  std::vector<std::string> noise_deviations;  ///< NAME=NUMBER
  double duration = 10, base_frequency = 0, rate = 250, mobility = 0.1, rest_rate = 0.02;
  int harmonics = 5, starts = 3;
  double seconds = 0;
  int evaluations = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> payloads;
  std::string passive_friction = "viscous";
  bool has_frame_sensor = false;
  std::string name = "excitation", output, csv;
  bool force = false;
};

/// What the words of --limit and --noise mean for a mechanism, in the units of its spec.
class ExciteRequest {
 public:
  ExciteRequest(const ExciteOptions& options, const Study& study)
      : options_(options),
        study_(study),
        mechanism_(study.mechanism),
        units_(specification::read_display_units(study.spec_text)),
        force_(specification::read_force_unit(study.spec_text)),
        independent_(identification::MotionEquations(mechanism_).independent()) {}

  identification::ExcitationOptions make() {
    identification::ExcitationOptions request;
    using identification::PassiveFriction;
    request.unknowns.passive_friction = options_.passive_friction == "none"  ? PassiveFriction::none
                                        : options_.passive_friction == "dry" ? PassiveFriction::dry
                                                                             : PassiveFriction::viscous;
    request.unknowns.payloads = options_.payloads;
    check_payloads();
    request.harmonics = options_.harmonics;
    set_timing(request);
    if (!options_.limits_of.empty()) take_limits_of(choose_trajectory(study_, options_.limits_of));
    for (const std::string& text : options_.limits) take_limit(text);
    request.limits = limits_;
    request.has_frame_sensor = options_.has_frame_sensor;
    request.noise_deviations = list_noise();
    request.sampling_rate = options_.rate;
    request.min_mobility = options_.mobility;
    request.rest_rate = options_.rest_rate;
    request.starts = options_.starts;
    request.seed = options_.seed;
    request.max_evaluations = options_.evaluations;
    request.max_time = options_.seconds > 0 ? options_.seconds : options_.evaluations > 0 ? 0 : default_seconds;
    return request;
  }

 private:
  void check_payloads() const {
    std::vector<std::string> names;
    for (const Attachment& attachment : mechanism_.attachments)
      if (attachment.kind == AttachmentKind::payload) names.push_back(attachment.name);
    for (const std::string& name : options_.payloads)
      if (std::find(names.begin(), names.end(), name) == names.end())
        throw UsageError(names.empty()
                             ? std::string("--find-payload: the spec has no payloads")
                             : fmt::format("--find-payload: no payload {}; expected {}{}", quote_for_message(name),
                                           join_alternatives(names), append_nearest_name(name, names)));
  }

  /// The duration is a whole number of periods.
  void set_timing(identification::ExcitationOptions& request) const {
    const double duration = options_.duration * units_.time;
    const double periods = options_.base_frequency > 0 ? options_.base_frequency * duration : 1;
    request.periods = static_cast<int>(std::lround(periods));
    if (request.periods < 1 || std::abs(periods - request.periods) > 1e-6 * periods)
      throw UsageError(fmt::format(
          "--base-frequency: expected a whole number of periods within the duration, found {:.6g}", periods));
    request.period = duration / request.periods;
  }

  double position_unit(CoordinateId c) const {
    return is_length_coordinate(mechanism_, c) ? units_.length : units_.angle;
  }
  double effort_unit(CoordinateId c) const {
    return is_length_coordinate(mechanism_, c) ? force_ : force_ * units_.length;
  }

  void set(Kind kind, int index, double lower, double upper) {
    for (ExcitationLimit& limit : limits_)
      if (limit.kind == kind && limit.index == index) {
        limit.lower = lower, limit.upper = upper;
        return;
      }
    limits_.push_back({kind, index, lower, upper});
  }

  /// Coordinates that have efforts, in the order of the indices of their limits.
  std::vector<CoordinateId> effort_coordinates() const {
    return mechanism_.actuators.empty()
               ? independent_
               : std::vector<CoordinateId>(mechanism_.actuators.begin(), mechanism_.actuators.end());
  }

  std::vector<std::string> known_names() const {
    std::vector<std::string> names;
    for (const Coordinate& coordinate : mechanism_.coordinates) names.push_back(coordinate.name);
    return names;
  }

  /// "A1", "A1.rate", "rate": the words of the columns of a record, and those that mean all coordinates.
  void take_limit(const std::string& text) {
    const auto [name, bound] = split_assignment(text, "--limit", "NAME=BOUND");
    static const std::vector<std::pair<std::string, Kind>> words{{"position", Kind::position},
                                                                 {"rate", Kind::rate},
                                                                 {"acceleration", Kind::acceleration},
                                                                 {"effort", Kind::effort}};
    const std::size_t dot = name.rfind('.');
    for (const auto& [word, kind] : words) {
      if (name == word && find_coordinate(name) < 0) {
        const std::vector<CoordinateId> all = kind == Kind::effort ? effort_coordinates() : independent_;
        for (const CoordinateId c : all) limit_coordinate(kind, c, name, bound);
        return;
      }
      if (dot != std::string::npos && name.substr(dot + 1) == word && find_coordinate(name) < 0) {
        limit_coordinate(kind, require_coordinate(name.substr(0, dot)), name, bound);
        return;
      }
    }
    limit_coordinate(Kind::position, require_coordinate(name), name, bound);
  }

  int find_coordinate(const std::string& name) const {
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c)
      if (mechanism_.coordinates[c].name == name) return static_cast<int>(c);
    return -1;
  }
  CoordinateId require_coordinate(const std::string& name) const {
    const int found = find_coordinate(name);
    if (found >= 0) return found;
    std::vector<std::string> names = known_names();
    for (const char* word : {"position", "rate", "acceleration", "effort"}) names.emplace_back(word);
    throw UsageError(
        fmt::format("--limit: no coordinate {}; expected {}, alone or with .rate, .acceleration or .effort{}",
                    quote_for_message(name), join_alternatives(names), append_nearest_name(name, names)));
  }

  void limit_coordinate(Kind kind, CoordinateId c, const std::string& name, const std::string& bound) {
    const std::size_t colon = bound.find(':');
    const std::string option = "--limit " + name;
    double lower = 0, upper = 0;
    if (colon != std::string::npos) {
      lower = parse_number_option(bound.substr(0, colon), option),
      upper = parse_number_option(bound.substr(colon + 1), option);
    } else {
      upper = parse_number_option(bound, option), lower = -upper;
    }
    if (!(lower < upper))
      throw UsageError(fmt::format("{}: expected a number > 0 or LEAST:MOST with LEAST < MOST, found {}", option,
                                   quote_for_message(bound)));
    if (kind == Kind::rate || kind == Kind::acceleration)
      if (!(lower < 0 && upper > 0))
        throw UsageError(
            fmt::format("{}: a motion from rest to rest has both signs; expected LEAST < 0 < MOST", option));
    double unit = position_unit(c);
    if (kind == Kind::rate) unit /= units_.time;
    if (kind == Kind::acceleration) unit /= units_.time * units_.time;
    if (kind == Kind::effort) unit = effort_unit(c);
    set(kind, kind == Kind::effort ? effort_index(c, option) : static_cast<int>(c), lower * unit, upper * unit);
  }

  int effort_index(CoordinateId c, const std::string& option) const {
    if (mechanism_.torque_distribution)
      throw UsageError(
          option + ": expected no torque_distribution in the spec, because limited efforts are those of least norm");
    const std::vector<CoordinateId> all = effort_coordinates();
    std::vector<std::string> names;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k] == c) return static_cast<int>(k);
      names.push_back(mechanism_.coordinates[all[k]].name);
    }
    throw UsageError(fmt::format("{}: {} has no effort; expected {}", option, mechanism_.coordinates[c].name,
                                 join_alternatives(names)));
  }

  /// Limits of a law that can be limits here: of rates, accelerations and efforts.
  void take_limits_of(const Trajectory& trajectory) {
    if (trajectory.limits.empty())
      throw UsageError(fmt::format("--limits-of: the trajectory {} has no limits", quote_for_message(trajectory.name)));
    for (const auto& limit : trajectory.limits) {
      bool is_used = false;
      for (const results::LimitableQuantity& one : results::find_limitable_quantities(mechanism_, limit.quantity)) {
        const std::size_t bracket = one.name.find('[');
        const std::string quantity = one.name.substr(0, bracket);
        const Kind kind = quantity == "joint_velocity"       ? Kind::rate
                          : quantity == "joint_acceleration" ? Kind::acceleration
                                                             : Kind::effort;
        if (bracket == std::string::npos || (kind == Kind::effort && quantity != "torque" && quantity != "force"))
          continue;
        const int coordinate = find_coordinate(one.name.substr(bracket + 1, one.name.size() - bracket - 2));
        if (coordinate < 0) continue;
        const double lower = limit.lower_bound ? *limit.lower_bound : -limit.upper_bound;
        set(kind, kind == Kind::effort ? effort_index(coordinate, "--limits-of") : coordinate, lower,
            limit.upper_bound);
        is_used = true;
      }
      if (!is_used) print_message("note: the limit of " + limit.quantity + " is not one of joints and is left out");
    }
  }

  std::vector<double> list_noise() const {
    std::vector<CoordinateId> channels = independent_;
    if (mechanism_.actuators.size() == independent_.size())
      channels.assign(mechanism_.actuators.begin(), mechanism_.actuators.end());
    std::vector<std::string> names;
    std::vector<double> units;
    for (const CoordinateId c : channels) {
      names.push_back(mechanism_.coordinates[c].name);
      units.push_back(effort_unit(c));
    }
    if (options_.has_frame_sensor) {
      const bool is_planar = mechanism_.space == SpaceKind::planar;
      const std::vector<std::string> frame = is_planar ? std::vector<std::string>{"fx", "fy", "m"}
                                                       : std::vector<std::string>{"fx", "fy", "fz", "mx", "my", "mz"};
      for (const std::string& name : frame) {
        names.push_back(name);
        units.push_back(name[0] == 'f' ? force_ : force_ * units_.length);
      }
    }
    std::vector<double> noise_deviations(names.size(), 0);
    for (const std::string& text : options_.noise_deviations) {
      const auto [name, number] = split_assignment(text, "--noise", "CHANNEL=NUMBER");
      const double value = parse_number_option(number, "--noise " + name);
      if (!(value > 0)) throw UsageError(fmt::format("--noise {}: expected a number > 0, found {}", name, number));
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end())
        throw UsageError(fmt::format("--noise: nothing is measured at {}; expected {}{}", quote_for_message(name),
                                     join_alternatives(names), append_nearest_name(name, names)));
      const auto index = static_cast<std::size_t>(at - names.begin());
      noise_deviations[index] = value * units[index];
    }
    return noise_deviations;
  }

  const ExciteOptions& options_;
  const Study& study_;
  const Mechanism& mechanism_;
  const specification::SpecUnits units_;
  const double force_;
  const std::vector<CoordinateId> independent_;
  std::vector<ExcitationLimit> limits_;
};

identification::Excitation search_excitation(const ExciteOptions& options, const Study& study) {
  try {
    identification::ExcitationOptions request = ExciteRequest(options, study).make();
    ProgressLine line(options.spec.json);
    const InterruptGuard interrupt;
    request.on_progress = [&](double fraction) {
      line.draw_fraction("search", fraction);
      return !interrupt.was_interrupted();
    };
    return identification::find_excitation(study.mechanism, request);
  } catch (const identification::UnlimitedSpeedError& error) {
    throw UsageError(std::string(error.what()) + ": --limit rate=2 or --limit A1.rate=2,A1.effort=40");
  } catch (const identification::ExcitationError& error) {
    throw MechanismFailure("no-excitation", error.what());
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = {.file = study.spec_file}, .message = error.what()});
  }
}

void write_text(const std::string& path, const std::string& text, bool force) {
  files::AtomicFile file(path, force ? files::OverwritePolicy::replace : files::OverwritePolicy::forbid);
  file.write(text);
  file.commit();
}

ExitCode run(const ExciteOptions& options) {
  const Study study = read_study(options.spec);
  for (const std::string& warning : study.warnings) print_message("warning: " + warning);
  const std::vector<files::InputFile> inputs = list_input_files(study);
  check_standard_output({options.output, options.csv}, options.spec.json, false);
  check_output(options.output, "the spec", FileFormat::yaml, inputs, options.force);
  check_output(options.csv, "the table", FileFormat::csv, inputs, options.force);
  for (const Trajectory& trajectory : study.trajectories)
    if (!options.output.empty() && trajectory.name == options.name)
      throw UsageError(fmt::format("--name: the spec has a trajectory {} already: choose another name",
                                   quote_for_message(options.name)));
  const identification::Excitation found = search_excitation(options, study);
  std::vector<std::string> files;
  std::optional<reports::ExcitedSpec> spec;
  {
    const SignalDeferral deferred;
    if (!options.output.empty()) {
      spec = reports::format_excited_spec(study, found, options.name);
      write_text(options.output, spec->text, options.force);
      files.push_back(options.output);
    }
    if (!options.csv.empty()) {
      write_text(options.csv, reports::format_excitation_csv(study, found, 1 / options.rate), options.force);
      files.push_back(options.csv);
    }
  }
  const reports::ExcitedSpec* const written = spec ? &*spec : nullptr;
  if (options.spec.json) {
    print(files::format_json(reports::excitation_json(found, study.mechanism, study.mechanism.name, written, files)));
    return ExitCode::done;
  }
  std::string text = reports::excitation_text(found, study.mechanism, study.mechanism.name, written,
                                              choose_text_options(options.spec, study));
  for (const std::string& file : files) text += format_written_message(file);
  print_status(files, text);
  return ExitCode::done;
}

void add_excite_options(CLI::App& parser, ExciteOptions& o) {
  add_spec_options(parser, o.spec);
  parser
      .add_option("--limit", o.limits,
                  "limits in the units of the spec: A1=-90:90,A1.rate=120,A1.effort=40; rate, acceleration, effort and "
                  "position alone mean all")
      ->delimiter(',')
      ->type_name("NAME=BOUND,...")
      ->allow_extra_args(false);
  parser.add_option("--limits-of", o.limits_of, "also take the limits of this trajectory of the spec")
      ->type_name("TRAJECTORY");
  parser.add_option("--duration", o.duration, "of the motion, in the spec's unit of time")
      ->type_name("T")
      ->check(number_range_validator(1e-6, 1e9))
      ->capture_default_str();
  parser.add_option("--base-frequency", o.base_frequency, "of the lowest harmonic in Hz (default: one period)")
      ->type_name("HZ")
      ->check(number_range_validator(1e-9, 1e6));
  parser.add_option("--harmonics", o.harmonics, "of every coordinate")
      ->type_name("N")
      ->check(integer_range_validator(2, 100))
      ->capture_default_str();
  parser
      .add_option("--noise", o.noise_deviations,
                  "deviation of a measured effort, in the spec's unit (default: 1 % of the largest): A1=0.5")
      ->delimiter(',')
      ->type_name("CHANNEL=NUMBER,...")
      ->allow_extra_args(false);
  parser.add_flag("--frame", o.has_frame_sensor, "force and moment on the frame are measured as well");
  parser.add_option("--rate", o.rate, "samples per second of the measurement and of --csv")
      ->type_name("HZ")
      ->check(number_range_validator(1e-3, 1e6))
      ->capture_default_str();
  parser.add_option("--rest", o.rest_rate, "rate below which a joint counts as at rest [rad/s or m/s]")
      ->type_name("RATE")
      ->check(number_range_validator(1e-9, 1e6))
      ->capture_default_str();
  parser.add_option("--mobility", o.mobility, "least mobility of loops along the motion (0 at a singularity)")
      ->type_name("M")
      ->check(number_range_validator(1e-6, 1))
      ->capture_default_str();
  parser.add_option("--find-payload", o.payloads, "the payload of the spec is unknown, too")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_choice_validator(parser.add_option("--passive-friction", o.passive_friction, "as for balance identify")
                           ->type_name("WORD")
                           ->capture_default_str(),
                       {"none", "viscous", "dry"});
  CLI::Option* evaluations = parser
                                 .add_option("--evaluations", o.evaluations,
                                             "end the search after this many motions: the same on every machine")
                                 ->type_name("N")
                                 ->check(integer_range_validator(1, 1'000'000'000));
  parser.add_option("--seconds", o.seconds, "computing time of the search (default: 30)")
      ->type_name("S")
      ->check(number_range_validator(0.01, 1e6))
      ->excludes(evaluations);
  parser.add_option("--starts", o.starts, "random series from which the search starts")
      ->type_name("N")
      ->check(integer_range_validator(1, 21))
      ->capture_default_str();
  parser.add_option("--seed", o.seed, "of the random series")
      ->type_name("N")
      ->check(integer_range_validator(0, study::max_seed))
      ->capture_default_str();
  parser.add_option("-o,--output", o.output, "write the spec with the motion as a trajectory")->type_name("FILE");
  parser.add_option("--name", o.name, "of the trajectory")
      ->type_name("NAME")
      ->check(not_blank_validator("a name"))
      ->capture_default_str();
  parser.add_option("--csv", o.csv, "write time, positions and rates for the robot's controller")->type_name("FILE");
  parser.add_flag("--force", o.force, "overwrite existing files");
  add_units_option(parser, o.spec.units);
}

}  // namespace

Command setup_excite(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("excite", "Find a motion along which to measure for identify");
  const auto options = std::make_shared<ExciteOptions>();
  add_excite_options(*parser, *options);
  parser->footer(
      "Every independent coordinate follows a Fourier series that begins and ends at rest. Among the series within\n"
      "the limits, the one is sought whose measurement determines the base parameters best: with the largest\n"
      "determinant of the information. Random series within the same limits are the comparison.\n\n"
      "Examples:\n"
      "  balance excite arm.yaml --limit rate=2,effort=40 -o arm-excited.yaml\n"
      "  balance excite 5r.yaml --limit A1=-90:90,A2=0:180,rate=300 --csv motion.csv\n"
      "  balance excite arm.yaml --limits-of fastest --evaluations 500 --json");
  return {parser, [options] { return run(*options); }};
}

}  // namespace balance::app
