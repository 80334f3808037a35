#include "design_front.hpp"

#include "answers.hpp"
#include "console.hpp"
#include "failure.hpp"
#include "signals.hpp"
#include "watched_search.hpp"

#include "balance/base/error.hpp"
#include "balance/base/nearest.hpp"
#include "balance/present/design_json.hpp"
#include "balance/present/design_text.hpp"
#include "balance/present/front_view.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace balance::app {
namespace {

constexpr const char* middle = "middle";

/// Index of the point that the option names; −1: none.
int choose_point(const std::string& name, const ParetoFront& front) {
  if (name.empty() || front.points.empty()) return -1;
  if (name == middle) return find_compromise_point(front);
  const auto count = static_cast<int>(front.points.size());
  const int k = std::stoi(name);
  if (k > count) throw UsageError(fmt::format("--point {}: the front has {} point{}", k, count, count == 1 ? "" : "s"));
  return k - 1;
}

/// A point's design with what is told of it.
struct FrontDesign {
  std::string spec, text, json;
};

FrontDesign make_front_design(const DesignStudyOptions& wanted, const DesignSpace& space, const ParetoPoint& point) {
  FrontDesign chosen;
  DesignReport report = make_pareto_design(space, point, wanted.compare_trajectories);
  chosen.spec = designed_spec_or_throw(space, report);
  const DesignReportData view = make_design_data(wanted, point.space, chosen.spec, std::move(report));
  chosen.text = design_text(view);
  chosen.json = design_json(view, {});
  return chosen;
}

std::vector<std::string> write_files(const DesignCommandOptions& options, const DesignSpace& space,
                                     const std::string& balanced, const FrontReportData& view) {
  WriteOptions write;
  write.existing = options.force ? OverwritePolicy::replace : OverwritePolicy::forbid;
  write.is_cancelled = [] { return pending_signal() != 0; };
  const SignalDeferral deferred;
  std::vector<std::string> files;
  const auto put = [&](const std::string& path, const std::string& text) {
    if (path.empty()) return;
    AtomicFile file(path, write.existing);
    file.write(text);
    throw_if_cancelled(write);
    file.commit();
    files.push_back(path);
  };
  if (!balanced.empty()) put(options.output, balanced);
  put(options.csv, front_csv(view));
  if (!options.h5.empty()) {
    write_front(options.h5, view, describe(options, space.start), write);
    files.push_back(options.h5);
  }
  return files;
}

}  // namespace

bool is_front_requested(const DesignCommandOptions& options, const Study& study) {
  return study.design.front && options.minimize.empty();
}

void check_front_options(const DesignCommandOptions& options, const Study& study) {
  const bool number = !options.point.empty() && options.point.size() < 6 && options.point[0] != '0' &&
                      options.point.find_first_not_of("0123456789") == std::string::npos;
  if (!options.point.empty() && options.point != middle && !number)
    throw UsageError(
        fmt::format("--point {}: expected the number of a point, from 1, or middle", quote_for_message(options.point)));
  if (!is_front_requested(options, study)) {
    for (const auto& [name, value] : {std::pair("--point", options.point), std::pair("--csv", options.csv)})
      if (!value.empty())
        throw UsageError(
            fmt::format("{} is for specs that ask for a front (design: front), and without --minimize", name));
    return;
  }
  if (!options.output.empty() && options.point.empty())
    throw UsageError("--output writes one design, and a front has several: choose one by --point K or --point middle");
}

ParetoFront find_front_or_throw(const DesignSpace& space, const DesignStudyOptions& options) {
  try {
    ParetoFront front = compute_pareto_front(space, options);
    if (front.points.empty())
      if (const RequestFailure refusal = find_failure(front.failure))
        throw MechanismFailure(refusal.status, refusal.reason);
    return front;
  } catch (const std::invalid_argument& error) {
    throw SpecError({.place = {.file = space.start.spec_file, .key = "design"}, .message = error.what()});
  }
}

ExitCode run_front(const DesignCommandOptions& options, const DesignSpace& space) {
  const DesignStudyOptions wanted = make_study_options(options, space.start);
  std::optional<double> interrupted;
  ParetoFront front = run_interruptible_search(
      options, wanted, "searching the front, Ctrl-C ends it with the points so far", interrupted,
      [&](const DesignStudyOptions& watched) { return find_front_or_throw(space, watched); });
  FrontReportData view = make_front_report_data(wanted, space, std::move(front));
  view.interrupted = interrupted;
  const int k = choose_point(options.point, view.front);
  FrontDesign chosen;
  if (k >= 0) chosen = make_front_design(wanted, space, view.front.points[static_cast<std::size_t>(k)]);
  const std::vector<std::string> files = write_files(options, space, chosen.spec, view);
  if (options.spec.json) {
    print(front_json(view, files, chosen.json));
  } else if (!options.quiet) {
    std::string text = front_text(view);
    if (k >= 0) text += fmt::format("\npoint {}\n", k + 1) + chosen.text;
    std::string lines;
    for (const std::string& file : files) lines += format_written_message(file);
    print_status(files, text + (lines.empty() ? "" : "\n" + lines));
  }
  return view.front.points.empty() ? ExitCode::not_met : ExitCode::done;
}

}  // namespace balance::app
