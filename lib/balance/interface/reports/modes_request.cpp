#include "balance/interface/reports/modes_request.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/interface/specification/spec_locations.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace balance::reports {

namespace {

constexpr int default_sweep_count = 101, max_sweep_count = 100'000;

struct SweepRange {
  std::string name;
  double from = 0, to = 0;
  int count = default_sweep_count;
};

[[noreturn]] void fail_sweep(const std::string& text) {
  throw SweepError(
      fmt::format("--sweep {}: expected NAME=FROM:TO or NAME=FROM:TO:COUNT, FROM less than TO and from 2 to {} "
                  "values, such as v=1:10:91",
                  quote_for_message(text), max_sweep_count));
}

/// "v=1:10:91"
SweepRange parse_sweep(const std::string& text) {
  SweepRange range;
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos) fail_sweep(text);
  range.name = text.substr(0, equals);
  const char *at = text.data() + equals + 1, *const end = text.data() + text.size();
  bool is_finished = false;
  const auto read = [&](auto& number) {
    const auto [rest, error] = std::from_chars(at, end, number);
    if (error != std::errc() || (rest != end && *rest != ':') || rest + 1 == end) fail_sweep(text);
    is_finished = rest == end;
    at = is_finished ? end : rest + 1;
  };
  read(range.from);
  if (is_finished) fail_sweep(text);
  read(range.to);
  if (!is_finished) read(range.count);
  if (!is_finished || !std::isfinite(range.from) || !std::isfinite(range.to) || !(range.from < range.to) ||
      range.count < 2 || range.count > max_sweep_count)
    fail_sweep(text);
  return range;
}

/// The mechanism and its trajectory at the values of a sweep.
class Sweep {
 public:
  Sweep(const Study& study, const Trajectory* trajectory, const std::string& text, const files::DisplayUnit& speed_unit)
      : study_(study), trajectory_(trajectory), range_(parse_sweep(text)), document_(study.spec_text) {
    if (trajectory != nullptr && trajectory->free_motion)
      turning_ = vibration::find_driven_turning(study.mechanism, *trajectory);
    if (turning_ && turning_->coordinate != range_.name) turning_.reset();
    swept_ = {range_.name, turning_ ? speed_unit.name : ""};
    if (!turning_) {
      static_cast<void>(case_at(range_.from));  // an unknown name is reported at once
      return;
    }
    speed_factor_ = std::copysign(speed_unit.factor, turning_->speed);
    if (!(range_.from > 0))
      throw SweepError(fmt::format("--sweep {}: a speed is above zero, whichever way {} turns", quote_for_message(text),
                                   range_.name));
  }

  const SweptNumber& swept() const { return swept_; }

  std::vector<double> list_values() const {
    std::vector<double> values;
    for (int k = 0; k + 1 < range_.count; ++k)
      values.push_back(range_.from + (range_.to - range_.from) * k / (range_.count - 1));
    values.push_back(range_.to);
    return values;
  }

  vibration::SweptCase case_at(double value) const {
    if (turning_) return {study_.mechanism, vibration::change_speed(*trajectory_, *turning_, speed_factor_ * value)};
    ReadOptions changed{.set = study_.overrides};
    changed.set.emplace_back(range_.name, fmt::format("{:.17g}", value));
    const Study study = read_spec(document_, study_.spec_file, changed);
    if (trajectory_ == nullptr) return {study.mechanism, {}};
    return {study.mechanism, study::choose_trajectory(study, trajectory_->name)};
  }

 private:
  const Study& study_;
  const Trajectory* trajectory_;
  SweepRange range_;
  specification::SpecDocument document_;
  std::optional<results::UniformTurning> turning_;  ///< whose speed is swept; none: a parameter
  double speed_factor_ = 1;
  SweptNumber swept_;
};

const Trajectory* choose_modes_trajectory(const Study& study, const std::string& name) {
  if (!name.empty()) return &study::choose_trajectory(study, name);
  for (const Trajectory& trajectory : study.trajectories)
    if (trajectory.free_motion) return &trajectory;
  return study.trajectories.empty() ? nullptr : &study.trajectories.front();
}

void sweep_into(const Sweep& sweep, const ModesRequest& request, const simulation::Progress& progress,
                VibrationReportData& view) {
  view.swept = sweep.swept();
  view.sweep = vibration::sweep_speeds([&](double value) { return sweep.case_at(value); },
                                       {sweep.list_values(), request.exact, request.orders}, progress);
}

/// @throws SpecError in place of what does not go with the trajectory
template <class Compute>
void compute_along(const Study& study, const Trajectory* trajectory, const Compute& compute) {
  try {
    compute();
  } catch (const SweepError&) {
    throw;
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = trajectory != nullptr ? specification::locate_trajectory(study, *trajectory)
                                                    : SourceLocation{.file = study.spec_file},
                     .message = error.what()});
  }
}

}  // namespace

VibrationReportData analyse_modes(const Study& study, const ModesRequest& request, const files::DisplayUnit& speed_unit,
                                  const simulation::Progress& progress) {
  const Trajectory* trajectory = choose_modes_trajectory(study, request.trajectory);
  VibrationReportData view{.mechanism = study.mechanism, .modes = {}, .warnings = study.warnings};
  compute_along(study, trajectory, [&] {
    std::optional<Sweep> sweep;  // what is wrong with it is said first
    if (!request.sweep.empty()) sweep.emplace(study, trajectory, request.sweep, speed_unit);
    view.modes = vibration::find_vibration_modes(study.mechanism, trajectory);
    if (view.modes.motion.outcome.status != MotionStatus::done) return;
    view.response = vibration::find_forced_response(study.mechanism, trajectory, view.modes.motion,
                                                    {request.orders, request.exact > 0});
    if (sweep) sweep_into(*sweep, request, progress, view);
  });
  return view;
}

void add_sweep(const Study& study, const ModesRequest& request, const files::DisplayUnit& speed_unit,
               VibrationReportData& view) {
  const Trajectory* trajectory = choose_modes_trajectory(study, request.trajectory);
  compute_along(study, trajectory,
                [&] { sweep_into(Sweep(study, trajectory, request.sweep, speed_unit), request, {}, view); });
}

files::Provenance make_modes_provenance(const Study& study, const std::string& trajectory,
                                        const ModesRequest& request) {
  std::vector<std::string> words = {"balance", "modes", std::filesystem::path(study.spec_file).filename().string()};
  if (!trajectory.empty()) words.insert(words.end(), {"--trajectory", trajectory});
  if (!request.sweep.empty()) words.insert(words.end(), {"--sweep", request.sweep});
  if (request.orders != ModesRequest{}.orders) words.insert(words.end(), {"--orders", std::to_string(request.orders)});
  if (request.exact != ModesRequest{}.exact) words.insert(words.end(), {"--exact", std::to_string(request.exact)});
  files::append_overrides(words, study);
  files::Provenance description = files::make_provenance(study, files::join_command(std::move(words)));
  description.trajectory = trajectory;
  return description;
}

}  // namespace balance::reports
